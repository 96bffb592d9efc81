"""What a run records, by name: one module each, loaded when it is asked for.

In: what a run has seen (dem.experiment.drag.Seen). Out: variables. A new observable is a file here:
VARIABLES, its layout (name: dimensions, units, long name), `measure(seen) -> dict` of values by these
names, and LEDGER = True if the simulation has to keep an energy ledger.
"""

from importlib import import_module
from pkgutil import iter_modules

# found and not listed, so that a new one is no other code of runs that do not record it
OBSERVABLES = tuple(sorted(module.name for module in iter_modules(__path__)))


def module_of(name: str):
    """The module of an observable."""
    return import_module(f"{__name__}.{name}")
