"""What a run records, by name: one module each, loaded when it is asked for.

A new observable is a file here. It has VARIABLES, a layout (name: dimensions, units, long name),
and one or both of two functions that return values by these names: `look(simulation)` at each
snapshot, one number a variable, and `measure(seen)` at the end, from what the run saw
(dem.experiment.kinds.drag.Seen). It has LEDGER = True if the simulation must keep an energy ledger.
"""

from importlib import import_module
from pkgutil import iter_modules

# Found and not listed, so that a new one does not change the code of runs without it.
OBSERVABLES = tuple(sorted(module.name for module in iter_modules(__path__)))


def module_of(name: str):
    """The module of an observable."""
    return import_module(f"{__name__}.{name}")
