"""How many runs does a curve take by a grid, by a Latin hypercube and by points that are refined?"""
