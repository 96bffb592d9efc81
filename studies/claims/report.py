"""The study of claims as tables for the terminal."""

from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.compare import Comparison
from dem.analysis.statistics import LEVEL
from dem.analysis.tables import numbers
from dem.base.errors import InputError
from dem.io.dataset import content_of
from studies.claims.evidence import from_study, rows, scaled
from studies.claims.influence import influences, responses
from studies.claims.remains import Remaining, remaining, words
from studies.claims.sentences import CLAIMS, ratio
from studies.claims.verdicts import Share, Verdict, evidence_in, judge

NEEDS = ("run_part", "run_drag", "jam_fraction", "run_factor")  # variables of the file
ATTRIBUTES = ("window_start", "window_stop")

OTHER_MARGINS = (0.10, 0.25)
RANKED = 4  # influences that are listed
UNLOADED = 1.0  # N/m: walls of beds below jamming bear less
SETTINGS = (
    "velocity", "diameter", "width", "width, equal distance", "height", "height, equal distance",
)  # fmt: skip


def summary(dataset: xr.Dataset) -> Group:
    """Renderable summary of claims.nc."""
    found = judge(from_study(dataset))
    parts = [
        Text(dataset.attrs["title"], style="bold"), Text(dataset.attrs.get("versions", "")),
        Text(failures(dataset)), claims(found), Text(legend(found), style="dim"),
        Text(margins(dataset)), heading("Where beds jam"), jamming(dataset),
        heading("Shapes at equal packing fraction, distance from jamming and load"),
        remains(remaining(dataset)), heading("What decides the drag over the plausible space"),
        ranking(from_study(dataset).points), heading("Other sizes and velocities"), scaling(dataset),
        heading("The claims in detail"), *map(detail, found),
    ]  # fmt: skip
    return Group(*parts)


def heading(text: str) -> Text:
    return Text(f"\n{text}", style="bold")


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
    level = 100.0 * found[0].level
    return (
        f"Ratios of means over runs, with 95 % intervals. A verdict takes intervals at {level:.2f} %, so\n"
        "that all hold together: supported if the whole interval lies where the sentence says,\n"
        "contradicted if none of it does. Space: at how many points of the plausible space, one bed each,\n"
        "the claim holds; paper: in how many single beds at the paper's values.\n"
        "One claim in full: python -m studies claims test FILE --claim NAME"
    )


def claims(found: list[Verdict]) -> Table:
    """One row per comparison, the verdict and the shares on the first of each claim."""
    made = numbers("claim", "compared", "number, 95 % interval", "runs", "verdict", "space, %", "paper, %", words=2)  # fmt: skip
    for each in found:
        last = each.verdict, per_cent(each.space), per_cent(each.paper)
        for number, part in enumerate(each.comparisons or [None]):
            middle = ("-",) * 3 if part is None else (part.words, span(part), str(part.runs))
            ends = (each.claim.title, last) if number == 0 else ("", ("",) * 3)
            made.add_row(ends[0], *middle, *ends[1])
    return made


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


def margins(dataset: xr.Dataset) -> str:
    """Which verdicts hang on the margin."""
    usual = {v.claim.name: v.verdict for v in judge(from_study(dataset))}
    told = []
    for margin in OTHER_MARGINS:
        other = judge(from_study(dataset, margin))
        moved = [f"{v.claim.title}: {v.verdict}" for v in other if v.verdict != usual[v.claim.name]]
        told.append(
            f"With a margin of {100 * margin:.0f} %: {'; '.join(moved) or 'the same verdicts'}."
        )
    return "\n".join(told)


def failures(dataset: xr.Dataset) -> str:
    """How many runs there are and how many of them failed, and of what."""
    status, part = dataset["run_status"].values.astype(str), dataset["run_part"].values.astype(str)
    wrong = [
        f"{int(((status == each) & (part == name)).sum())} {each} in {name}"
        for name in dict.fromkeys(part)
        for each in sorted(set(status[part == name]) - {"ran"})
    ]
    spent = float(dataset["run_spent"].sum())
    return f"{status.size} runs, {spent / 60:.0f} min of processor time; failed: {', '.join(wrong) or 'none'}."  # fmt: skip


def jamming(dataset: xr.Dataset) -> Table:
    """Jamming fractions by shape and friction, with the interval of the mean."""
    frictions = np.unique(dataset["jam_friction"].values)
    made = numbers("shape", *(f"friction {mu:g}" for mu in frictions), "beds")
    for shape in dict.fromkeys(dataset["jam_shape"].values.tolist()):
        mine = dataset["jam_shape"].values == shape
        cells = []
        for mu in frictions:
            some = dataset["jam_fraction"].values[mine & (dataset["jam_friction"].values == mu)]
            each = Comparison("", some, None, 0.0, 1.0)
            low, high = each.interval() if len(some) else (np.nan, np.nan)
            cells.append(f"{each.estimate:.4f} ({low:.4f} to {high:.4f})" if len(some) else "-")
        made.add_row(
            str(shape), *cells, str(int((mine & (dataset["jam_friction"].values == 0)).sum()))
        )
    return made


def remains(found: list[Remaining]) -> Table:
    """What is left of the effect of shape."""
    made = numbers("shape", "state", "V_f", "load, kN/m", "drag over the first case's, 95 %", "part of the effect that remains, 95 %", "runs", words=2)  # fmt: skip
    for each in found:
        made.add_row(
            each.shape, each.state, f"{each.fraction:.4f}", f"{1e-3 * each.load:.3g}",
            "{:.2f} ({:.2f} to {:.2f})".format(*each.ratio), words(each), str(each.runs),
        )  # fmt: skip
    return made


def ranking(points: xr.Dataset) -> Table:
    """What decides the drag and the ratios of drags, the most influential first."""
    made = numbers(
        "what", "decided by", "grows over the range by, 95 %", "share of variance", words=2
    )
    for name, response in responses(points).items():
        for number, each in enumerate(influences(points, response)[:RANKED]):
            grows = f"{each.growth:.2f} ({each.low:.2f} to {each.high:.2f})"
            made.add_row(name if number == 0 else "", each.factor, grows, f"{each.share:.2f}")
    return made


def scaling(dataset: xr.Dataset) -> Table:
    """Drag at other sizes and velocities over that at the sweep's own."""
    made = numbers(
        "shape",
        "what",
        "factor",
        "drag over that at 1, 95 %",
        "runs",
        "load over that at 1",
        words=2,
    )
    for setting in SETTINGS:
        for shape in dict.fromkeys(rows(dataset, "scaling")["run_case"].values.tolist()):
            for x, drag, load in scaled_ratios(dataset, setting, shape):
                made.add_row(
                    shape,
                    setting,
                    f"{x:g}",
                    span(drag),
                    str(drag.runs),
                    f"{load:.2f}" if np.isfinite(load) else "-",
                )
    return made


def scaled_ratios(dataset: xr.Dataset, setting: str, shape: str) -> list:
    """Factor, drag over that at factor 1 and load over that at factor 1, factor 1 itself left out;
    only runs that differ in velocity are on the same beds."""
    runs = scaled(dataset, setting, shape)
    found = []
    for x in runs["case"].values.tolist():
        if x != 1.0:
            (drag,) = ratio(runs, "drag", x, 1.0, paired=setting == "velocity") or (None,)
            load = runs["load"].mean("seed")
            if drag is not None and drag.runs > 1:
                base = float(load.sel(case=1.0))
                there = float(load.sel(case=x)) / base if base > UNLOADED else np.nan
                found.append((x, drag, there))
    return found
