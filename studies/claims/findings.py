"""The paper's sentences, tested."""

from collections import Counter
from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.compare import Comparison
from dem.analysis.statistics import by_case
from dem.analysis.tables import numbers
from dem.base.errors import InputError
from studies.claims import report
from studies.claims.evidence import from_study, from_sweep, scaled_ratios
from studies.claims.influence import Influence, influences, responses
from studies.claims.remains import remaining
from studies.claims.verdicts import judge
from studies.common.findings import Findings, interval

__all__ = ["claims"]

ABOUT_SHAPE = (
    "dumbbells_above_discs", "dumbbells_below_discs", "dumbbells_above_small_discs",
    "slight_ellipses_drop", "longer_ellipses_drop", "shape_matters",
)  # fmt: skip

OTHER_MARGINS = (0.10, 0.25)
RANKED = 4  # influences that are listed
SETTINGS = (
    "velocity", "diameter", "width", "width, equal distance", "height", "height, equal distance",
)  # fmt: skip


class Claims(Findings):
    """The paper's sentences on the runs of claims.nc."""

    name, command = "claims", "snakemake -j2 claims"
    needs = "run_part", "run_drag", "jam_fraction", "run_factor"
    attributes = "window_start", "window_stop"

    @cached_property
    def judged(self) -> dict:
        return {each.claim.name: each for each in judge(from_study(self.dataset))}

    @cached_property
    def remaining(self) -> list:
        return remaining(self.dataset)

    def runs(self) -> str:
        """How many runs there are."""
        return f"{self.dataset.sizes['run']:,}"

    def hours(self) -> str:
        """Processor time of all runs."""
        return f"{float(self.dataset['run_spent'].sum()) / 3600:.1f} hours"

    def failures(self) -> str:
        """Runs that failed, of what, in which part of the study."""
        labels = (self.dataset[f"run_{name}"].values.tolist() for name in ("status", "part"))
        found = Counter(zip(*labels, strict=True))
        wrong = [
            f"{n} {status} in {part}" for (status, part), n in found.items() if status != "ran"
        ]
        return ", ".join(wrong) or "none"

    def level(self) -> str:
        """Level of the intervals that verdicts use."""
        return f"{100 * next(iter(self.judged.values())).level:.2f} %"

    def verdict(self, name: str) -> str:
        """Supported, contradicted, undecided or not tested."""
        return self.judged[name].verdict

    def numbers(self, name: str) -> str:
        """What a claim is compared by, with 95 % intervals."""
        return "; ".join(report.span(each) for each in self.judged[name].comparisons)

    def extremes(self, name: str) -> str:
        """The least and the greatest number of a claim."""
        found = [each.estimate for each in self.judged[name].comparisons]
        return f"{min(found):.2f} to {max(found):.2f}"

    def verdicts(self) -> Table:
        """One row per claim; those that do not hold come first."""
        return report.claims(list(self.judged.values()))

    def readings(self) -> str:
        """One list item per claim: the quotation and how it is read."""
        return "\n".join(
            f"* **{each.claim.title}** ({report.place(each.claim.place)}): "
            f"“{each.claim.quote}”. {each.claim.reading}"
            for each in self.judged.values()
        )

    def count(self, verdict: str) -> int:
        """How many claims have this verdict."""
        return sum(each.verdict == verdict for each in self.judged.values())

    def margins(self) -> str:
        """Which verdicts depend on how much "significantly" means."""
        told = []
        for margin in OTHER_MARGINS:
            other = {v.claim.name: v for v in judge(from_study(self.dataset, margin))}
            moved = [
                f"{each.claim.title}: {each.verdict}" for name, each in other.items()
                if each.verdict != self.judged[name].verdict
            ]  # fmt: skip
            words = "; ".join(moved) or "the same verdicts"
            told.append(f"* With a margin of {100 * margin:.0f} %: {words}.")
        return "\n".join(told)

    def single_beds(self, name: str) -> str:
        """Share of single beds at the paper's values in which a claim holds."""
        return f"{100 * self.judged[name].paper.share:.0f} %"

    def jams_at(self, shape: str) -> str:
        """Packing fraction at which frictionless beds of a shape jam."""
        return f"{self._jams_at(shape):.3f}"

    def _jams_at(self, shape: str) -> float:
        here = (self.dataset["jam_shape"] == shape) & (self.dataset["jam_friction"] == 0.0)
        return float(self.dataset["jam_fraction"].where(here).mean())

    def beyond_jamming(self, shape: str) -> bool:
        """Whether the packing fraction of the paper is above that at which a shape jams."""
        return float(self.dataset["reference_packing"]) > self._jams_at(shape)

    def jamming(self) -> Table:
        """One row per shape of the paper: where beds jam, without friction and with it."""
        made = numbers(
            "shape", "jams at, without friction", "with the friction of the runs", "beds"
        )
        frictions = np.unique(self.dataset["jam_friction"].values)
        for shape in dict.fromkeys(each.shape for each in self.remaining):
            here = self.dataset["jam_shape"].values == shape
            some = [
                self.dataset["jam_fraction"].values[here & (self.dataset["jam_friction"] == each)]
                for each in frictions
            ]
            found = [Comparison("", each, None, 0.0, 1.0) for each in some]
            cells = [interval(e.estimate, np.ptp(e.interval()) / 2, digits=4) for e in found]
            made.add_row(shape, *cells, str(found[0].runs))
        return made

    def states(self) -> Table:
        """One row per shape and state: drag over that of c1."""
        made = numbers("shape", "state", "V_f", "drag over that of c1", words=2)
        for each in self.remaining[1:]:
            ratio, low, high = each.ratio
            made.add_row(
                each.shape, each.state, f"{each.fraction:.3f}",
                report.on_one_line(f"{ratio:.2f} ({low:.2f} to {high:.2f})"),
            )  # fmt: skip
        return made

    def _at(self, shape: str, state: str):
        found = [each for each in self.remaining if (each.shape, each.state) == (shape, state)]
        if not found:
            raise InputError(f"studies/claims/claims.nc has no runs of {shape} at {state}.")
        return found[0]

    def at(self, shape: str, state: str) -> str:
        """Drag over that of c1, of a shape at a state, with its interval."""
        return "{:.2f} ({:.2f} to {:.2f})".format(*self._at(shape, state).ratio)

    def above(self, shape: str, state: str) -> bool:
        """Whether a shape at a state drags more than c1, the interval included."""
        return self._at(shape, state).ratio[1] > 1.0

    def below(self, shape: str, state: str) -> bool:
        """Whether a shape at a state drags less than c1, the interval included."""
        return self._at(shape, state).ratio[2] < 1.0

    def decides(self) -> Table:
        """One row per value of influence: by how much responses grow over its range."""
        points = from_study(self.dataset).points
        made = numbers(
            "response", "decided by", "grows over the range by", "share of variance", words=2
        )
        for name, response in responses(points).items():
            for number, each in enumerate(influences(points, response)[:RANKED]):
                made.add_row(
                    "" if number else name, f"`{each.factor}`",
                    f"{each.growth:.2f} ({each.low:.2f} to {each.high:.2f})", f"{each.share:.2f}",
                )  # fmt: skip
        return made

    def _influence(self, response: str, factor: str) -> Influence:
        points = from_study(self.dataset).points
        found = influences(points, responses(points)[response])
        return {each.factor: each for each in found}[factor]

    def growth(self, response: str, factor: str) -> str:
        """Response at the high end of a factor's range over that at the low end."""
        return f"{self._influence(response, factor).growth:.1f}"

    def told(self, response: str, factor: str) -> bool:
        """Whether a response depends on a factor, interval included."""
        return self._influence(response, factor).decides

    def scaling(self) -> Table:
        """One row per setting, shape and factor: drag over that at the paper's value."""
        made = numbers("varied", "shape", "times", "drag over that at 1", "runs", words=2)
        for setting in SETTINGS:
            for shape in ("c1", "e3"):
                for x, drag in scaled_ratios(self.dataset, setting, shape).items():
                    made.add_row(setting, shape, f"{x:g}", report.span(drag), str(drag.runs))
        return made

    def _scaled(self, setting: str, shape: str, factor: float):
        return scaled_ratios(self.dataset, setting, shape)[factor]

    def scaled(self, setting: str, shape: str, factor: float) -> str:
        """Drag at a factor on one of the paper's values, over that at the paper's."""
        return f"{self._scaled(setting, shape, factor).estimate:.2f}"

    def shrinks(self, setting: str, shape: str, factor: float) -> bool:
        """Whether the drag there is below that at the paper's value, the interval included."""
        return self._scaled(setting, shape, factor).interval()[1] < 1.0

    def beside(self, **sweeps: xr.Dataset) -> Table:
        """One row per claim about shape: verdict and numbers here, and on runs of other sweeps by what
        they are."""
        found = {
            words.replace("__", ", ").replace("_", " "): self.on(runs)
            for words, runs in sweeps.items()
        }
        made = numbers(
            "claim (section)", "the paper's box, claims.nc", *found, words=2 + len(found)
        )
        for name in ABOUT_SHAPE:
            each = self.judged[name]
            cells = [_cell(verdicts[name]) for verdicts in (self.judged, *found.values())]
            made.add_row(f"{each.claim.title} ({each.claim.place})", *cells)
        return made

    def changed(self, runs: xr.Dataset) -> dict[str, str]:
        """Verdicts about shape on other runs that are not those of claims.nc, by the name of the claim."""
        found = {name: verdict for name, verdict in self.on(runs).items() if name in ABOUT_SHAPE}
        return {
            name: each.verdict for name, each in found.items()
            if each.verdict != self.judged[name].verdict
        }  # fmt: skip

    def on(self, runs: xr.Dataset) -> dict:
        """Verdicts on runs over shape and seed of any sweep, by the name of the claim."""
        runs = by_case(runs)
        density = np.broadcast_to(runs["density"].values, runs.sizes["case"]).copy()
        found = from_sweep(runs.assign_coords(density=("case", density)))
        return {each.claim.name: each for each in judge(found)}


def _cell(verdict) -> str:
    parts = (f"{part.words}: {report.span(part)}" for part in verdict.comparisons)
    return f"**{verdict.verdict}**\n" + "\n".join(map(report.on_one_line, parts))


claims = Claims()
