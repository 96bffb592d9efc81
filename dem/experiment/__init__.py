"""The experiment of the paper: its configuration, what fits, one run and its observables.

In: a configuration, a shape, a density and a seed. Out: the values of one run. Here you may add a
value of the configuration (sections), or an observable of a run (observables).
"""
