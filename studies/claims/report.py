"""Claims in words and numbers: one row each, or one of them in full."""

from pathlib import Path

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.compare import CONTRADICTED, SUPPORTED, UNDECIDED
from dem.analysis.tables import numbers
from dem.base.errors import InputError
from dem.base.intervals import LEVEL
from dem.io.dataset import content_of
from studies.claims.numbers import UNTESTED
from studies.claims.sentences import CLAIMS
from studies.claims.verdicts import Share, Verdict, evidence_in, judge


def verdicts(path: Path, name: str | None = None, margin: float = 0.18) -> Group:
    """Claims tested on the runs of a file, or one of them in detail; raises InputError."""
    if not 0.0 < margin < 1.0:
        raise InputError(f"margin is {margin:g}; it must lie between 0 and 1.")
    with content_of(path):
        found = judge(evidence_in(path, margin))
    if name is None:
        return Group(claims(found), Text(legend(found), style="dim"))
    chosen = [each for each in found if each.claim.name == name]
    if not chosen:
        names = ", ".join(claim.name for claim in CLAIMS)
        raise InputError(f"claim is {name!r}; there are {names}.")
    return detail(chosen[0])


def span(each, level: float = LEVEL) -> str:
    """The number with its interval."""
    low, high = each.interval(level)
    return f"{each.estimate:.3g} ({low:.3g} to {high:.3g})"


def per_cent(share: Share | None) -> str:
    """A share of worlds in which a claim holds."""
    return "-" if share is None else f"{100 * share.share:.0f} ({100 * share.low:.0f}\N{EN DASH}{100 * share.high:.0f})"  # fmt: skip


def legend(found: list[Verdict]) -> str:
    """The table of claims."""
    return (
        f"Intervals are of 95 %; a verdict takes intervals at {100 * found[0].level:.2f} %, so that all hold together.\n"
        "One claim in full: python -m studies claims test FILE --claim NAME"
    )


def claims(found: list[Verdict]) -> Table:
    """One row per claim; those that do not hold come first."""
    order = [CONTRADICTED, UNDECIDED, SUPPORTED, UNTESTED]
    made = numbers(
        "claim (section)", "verdict", "numbers", "holds in the\nplausible space, %", words=3
    )
    made.columns[2].no_wrap = False  # for a terminal
    for each in sorted(found, key=lambda each: order.index(each.verdict)):
        parts = "\n".join(
            f"{part.words}: {on_one_line(span(part))}; claimed {claimed(part)}"
            for part in each.comparisons
        )
        title = f"{each.claim.title} ({each.claim.place})"
        made.add_row(title, f"**{each.verdict}**", parts, per_cent(each.space))
    return made


def on_one_line(words: str) -> str:
    return words.replace(" ", "\N{NO-BREAK SPACE}")


def claimed(part) -> str:
    """The range that a claim gives for a number."""
    if part.high == np.inf:
        return f"above {part.low:.3g}"
    if part.low == 0.0 and part.is_ratio:
        return f"below {part.high:.3g}"
    return f"{'not ' if part.outside else ''}{part.low:.5g} to {part.high:.5g}"


def detail(found: Verdict) -> Group:
    """One claim: the sentence, how it is read, the comparisons and the verdict."""
    claim = found.claim
    lines = [f"\n{claim.name}: {found.verdict}", f'  "{claim.quote}" ({place(claim.place)})', f"  {claim.reading}"]  # fmt: skip
    lines += [
        f"  {each.words}: {span(each)} at 95 %, {span(each, found.level)} at {100 * found.level:.2f} %; "
        f"claimed: {claimed(each)}; {each.runs} runs"
        for each in found.comparisons
    ]
    for name, share in (("points of the plausible space", found.space), ("single beds at the paper's values", found.paper)):  # fmt: skip
        if share:
            lines.append(f"  holds at {per_cent(share)} % of {share.points} {name}; {share.failed} more failed")  # fmt: skip
    return Group(*map(Text, lines))


def place(where: str) -> str:
    """A place in the paper in words."""
    return where if where[0].isalpha() else f"section {where}"
