"""Every result that a page or the README states, read from released files: one module per question.

A page calls a finding by its name: `{{ drag.mean("c1") }}`, `{{ table(claims.verdicts()) }}`. No
result is typed on a page; tests/test_pages.py looks for those that are. A sentence that depends on
a result says on which: `{{ holds("Ellipses drag less than discs", drag.falls("c1", "e1")) }}`. `{{
page("claims") }}` is the page of a study. Nothing here needs Sphinx.
"""

import re
from importlib import import_module
from os.path import relpath
from pathlib import Path

from jinja2 import Environment, StrictUndefined

import studies
from studies.common.findings import (
    ROOT,
    Findings,
    clock,
    estimate,
    holds,
    interval,
    percent,
    table,
)

from . import drag, dumbbells, scale

TEMPLATES = Environment(
    undefined=StrictUndefined,
    comment_start_string="<#",
    comment_end_string="#>",
    keep_trailing_newline=True,
)
FORMATS = {"clock": clock, "estimate": estimate, "interval": interval, "percent": percent}
TEMPLATES.filters |= FORMATS
FRONT_MATTER = re.compile(r"\A---\n.*?\n---\n+", re.S)  # not shown
OF_STUDIES = [import_module(f"{studies.package_of(name)}.findings") for name in studies.NAMES]
NAMES = (
    FORMATS
    | {"table": table, "holds": holds, "dumbbells": dumbbells}
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


def page(name: str) -> str:
    """The page of a study, for docs/results, with its numbers; links lead from there."""
    folder = ROOT / "studies" / name

    def link(found):
        target, mark, place = found[1].partition("#")
        if not target or ":" in target:
            return found[0]
        path = Path(relpath(folder / target, ROOT / "docs/results"))
        if path.name == "page.md":
            path = Path(PAGES[path.parent.name])
        return f"]({path.as_posix()}{mark}{place})"

    text = FRONT_MATTER.sub("", (folder / "page.md").read_text(encoding="utf-8"))
    return fill(re.sub(r"\]\(([^)\s]+)\)", link, text))


NAMES["page"] = page
# page of the documentation by study
PAGES = {
    found[1]: path.name
    for path in (ROOT / "docs/results").glob("*.md")
    if (found := re.search(r'page\("(\w+)"\)', path.read_text(encoding="utf-8")))
}
