"""One file per figure: `plot(dataset) -> Figure`, no physics. A new figure is one file.

Constants at its top say what it is, and are read without importing it (`catalogue.py`):

FILE       file of results that it is drawn from, without .nc: what runs record, such as drag
CAPTION    what it shows
CASES      it needs runs by case, or shape, and seed alone: {} for any; {"any": labels} or
           {"all": labels} of shapes, or {"densities": 2}
AXES       it needs so many values along these axes: {"cylinder_velocity": 4}
VARIABLES  the file must hold these; if absent drag of a file drag, granule_x of a file snapshots,
           run_id of others
"""

import lazy_loader

__getattr__ = lazy_loader.attach(__name__, ["plot"])[0]  # dem.plot of ../__init__.pyi
