"""How often is the mean as near as was asked for?"""
