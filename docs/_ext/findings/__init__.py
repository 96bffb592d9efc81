"""Every result that a page or the README states, read from docs/data: one module per question.

A page calls a finding by its name: `{{ drag.mean("c1") }}`, `{{ table(claims.verdicts()) }}`. No result is
typed on a page; tests/test_pages.py looks for those that are. A sentence that depends on a result says
on which: `{{ holds("Ellipses drag less than discs", drag.falls("c1", "e1")) }}`. Nothing here needs Sphinx.
"""

from jinja2 import Environment, StrictUndefined

from . import contact, dumbbells
from .accuracy import accuracy
from .calibration import calibration
from .claims import claims
from studies.common.findings import DATA, Findings, holds, interval, table
from .drag import beds, drag, flow
from .onset import onset
from .preparation import preparation
from .pressure import pressure
from .scale import ensembles, overhead
from .shear import shear
from .speed import elsewhere, processors, speed, timings
from .stability import stability
from .velocity import velocity

TEMPLATES = Environment(
    undefined=StrictUndefined,
    comment_start_string="<#",
    comment_end_string="#>",
    keep_trailing_newline=True,
)
# written by docs/data/release.py
FILES = (
    drag, flow, claims, accuracy, stability, velocity, shear, pressure, preparation, onset, speed,
)  # fmt: skip
MEASURED = ensembles, overhead, *elsewhere  # by scripts that measure, and on other processors
NAMES = {
    "table": table,
    "interval": interval,
    "holds": holds,
    "accuracy": accuracy,
    "beds": beds,
    "calibration": calibration,
    "claims": claims,
    "contact": contact,
    "drag": drag,
    "dumbbells": dumbbells,
    "ensembles": ensembles,
    "flow": flow,
    "onset": onset,
    "overhead": overhead,
    "preparation": preparation,
    "processors": processors,
    "pressure": pressure,
    "shear": shear,
    "speed": speed,
    "stability": stability,
    "timings": timings,
    "velocity": velocity,
}
__all__ = ["DATA", "FILES", "MEASURED", "NAMES", "Findings", "elsewhere", "fill", "speed"]


def fill(text: str) -> str:
    """A page with its numbers."""
    return TEMPLATES.from_string(text).render(NAMES)
