"""The experiment of the paper: its configuration, what fits, one run and its observables.

In: a configuration, a shape, a density and a seed. Out: the values of one replicate. Here you may
add a configuration value (config) or an observable of a run (drag).
"""
