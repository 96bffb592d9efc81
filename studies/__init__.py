"""Questions with runs of their own: accuracy, stability, the paper's claims, speed, calibration.

In: a configuration. Out: one file per study (accuracy.nc, stability.nc, claims.nc, benchmark.nc)
and its tables. Each study is a folder that imports no other; peers are the codes to compare with.
"""
