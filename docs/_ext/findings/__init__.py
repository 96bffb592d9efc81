"""Every result that a page or the README states, read from released files: one module per question.

A page calls a finding by its name: `{{ drag.mean("c1") }}`, `{{ table(claims.verdicts()) }}`. No
result is typed on a page; tests/pages/test_pages.py looks for those that are. A sentence that depends on
a result says on which: `{{ holds("Ellipses drag less than discs", drag.falls("c1", "e1")) }}`. Tables of
the reference come from the code: `{{ reference.keys() }}`.
docs/write_pages.py writes the pages.
"""

from importlib import import_module

import reference
from jinja2 import Environment, StrictUndefined

import dem
import studies
from studies.common.findings import (
    Findings,
    clock,
    estimate,
    holds,
    interval,
    percent,
    table,
)

from . import drag, ratios, scale

TEMPLATES = Environment(
    undefined=StrictUndefined,
    comment_start_string="<#",
    comment_end_string="#>",
    keep_trailing_newline=True,
)
FORMATS = {"clock": clock, "estimate": estimate, "interval": interval, "percent": percent}
TEMPLATES.filters |= FORMATS
OF_STUDIES = [import_module(f"{studies.package_of(name)}.findings") for name in studies.NAMES]
NAMES = (
    FORMATS
    | {"table": table, "holds": holds, "ratios": ratios.ratios}
    | {"reference": reference, "version": dem.__version__}
    | {
        name: getattr(module, name)
        for module in (drag, scale, *OF_STUDIES)
        for name in module.__all__
    }
)
# written by docs/data/release.py
FILES = list(
    {
        each.path: each
        for module in (drag, *OF_STUDIES)
        for each in vars(module).values()
        if isinstance(each, Findings)
    }.values()
)
MEASURED = [scale.ensembles, scale.overhead]  # by scripts


def fill(text: str) -> str:
    """A page with its numbers."""
    return TEMPLATES.from_string(text).render(NAMES)
