"""What a run records, by name: one module each, loaded when it is asked for.

A new observable is a file here, or beside a sweep file. It has VARIABLES, a layout (name:
dimensions, units, long name) that is read without running the file, and one or both of two
functions that return values by these names: `look(simulation)` at each snapshot, and
`measure(run)` at the end, from what the run recorded (dem.experiment.phases.RunData). Dimensions of
its own are SIZES, AXIS and axes, as of kinds of experiment (dem.experiment.kinds). It has LEDGER =
True if the simulation must keep an energy ledger, and NEEDED = {variable: path} of variables that are
there only where the configuration has a value at a path, and SECTIONS of the configuration that it needs.
"""

from pathlib import Path

from dem.base.declarations import described
from dem.base.plugins import find_module

# Found and not listed, so that a new one does not change the code of runs without it.
OBSERVABLES = described(Path(__file__).parent, "VARIABLES")


def file_of(name: str, beside: str | None = None) -> Path:
    """The file of an observable; raises InputError where it cannot be used."""
    if name in OBSERVABLES:
        return Path(__file__).with_name(f"{name}.py")
    kinds = (path.stem for path in sorted(Path(__file__).parents[1].glob("kinds/[a-z]*.py")))
    known = *OBSERVABLES, *kinds  # whose files of results have these names
    return find_module("record.observables", name, beside, known, "measure", "look")
