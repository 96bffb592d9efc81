"""From plain functions to kernels: what a scene lacks is decided, the rest is compiled and kept on disk.

In: Python functions, what the scene has, classes of shapes and laws. Out: machine code, kept for all
copies of the same sources. Here you may change how kernels are put together, how a class answers their
questions, where machine code is kept, and which instructions compilers do not choose by themselves; no
physics.
"""
