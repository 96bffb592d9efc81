"""Beds at rest: random, swollen, compacted, at a pressure, settled; the minimiser.

In: a shape, a box, a cylinder, a seed. Out: a Bed. Here you may add another way to make a bed.
"""
