"""The paper's sentences, tested."""

from collections import Counter
from functools import cached_property

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.drag import by_case
from dem.base.errors import InputError
from dem.base.statistics import Estimate, mean_interval
from studies.claims.compare import CONTRADICTED, SUPPORTED, UNDECIDED
from studies.claims.evidence import MARGIN, from_study, from_sweep, scaled_ratios
from studies.claims.influence import Influence, influences, responses
from studies.claims.remains import remaining
from studies.claims.verdicts import UNTESTED, Verdict, claimed, judge, span
from studies.common.findings import Findings, estimate, interval, numbers

__all__ = ["claims"]

ABOUT_SHAPE = (
    "drag_higher_in_dumbbells_than_discs",
    "drag_lower_in_dumbbells_than_discs",
    "drag_higher_in_dumbbells_than_small_discs",
    "drag_falls_for_slightly_elongated_ellipses",
    "drag_falls_further_for_longer_ellipses",
    "shape_matters",
)
RANKED = 4  # influences that are listed
WAYS = ("", ", equal distance")
SETTINGS = ("velocity", "diameter", *(size + way for size in ("width", "height") for way in WAYS))


class Claims(Findings):
    """The paper's sentences on the runs of claims.nc."""

    name, command = "claims", "snakemake -j2 claims"
    needs = "run_part", "run_drag", "jam_fraction", "run_factor"
    attributes = "window_start", "window_stop"

    @cached_property
    def judged(self) -> dict[str, Verdict]:
        return self.by_margin(MARGIN)

    def by_margin(self, margin: float) -> dict[str, Verdict]:
        """Verdicts by name, where "significantly" means more than a margin."""
        return {verdict.claim.name: verdict for verdict in judge(from_study(self.dataset, margin))}

    def changed_by(self, margin: float) -> dict[str, str]:
        """Verdicts that another margin changes, by title."""
        return {
            verdict.claim.title: verdict.verdict
            for name, verdict in self.by_margin(margin).items()
            if verdict.verdict != self.judged[name].verdict
        }

    @cached_property
    def remaining(self) -> list:
        return remaining(self.dataset)

    @cached_property
    def counts(self) -> Counter:
        """How many claims have which verdict."""
        return Counter(verdict.verdict for verdict in self.judged.values())

    @cached_property
    def influences(self) -> dict[str, dict[str, Influence]]:
        """By response and value of the configuration, those that decide first."""
        points = from_study(self.dataset).points
        ranked = {
            name: influences(points, response) for name, response in responses(points).items()
        }
        return {
            name: {influence.factor: influence for influence in some}
            for name, some in ranked.items()
        }

    def numbers(self, name: str) -> str:
        """What a claim is compared by, with 95 % intervals."""
        return "; ".join(map(span, self.judged[name].comparisons))

    def verdicts(self) -> Table:
        """One row per claim; those that do not hold come first."""
        return table_of(self.judged.values())

    def jams_at(self, shape: str, friction: float = 0.0) -> float:
        """Packing fraction at which beds of a shape jam, by the friction of granules."""
        mask = (self.dataset["jam_shape"] == shape) & (self.dataset["jam_friction"] == friction)
        return float(self.dataset["jam_fraction"].where(mask).mean())

    def jamming(self) -> Table:
        """One row per shape of the paper: where beds jam, without friction and with it."""
        heads = "shape", "jams at, without friction", "with the friction of the runs", "beds"
        table = numbers(*heads)
        names = "jam_shape", "jam_friction", "jam_fraction"
        shapes, frictions, fractions = (self.dataset[name].values for name in names)
        for shape in dict.fromkeys(row.shape for row in self.remaining):
            cells = []
            for friction in np.unique(frictions):
                mask = (shapes == shape) & (frictions == friction)
                mean = mean_interval(fractions[mask])
                cells.append(interval(mean.value, mean.half, digits=4))
            table.add_row(shape, *cells, str(np.isfinite(fractions[mask]).sum()))
        return table

    def states(self) -> Table:
        """One row per shape and state: drag over that of c1."""
        rows = (
            (
                row.shape,
                row.state,
                f"{row.fraction:.3f}",
                estimate(row.ratio),
                str(row.runs),
            )
            for row in self.remaining[1:]
        )
        return numbers("shape", "state", "V_f", "drag relative to c1", "beds", words=2, rows=rows)

    def ratio(self, shape: str, state: str) -> Estimate:
        """Drag over that of c1, of a shape at a state."""
        ratios = {(row.shape, row.state): row.ratio for row in self.remaining}
        if (shape, state) not in ratios:
            raise InputError(f"studies/claims/claims.nc has no runs of {shape} at {state}.")
        return ratios[shape, state]

    def at(self, shape: str, state: str) -> str:
        """Drag over that of c1, of a shape at a state, with its interval."""
        return "{:.2f} ({:.2f} to {:.2f})".format(*self.ratio(shape, state))

    def above(self, shape: str, *states: str) -> bool:
        """Whether a shape at some states drags more than c1, the interval included."""
        return all(self.ratio(shape, state).low > 1.0 for state in states)

    def below(self, shape: str, *states: str) -> bool:
        """Whether a shape at some states drags less than c1, the interval included."""
        return all(self.ratio(shape, state).high < 1.0 for state in states)

    def decides(self) -> Table:
        """One row per value of influence: by how much responses grow over its range."""
        heads = "quantity", "value", "factor over its range", "share of variance"
        table = numbers(*heads, words=2)
        for name, ranked in self.influences.items():
            for influence in list(ranked.values())[:RANKED]:
                growth = f"{influence.growth:.2f} ({influence.low:.2f} to {influence.high:.2f})"
                table.add_row(
                    name, f"`{influence.factor}`", growth, f"{max(influence.share, 0.0):.2f}"
                )
                name = ""
        return table

    def scaling(self) -> Table:
        """One row per setting, shape and factor: drag over that at the paper's value."""
        rows = (
            (setting, shape, f"{x:g}", span(drag), str(drag.runs))
            for setting in SETTINGS
            for shape in ("c1", "e3")
            for x, drag in scaled_ratios(self.dataset, setting, shape).items()
        )
        return numbers(
            "varied", "shape", "factor", "drag relative to factor 1", "runs", words=2, rows=rows
        )

    def scaled(self, setting: str, shape: str, factor: float) -> str:
        """Drag at a factor on one of the paper's values, over that at the paper's, with its
        interval."""
        return estimate(scaled_ratios(self.dataset, setting, shape)[factor].known())

    def shrinks(self, setting: str, shape: str, factor: float) -> bool:
        """Whether the drag there is below that at the paper's value, the interval included."""
        return scaled_ratios(self.dataset, setting, shape)[factor].interval()[1] < 1.0

    def on(self, runs: xr.Dataset) -> dict[str, Verdict]:
        """Verdicts on runs over shape and seed of any sweep, by the name of the claim."""
        runs = by_case(runs)
        density = np.broadcast_to(runs["density"].values, runs.sizes["case"]).copy()
        evidence = from_sweep(runs.assign_coords(density=("case", density)))
        return {verdict.claim.name: verdict for verdict in judge(evidence)}

    def changed(self, runs: xr.Dataset) -> dict[str, str]:
        """Verdicts about shape on other runs that are not those of claims.nc, by name."""
        others = self.on(runs)
        return {
            name: others[name].verdict
            for name in ABOUT_SHAPE
            if others[name].verdict != self.judged[name].verdict
        }

    def beside(self, **sweeps: xr.Dataset) -> Table:
        """One row per claim about shape: verdict and numbers here, and on runs of other sweeps."""
        columns = {"the paper's box, claims.nc": self.judged}
        for name, runs in sweeps.items():
            columns[name.replace("__", ", ").replace("_", " ")] = self.on(runs)
        table = numbers("claim (section)", *columns, words=1 + len(columns))
        for name in ABOUT_SHAPE:
            cells = []
            for verdict in (verdicts[name] for verdicts in columns.values()):
                parts = (_one_line(f"{part.words}: {span(part)}") for part in verdict.comparisons)
                cells.append("\n".join((verdict.verdict, *parts)))
            table.add_row(_title(verdict), *cells)
        return table


def table_of(verdicts) -> Table:
    """One row per claim; those that do not hold come first."""
    order = [CONTRADICTED, UNDECIDED, SUPPORTED, UNTESTED]
    heads = "claim (section)", "verdict", "numbers", "holds, % of samples\nof unknown parameters"
    table = numbers(*heads, words=3)
    for verdict in sorted(verdicts, key=lambda verdict: order.index(verdict.verdict)):
        parts = "\n".join(
            f"{part.words}: {_one_line(span(part))}; claimed {claimed(part)}; n = {part.runs}"
            for part in verdict.comparisons
        )
        space = verdict.space.per_cent if verdict.space else "-"
        table.add_row(_title(verdict), verdict.verdict, parts, space)
    return table


def detail(verdict: Verdict) -> Group:
    """One claim: the sentence, how it is read, the comparisons and the verdict."""
    claim = verdict.claim
    lines = [f"{claim.name}: {verdict.verdict}", f'  "{claim.quote}" ({claim.section})']
    lines.append(f"  {claim.reading}")
    for comparison in verdict.comparisons:
        joint = f"{span(comparison, verdict.level)} at {100 * verdict.level:.2f} %"
        lines.append(
            f"  {comparison.words}: {span(comparison)} at 95 %, {joint}; "
            f"claimed: {claimed(comparison)}; {comparison.runs} runs"
        )
    shares = {"points of the plausible space": verdict.space, "single beds": verdict.paper}
    for name, share in shares.items():
        if share:
            counts = f"{share.points} {name}; {share.failed} more failed"
            lines.append(f"  holds at {share.per_cent} % of {counts}")
    return Group(*map(Text, lines))


def _title(verdict: Verdict) -> str:
    return f"{verdict.claim.title} ({verdict.claim.place})"


def _one_line(words: str) -> str:
    return words.replace(" ", "\N{NO-BREAK SPACE}")


claims = Claims()
