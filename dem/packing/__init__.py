"""Beds at rest: grown from random places, pressed, tiled; the minimiser that brings them to rest.

In: a shape, a box, a cylinder, a seed. Out: a Bed. Here you may add another way to make a bed.
"""
