"""Blocks of contacts: where their numbers are, their geometry, their forces.

In: motion of constituents and a list of contacts. Out: forces and torques on constituents, loads on walls
and solids. Here you may change dashpot (restitution) and friction (springs) of one contact, add a force
(response) or an outline of solids (geometry), or a column (layout).
"""
