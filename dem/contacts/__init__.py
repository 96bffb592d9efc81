"""One contact, and many: the force law (scalars), the response, blocks of contacts, the loops.

In: motion of constituents and a neighbour list. Out: forces, torques, impulses on walls and
cylinder. Here you may change the force law or add one (force_law, response).
"""
