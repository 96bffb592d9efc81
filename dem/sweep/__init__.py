"""Many runs: which there are, several in one process, those that fail, all in one file.

In: a configuration. Out: a file a replicate, drag.nc. Knows nothing of what is made of the numbers.
"""
