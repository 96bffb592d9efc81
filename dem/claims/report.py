"""The study of claims as tables for the terminal."""

from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.claims.compare import LEVEL, Comparison
from dem.claims.evidence import from_study, rows, table
from dem.claims.influence import Influence, influences, responses
from dem.claims.remains import Remaining, remaining
from dem.claims.sentences import CLAIMS, ratio
from dem.claims.verdicts import Verdict, evidence_in, judge
from dem.errors import InputError
from dem.tables import numbers

LEGEND = """\
Ratios of means over runs with their 95 % intervals. A verdict takes intervals so wide that all of
them hold together: supported if the whole interval lies where the sentence says, contradicted if
none of it does. Plausible space: share of the points of the design, one bed each, at which it
holds. More of a claim: dem claims test FILE --claim NAME."""


def summary(dataset: xr.Dataset) -> Group:
    """Renderable summary of claims.nc."""
    found = from_study(dataset)
    parts = [Text(dataset.attrs["title"], style="bold"), Text(dataset.attrs.get("versions", "")), claims(judge(found))]  # fmt: skip
    parts += [Text(LEGEND, style="dim"), Text(failures(dataset)), jamming(dataset)]
    parts += [remains(remaining(dataset)), *rankings(found), scaling(dataset)]
    return Group(*parts)


def verdicts(path: Path, name: str | None = None) -> Group:
    """Claims tested on the runs of a file, or one of them in detail; raises InputError."""
    found = judge(evidence_in(path))
    if name is None:
        return Group(claims(found), Text(LEGEND, style="dim"))
    chosen = [each for each in found if each.claim.name == name]
    if not chosen:
        names = ", ".join(claim.name for claim in CLAIMS)
        raise InputError(f"claim is {name!r}; there are {names}.")
    return detail(chosen[0])


def span(comparison: Comparison, level: float = LEVEL) -> str:
    """The number with its interval."""
    low, high = comparison.interval(level)
    return f"{comparison.estimate:.3g} ({low:.3g} to {high:.3g})"


def claims(found: list[Verdict]) -> Table:
    """A row a comparison, the verdict and the share of the space on the first of each claim."""
    made = numbers("claim", "section", "compared", "number, 95 % interval", "runs", "verdict", "plausible space, %")  # fmt: skip
    for each in found:
        share = each.share
        space = f"{100 * share.share:.0f} ({100 * share.low:.0f} to {100 * share.high:.0f})" if share else "-"  # fmt: skip
        first = each.claim.name, each.claim.place
        last = each.verdict, space
        for number, comparison in enumerate(each.comparisons or [None]):
            middle = ("-", "-", "-") if comparison is None else (
                comparison.words, span(comparison), str(comparison.runs),
            )  # fmt: skip
            ends = (first, last) if number == 0 else (("", ""), ("", ""))
            made.add_row(*ends[0], *middle, *ends[1])
    return made


def detail(found: Verdict) -> Group:
    """One claim: the sentence, how it is read, the comparisons and the verdict."""
    claim = found.claim
    lines = [f'"{claim.quote}" (section {claim.place})', f"Read as: {claim.reading}", ""]
    for each in found.comparisons:
        low = "0" if each.low == 0.0 else f"{each.low:.3g}"
        claimed = f"above {low}" if not np.isfinite(each.high) else f"{low} to {each.high:.3g}"
        lines.append(f"{each.words}: {span(each)} at 95 %, {span(each, found.level)} at "
                     f"{100 * found.level:.2f} %; claimed: {claimed}; {each.runs} runs")  # fmt: skip
    lines += ["", f"{claim.title}: {found.verdict}"]
    if found.share:
        lines.append(f"It holds at {100 * found.share.share:.0f} % of {found.share.points} points of the plausible space, one bed each.")  # fmt: skip
    return Group(*map(Text, lines))


def failures(dataset: xr.Dataset) -> str:
    """How many runs there are and how many of them failed, and of what."""
    status = dataset["run_status"].values.astype(str)
    wrong = [f"{int((status == each).sum())} {each}" for each in sorted(set(status) - {"ran"})]
    spent = float(dataset["run_spent"].sum())
    return f"{status.size} runs, {spent / 60:.0f} min of processor time; failed: {', '.join(wrong) or 'none'}."


def jamming(dataset: xr.Dataset) -> Table:
    """Jamming fractions by shape and friction, with the interval of the mean."""
    frictions = np.unique(dataset["jam_friction"].values)
    made = numbers("shape", *(f"jams at, friction {mu:g}" for mu in frictions), "beds")
    for shape in dict.fromkeys(dataset["jam_shape"].values.tolist()):
        beds = [
            dataset["jam_fraction"].values[
                (dataset["jam_shape"].values == shape) & (dataset["jam_friction"].values == mu)
            ]
            for mu in frictions
        ]
        cells = [span(Comparison("", each, None, 0.0, 1.0)) for each in beds]
        made.add_row(str(shape), *cells, str(len(beds[0])))
    return made


def remains(found: list[Remaining]) -> Table:
    """What is left of the effect of shape."""
    made = numbers("shape", "state", "V_f", "pressure, MPa", "drag over c1, 95 %", "part of the effect that remains, 95 %")  # fmt: skip
    for each in found:
        made.add_row(
            each.shape, each.state, f"{each.fraction:.4f}", f"{1e-6 * each.pressure:.3g}",
            "{:.2f} ({:.2f} to {:.2f})".format(*each.ratio),
            "{:.2f} ({:.2f} to {:.2f})".format(*each.part),
        )  # fmt: skip
    return made


def rankings(found) -> list[Table]:
    """What decides the drag and the ratios of drags, the three most influential each."""
    made = numbers("what", "decided by", "share of variance", "grows over the range by, 95 %")
    for name, response in responses(found).items():
        for number, each in enumerate(influences(found, response)[:4]):
            made.add_row(name if number == 0 else "", *_cells(each))
    return [made] if made.row_count else []


def _cells(each: Influence):
    return (
        each.factor, f"{each.share:.2f} +- {each.half:.2f}",
        f"{each.change:.2f} ({each.low:.2f} to {each.high:.2f})",
    )  # fmt: skip


def scaling(dataset: xr.Dataset) -> Table:
    """Drag at other sizes and velocities over that at the sweep's own."""
    made = numbers("shape", "what", "factor", "drag over that at 1, 95 %", "runs")
    part = rows(dataset, "scaling")
    for setting in dict.fromkeys(part["run_setting"].values.tolist()):
        for shape in dict.fromkeys(part["run_case"].values.tolist()):
            for x, each in scaled(dataset, setting, shape):
                made.add_row(shape, setting, f"{x:g}", span(each), str(each.runs))
    return made


def scaled(dataset: xr.Dataset, setting: str, shape: str) -> list[tuple[float, Comparison]]:
    """Drag of a shape at each factor of a setting over that at 1; runs share beds where only the
    velocity differs."""
    some = rows(dataset, "scaling", setting)
    runs = table(some.isel(run=np.flatnonzero(some["run_case"].values == shape)), "run_x")
    factors = sorted(runs["case"].values.tolist())
    found = [(x, ratio(runs, "drag", x, 1.0, paired=setting == "velocity")) for x in factors]
    return [(x, each[0]) for x, each in found if each]
