"""Many runs: what varies, which runs that makes, where they are kept, all of them in one file.

In: a configuration file. Out: batches of runs in a store that all sweeps share; drag.nc over what
varied. A file goes through config -> axis -> expand (a block of runs) -> state, jobs (which runs
share a batch) -> store -> batch (makes the runs) -> combine.
Knows nothing of what is made of the numbers. Here you may add a form of a sweep.
"""
