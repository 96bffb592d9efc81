"""Many runs: what varies, which runs that makes, where they are kept, all of them in one file.

In: a configuration file. Out: batches of runs in a store that all sweeps share; drag.nc over what
varied. A file goes through config -> axis -> expand (a block of runs) -> state, grouping (which runs
share a job) -> store -> batch (makes the runs) -> combine. What a sweep does first that was killed:
restart.
Knows nothing of what is made of the numbers. Here you may add a form of a sweep.
"""
