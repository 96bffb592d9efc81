"""How far does a column of granules spread, and how high is what is left?"""
