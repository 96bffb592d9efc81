"""How functions are compiled and cached, what absent features cost (nothing), memory layout.

In: Python functions. Out: machine code, kept on disk for all copies of the same sources. Here you
may change decorators, how functions become parts of kernels and take their arguments, the
arithmetic of absent quantities, columns of rows and lanes of blocks; no physics.
"""
