"""Every result that a page or the README states, read from docs/data.

Pages call what is in NAMES: `{{ drag.mean("c1") }}`, `{{ table(claims.verdicts()) }}`, `{{ claims.made }}`.
No result is typed on a page; tests/test_pages.py looks for those that are. A sentence that depends on
a result says on which: `{{ holds("Ellipses drag less than discs", drag.falls("c1", "e1")) }}`.
Nothing here needs Sphinx.
"""

from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
import yaml
from jinja2 import Environment, StrictUndefined
from rich.table import Table

from dem.analysis.flow.verdict import compared
from dem.analysis.statistics import change, summarise
from dem.analysis.tables import numbers
from dem.base.errors import InputError
from dem.studies.accuracy import bias, replicates
from dem.studies.accuracy import report as accuracy_report
from dem.studies.benchmark import report as speed_report
from dem.studies.claims import report as claims_report
from dem.studies.claims.compare import Comparison
from dem.studies.claims.evidence import from_study
from dem.studies.claims.influence import influences, responses
from dem.studies.claims.remains import remaining
from dem.studies.claims.verdicts import judge
from dem.studies.stability import report as stability_report

DATA = Path(__file__).parent.parent / "data"
PAPER = {"c1": "1295", "e0": "1405"}  # N, section 3.2
DENSER = "2"  # case c12 is c1 at ten times the density
MEASURES = {
    "non_affine": "non-affine displacement (D²min)",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing of layers",
    "contacts_lost": "contacts lost over 0.5 mm",
}
TEMPLATES = Environment(
    undefined=StrictUndefined,
    comment_start_string="<#",
    comment_end_string="#>",
    keep_trailing_newline=True,
)


def fill(text: str) -> str:
    """A page with its numbers."""
    import findings_paper

    return TEMPLATES.from_string(text).render(NAMES | findings_paper.NAMES)


def holds(sentence: str, condition: bool) -> str:
    """The sentence; an error that ends the build where the data contradicts it."""
    if not condition:
        raise ValueError(f"docs/data contradicts the sentence {sentence!r}; rewrite it.")
    return sentence


def table(rich: Table) -> str:
    """A table for the terminal as Markdown; the first column is words, the others are numbers."""
    heads = [str(column.header).replace("\n", " ") for column in rich.columns]
    rows = zip(*(column.cells for column in rich.columns), strict=True)
    align = [":--" if column.justify == "left" else "--:" for column in rich.columns]
    lines = [heads, align, *rows]
    return "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)


def heads(words: int, *columns: str) -> Table:
    """An empty table; the first columns hold words, the others numbers."""
    made = numbers(*columns)
    for column in made.columns[:words]:
        column.justify = "left"
    return made


def _cell(text) -> str:
    return str(text).replace("|", r"\|").replace("+-", "±").replace(" ± nan", "").replace("\n", " ")


def interval(value: float, half: float, unit: str = "", digits: int = 0) -> str:
    """A mean and half its confidence interval: 1257 ± 181 N, on one line."""
    words = f"{value:.{digits}f} ± {half:.{digits}f} {unit}".rstrip()
    return words.replace("-", "\N{MINUS SIGN}").replace(" ", "\N{NO-BREAK SPACE}")


def span(low: float, high: float, unit: str = "", digits: int = 2) -> str:
    """A range: 0.9 to 2.4 mm."""
    return f"{low:.{digits}f} to {high:.{digits}f} {unit}".rstrip()


class Findings:
    """What one released file says."""

    name: str  # of the file in docs/data, without .nc
    command: str  # that makes it

    @property
    def path(self) -> Path:
        return DATA / f"{self.name}.nc"

    @cached_property
    def dataset(self) -> xr.Dataset:
        if not self.path.is_file():
            raise InputError(
                f"docs/data/{self.path.name} is missing; make it by `{self.command}`, "
                "then `python docs/data/release.py results`."
            )
        with xr.open_dataset(self.path) as dataset:
            return dataset.load()

    @cached_property
    def revision(self) -> str:
        """Of the code that made the results; several where files of several revisions were combined."""
        return ", ".join(each.strip()[:7] for each in self.dataset.attrs["git_revision"].split(";"))

    @cached_property
    def made(self) -> str:
        """Where the numbers come from, as a line under a table."""
        attrs = self.dataset.attrs
        day = attrs["history"].split("T")[0]
        return (
            f"*Computed by `{attrs['made_with']}` at revision `{self.revision}` on {day}; "
            f"file `docs/data/{self.path.name}`.*"
        )


class Drag(Findings):
    """The paper's sweep, drag.nc: means over 1 mm to 5 mm, 95 % intervals over five seeds."""

    name, command = "drag", "snakemake -j2"

    @cached_property
    def summary(self) -> xr.Dataset:
        return summarise(self.dataset)

    def mean(self, case: str) -> str:
        """Mean drag of a case and half its interval, in N."""
        return interval(*self._mean(case), "N")

    def _mean(self, case: str) -> tuple[float, float]:
        one = self.summary.sel(case=case)
        return float(one["mean"]), float(one["half_interval"])

    def cases(self) -> Table:
        """One row per shape: mean drag, the paper's value, mean drag at ten times the density."""
        made = heads(2, "case", "granules", "mean drag, N", "paper, N", "ten times as dense, N")
        labels = self.dataset["case"].values.tolist()
        for case in labels:
            denser = f"{case}{DENSER}"
            if not case.endswith(DENSER) or case[:-1] not in labels:
                dense = interval(*self._mean(denser)) if denser in labels else ""
                mean = interval(*self._mean(case))
                made.add_row(case, self.granules(case), mean, PAPER.get(case, ""), dense)
        return made

    def granules(self, case: str) -> str:
        """Shape, aspect ratio of an ellipse, and volume diameter."""
        one = self.dataset.sel(case=case)
        kind, ratio = str(one["kind"].values), float(one["aspect_ratio"])
        ratio = f" {ratio:g}:1" if kind == "ellipse" else ""
        return f"{kind}{ratio}, {1e6 * float(one['diameter']):.0f} µm"

    def change(self, case: str, other: str) -> str:
        """How much the mean of `other` differs from that of `case`, beds paired."""
        value, half = change(self.summary["run_mean"], case, other)
        return interval(100 * value, 100 * half, "%")

    def density(self) -> str:
        """Range over the shapes of what ten times the density does to the mean drag."""
        found = [
            100 * change(self.summary["run_mean"], case, case + DENSER)[0]
            for case in self.dataset["case"].values.tolist()
            if case + DENSER in self.dataset["case"].values
        ]
        return span(min(found), max(found), "%", 0)

    def ratio(self, case: str, other: str) -> str:
        """Mean drag of `case` over that of `other`."""
        means = self.summary["mean"]
        return f"{float(means.sel(case=case) / means.sel(case=other)):.2f}"

    def falls(self, *cases: str) -> bool:
        """Whether the mean falls from case to case."""
        return bool(np.all(np.diff([self._mean(case)[0] for case in cases]) < 0.0))

    def apart(self, case: str, other: str) -> bool:
        """Whether the interval of `case` is above that of `other`."""
        (high, a), (low, b) = self._mean(case), self._mean(other)
        return high - a > low + b

    def overlap(self, case: str, other: str) -> bool:
        """Whether the intervals of two cases overlap."""
        return not (self.apart(case, other) or self.apart(other, case))

    def parts(self, case: str, other: str, share: float) -> str:
        """Displacements, over the seeds, at which the drags of two cases first differ by a share."""
        a, b = (self.dataset["drag"].sel(case=each) for each in (case, other))
        first = (abs(a - b) > share * abs(b)).argmax("displacement")
        found = 1e3 * self.dataset["displacement"].values[first.values]
        return span(found.min(), found.max(), "mm", 1)

    def scatter(self, case: str) -> str:
        """Standard deviation of the drag over a run, over the mean."""
        one = self.summary.sel(case=case)
        return f"{100 * float(one['sd_over_run'] / one['mean']):.0f} %"

    def pressure(self, *cases: str) -> float:
        """Mean pressure (Pa) on the walls of the packed beds of some cases."""
        return float(self.dataset["packing_pressure"].sel(case=list(cases)).mean())

    def largest_overlap(self, *cases: str) -> str:
        """Greatest overlap of some cases, over the smaller radius."""
        return f"{float(self.dataset['max_overlap'].sel(case=list(cases)).max()):.2f}"

    def run_time(self) -> str:
        """Median processor time of a run."""
        return f"{float(np.nanmedian(self.dataset['run_time'])):.1f} s"


class Flow(Findings):
    """Measures of the flow of the paper's sweep, flow.nc."""

    name, command = "flow", "snakemake -j2"

    def measures(self) -> Table:
        """One row per measure: mean of e3 over that of c1."""
        made = numbers("measure of irregularity", "e3 over c1")
        for name, words in MEASURES.items():
            found = compared(self.dataset, name)
            made.add_row(words, interval(found.ratio, found.half, digits=2))
        return made

    def more_irregular(self) -> bool:
        """Whether any measure of e3 is above that of c1, interval included."""
        found = [compared(self.dataset, name) for name in MEASURES]
        return any(each.ratio - each.half > 1.0 for each in found)


class Claims(Findings):
    """The paper's sentences on the runs of claims.nc."""

    name, command = "claims", "snakemake -j2 claims"

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

    def level(self) -> str:
        """Level of the intervals that verdicts use."""
        return f"{100 * next(iter(self.judged.values())).level:.2f} %"

    def verdict(self, name: str) -> str:
        """Supported, contradicted, undecided or not tested."""
        return self.judged[name].verdict

    def numbers(self, name: str) -> str:
        """What a claim is compared by, with 95 % intervals."""
        return "; ".join(claims_report.span(each) for each in self.judged[name].comparisons)

    def verdicts(self) -> Table:
        """One row per claim."""
        made = heads(
            4,
            "claim",
            "section",
            "verdict",
            "number, 95 % interval",
            "holds in the plausible space, %",
        )
        for name, each in self.judged.items():
            made.add_row(
                each.claim.title, each.claim.place, f"**{each.verdict}**", self.numbers(name),
                claims_report.per_cent(each.space),
            )  # fmt: skip
        return made

    def readings(self) -> str:
        """One list item per claim: the quotation and how it is read."""
        return "\n".join(
            f"* **{each.claim.title}** ({claims_report.place(each.claim.place)}): "
            f"“{each.claim.quote}”. {each.claim.reading}"
            for each in self.judged.values()
        )

    def count(self, verdict: str) -> int:
        """How many claims have this verdict."""
        return sum(each.verdict == verdict for each in self.judged.values())

    def margins(self) -> str:
        """Which verdicts depend on how much "significantly" means."""
        return "\n".join(f"* {line}" for line in claims_report.margins(self.dataset).splitlines())

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
        """One row per shape and state: drag over that of c1, and what remains of the effect."""
        made = heads(2, "shape", "state", "V_f", "drag over that of c1", "effect that remains")
        for each in self.remaining[1:]:
            ratio, low, high = each.ratio
            part = "" if np.isnan(each.part[0]) else f"{100 * each.part[0]:.0f} %"
            made.add_row(
                each.shape, each.state, f"{each.fraction:.3f}",
                f"{ratio:.2f} ({low:.2f} to {high:.2f})", part,
            )  # fmt: skip
        return made

    def _at(self, shape: str, state: str):
        found = [each for each in self.remaining if (each.shape, each.state) == (shape, state)]
        if not found:
            raise InputError(f"docs/data/claims.nc has no runs of {shape} at {state}.")
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

    def part(self, shape: str, state: str) -> str:
        """How much of the effect of shape remains at a state, with its interval."""
        return "{:.0f} % ({:.0f} to {:.0f})".format(*(100 * x for x in self._at(shape, state).part))

    def decides(self) -> Table:
        """One row per value of influence: by how much responses grow over its range."""
        points = from_study(self.dataset).points
        made = heads(2, "response", "decided by", "grows over the range by", "share of variance")
        for name, response in responses(points).items():
            for number, each in enumerate(influences(points, response)[: claims_report.RANKED]):
                made.add_row(
                    "" if number else name, f"`{each.factor}`",
                    f"{each.growth:.2f} ({each.low:.2f} to {each.high:.2f})", f"{each.share:.2f}",
                )  # fmt: skip
        return made

    def growth(self, response: str, factor: str) -> str:
        """Response at the high end of a factor's range over that at the low end."""
        points = from_study(self.dataset).points
        found = influences(points, responses(points)[response])
        return f"{ {each.factor: each.growth for each in found}[factor]:.1f}"

    def scaling(self) -> Table:
        """One row per setting, shape and factor: drag over that at the paper's value."""
        made = heads(2, "varied", "shape", "times", "drag over that at 1", "runs")
        for setting in claims_report.SETTINGS:
            for shape in ("c1", "e3"):
                for x, drag, _ in claims_report.scaled_ratios(self.dataset, setting, shape):
                    made.add_row(setting, shape, f"{x:g}", claims_report.span(drag), str(drag.runs))
        return made

    def _scaled(self, setting: str, shape: str, factor: float):
        found = claims_report.scaled_ratios(self.dataset, setting, shape)
        return {x: drag for x, drag, _ in found}[factor]

    def scaled(self, setting: str, shape: str, factor: float) -> str:
        """Drag at a factor on one of the paper's values, over that at the paper's."""
        return f"{self._scaled(setting, shape, factor).estimate:.2f}"

    def shrinks(self, setting: str, shape: str, factor: float) -> bool:
        """Whether the drag there is below that at the paper's value, the interval included."""
        return self._scaled(setting, shape, factor).interval()[1] < 1.0


class Accuracy(Findings):
    """Error against run time, accuracy.nc."""

    name, command = "accuracy", "snakemake -j2 accuracy"
    SHAPES = "c1", "d1", "e3"

    @cached_property
    def biases(self) -> dict:
        return {shape: bias.bias(self.dataset, shape) for shape in bias.shapes_of(self.dataset)}

    def steps(self) -> Table:
        """One row per shape and time step: change of the mean drag."""
        return accuracy_report.drag(self.dataset)

    def bias(self, shape: str) -> str:
        """Bias of the mean drag at the default step."""
        found = self.biases[shape]
        return interval(100 * found.value, 100 * found.half, "%", 1)

    def bias_table(self) -> Table:
        """One row per shape: bias of the default step and of half of it."""
        made = numbers("shape", "bias of the default step", "of half the step", "beds")
        for shape, each in self.biases.items():
            cells = [
                interval(100 * x * each.value, 100 * x * each.half, "%", 1) for x in (1.0, 0.5)
            ]
            made.add_row(shape, *cells, str(each.seeds))
        return made

    def biased_less(self, share: float) -> bool:
        """Whether all biases are below a share of the mean drag, their intervals included."""
        return all(abs(each.value) + each.half < share for each in self.biases.values())

    def change(self, shape: str, fraction: float) -> str:
        """Change of the mean drag at a step, over the bound, against the default."""
        default = float(self.dataset.attrs["default_fraction"])
        found = bias.change(bias.table(self.dataset, shape), default).sel(fraction=fraction)
        return interval(100 * float(found["value"]), 100 * float(found["half"]), "%")

    def failed(self, shape: str, fraction: float) -> str:
        """Share of the runs at a step that failed."""
        return f"{100 * bias.failures(self.dataset, shape)[fraction]:.0f} %"

    @cached_property
    def replicates(self) -> replicates.Replicates:
        return replicates.replicates(self.dataset)

    def beds(self) -> int:
        """How many replicates there are."""
        return self.dataset.sizes["replicate"]

    def scatter(self) -> str:
        """Of one run about the mean."""
        return f"{100 * self.replicates.scatter:.1f} %"

    def half(self, runs: int) -> str:
        """Half the interval of the mean of some runs, over the mean."""
        return f"± {100 * replicates.expected(self.replicates.scatter, runs):.0f} %"

    def needed(self) -> str:
        """Runs for an interval of ± TARGET, and their processor time."""
        found = self.replicates
        return f"{found.needed} runs ({clock(found.needed * found.time)} of processor time)"

    def target(self) -> str:
        """Half the interval that `needed` is about."""
        return f"± {100 * replicates.TARGET:.0f} %"

    def long_stroke(self) -> tuple[str, str]:
        """Scatter of one run over the whole stroke, and the change of its mean."""
        scatter = replicates.windows(self.dataset)[1][-1]
        return f"{100 * scatter:.1f} %", f"{100 * replicates.drift(self.dataset):+.0f} %"

    def integrators(self) -> Table:
        """One row per scene and integrator: error at the default step, its time, the order."""
        return accuracy_report.steps(self.dataset)

    def error(self, scene: str, integrator: str) -> float:
        """Of an integrator at the default step."""
        one = self.dataset.sel(step_scene=scene, integrator=integrator)
        default = float(self.dataset["step_default"])
        level = int(np.nanargmin(abs(one["step_fraction"].values - default)))
        return float(one["step_error"][level])

    def order(self, scene: str) -> str:
        """Fitted order of velocity Verlet."""
        one = self.dataset["step_order"].sel(step_scene=scene, integrator="Verlet")
        return f"{float(one):.2f}"

    def methods(self) -> Table:
        """One row per method whose first guess is off by 1e-4 rad, as in a run."""
        made = numbers(
            "contact of two ellipses", "ns", "error of the overlap", "of the normal, rad"
        )
        full = self.contacts()
        for row in zip(*(column.cells for column in full.columns), strict=True):
            method, start, time, overlap, normal, by_definition, tilt, _ = row
            if start in ("any", "0.0001 rad"):
                made.add_row(
                    method,
                    time,
                    max(overlap, by_definition, key=float),
                    max(normal, tilt, key=float),
                )
        return made

    def contacts(self) -> Table:
        """One row per method and start: time and errors."""
        return accuracy_report.contacts(self.dataset)

    def bounces(self) -> Table:
        """One row per method: greatest change of the energy over all bounces, by aspect ratio."""
        ratios = self.dataset["bounce_aspect_ratio"].values
        made = numbers("contact", *(f"{ratio:g}:1" for ratio in ratios))
        for method in self.dataset["bounce_method"].values:
            here = self.dataset.sel(bounce_method=method)
            cells = []
            for ratio in ratios:
                one = here.sel(bounce_aspect_ratio=ratio)
                worst = float(abs(one["bounce_energy"] - 1.0).max())
                burst = bool(np.isfinite(one["bounce_burst"]).any())
                cells.append("diverges" if burst else f"{worst:.1e}" if np.isfinite(worst) else "")
            made.add_row(str(method), *cells)
        return made

    def bounced(self) -> str:
        """How many bounces there are."""
        return f"{int(self.dataset['bounce_number'].max()):,}"

    def lammps_ran(self) -> bool:
        """Whether LAMMPS was there when the file was made."""
        return bool(np.isfinite(self.dataset["peer_error"].isel(peer=1)).any())

    def peers(self) -> Table:
        """One row per scene: error and time of this code and of LAMMPS at the default step."""
        made = numbers("scene", "error", "error, LAMMPS", "time over LAMMPS's")
        scenes = self.dataset["step_scene"].values.tolist()
        default = float(self.dataset["step_default"])
        for scene in self.dataset["peer_scene"].values:
            row = scenes.index(scene)
            level = int(np.nanargmin(abs(self.dataset["step_fraction"].values[row] - default)))
            here = self.dataset.sel(peer_scene=scene).isel(step_level=level)
            errors, times = (
                here["peer_error"].values,
                here["peer_time"].median("step_repeat").values,
            )
            if np.isfinite(errors).all():
                made.add_row(
                    str(scene), *(f"{x:.2e}" for x in errors), f"{times[0] / times[1]:.2f}"
                )
        return made


class Stability(Findings):
    """Stiff and extreme cases against limits, stability.nc."""

    name, command = "stability", "snakemake -j2 stability"

    def total(self) -> int:
        """How many checks there are."""
        return self.dataset.sizes["check"]

    def passed(self) -> int:
        """How many of them hold their limit."""
        return int(self.dataset["check_passed"].sum())

    def failed(self) -> int:
        """How many fail that are no known limit."""
        return int(
            ((self.dataset["check_passed"] == 0) & (self.dataset["check_known"] == "")).sum()
        )

    def known(self) -> str:
        """One list item per case that exceeds a limit as is known."""
        one = self.dataset
        rows = zip(one["check_case"].values, one["check_known"].values, one["check_passed"].values,
                   strict=True)  # fmt: skip
        found = {str(case): str(words) for case, words, passed in rows if words and not passed}
        return "\n".join(f"* **{case}**: {words}." for case, words in found.items())

    def catalogue(self) -> Table:
        """One row per case, shape and limit."""
        return stability_report.catalogue(self.dataset)

    def limits(self) -> Table:
        """One row per shape: the bound beside the limit of linearised beds."""
        made = numbers("small bed of", "bound, ns", "limit, ns", "limit over bound")
        for shape in self.dataset["limit_shape"].values:
            one = self.dataset.sel(limit_shape=shape)
            bound, limit = 1e9 * float(one["limit_bound"]), 1e9 * float(one["limit_limit"])
            made.add_row(str(shape), f"{bound:.0f}", f"{limit:.0f}", f"{limit / bound:.2f}")
        return made

    def bound_holds(self) -> bool:
        """Whether the bound is below the limit for every shape."""
        return bool((self.dataset["limit_bound"] < self.dataset["limit_limit"]).all())

    def default(self) -> str:
        """The default step over the bound."""
        return f"{float(self.dataset.attrs['default_fraction']):g}"

    def _edge(self, level: float) -> float:
        return stability_report.edge(self.dataset, level)

    def off(self) -> str:
        """The least step over the bound at which energy is off by 1 % anywhere on the map."""
        return f"{self._edge(stability_report.OFF):g}"

    def broken(self) -> str:
        """The least step over the bound at which a run breaks anywhere on the map."""
        return f"{self._edge(stability_report.BROKEN):g}"

    def safe(self) -> bool:
        """Whether energy adds up on the whole map at the default step."""
        return self._edge(stability_report.OFF) > float(self.dataset.attrs["default_fraction"])

    def residual(self) -> str:
        """The worst residual of the energy ledger of the paper's cases."""
        return f"{float(self.dataset['paper_residual'].max()):.0e}"


class Speed(Findings):
    """Speed beside other codes, benchmark.nc."""

    name, command = "benchmark", "snakemake -j1 benchmark"

    def codes(self) -> Table:
        """One row per bed and code that ran."""
        made = heads(2, "bed", "code", "10⁶ granule-steps/s", "lowest to highest", "ns a contact")
        for scene in self.dataset["scene"].values:
            here = self.dataset.sel(scene=scene)
            for code in self.dataset["code"].values:
                rates = 1e-6 * here["granule_steps_per_second"].sel(code=code).values
                if np.isfinite(rates).all():
                    made.add_row(
                        str(scene), str(code), f"{np.median(rates):.1f}",
                        span(rates.min(), rates.max(), digits=1),
                        f"{1e9 * float(here['time_per_contact'].sel(code=code)):.0f}",
                    )  # fmt: skip
        return made

    def ran(self, code: str) -> bool:
        """Whether a code was there when the file was made."""
        return str(self.dataset["code_status"].sel(code=code).values) == "run"

    def faster(self, scene: str, code: str) -> str:
        """How many times as fast this code is as another, by the medians."""
        rates = self.dataset["granule_steps_per_second"].sel(scene=scene).median("repeat")
        return f"{float(rates[0] / rates.sel(code=code)):.1f}"

    def scenes(self) -> Table:
        """One row per scene: what it costs."""
        return speed_report.scenes(self.dataset)

    def sizes(self) -> Table:
        """One row per size of bed and number of threads."""
        return speed_report.sizes(self.dataset)

    def motion(self) -> Table:
        """One row per bed: how far this code and LAMMPS part."""
        return speed_report.motion(self.dataset)

    def machine(self) -> str:
        """The processor."""
        return str(self.dataset.attrs["processor"])

    def repeats(self) -> int:
        """How often each code runs."""
        return self.dataset.sizes["repeat"]


class Timings:
    """How long commands took, timings.yaml: measured by hand, with command, revision and date."""

    path = DATA / "timings.yaml"

    @cached_property
    def content(self) -> dict:
        if not self.path.is_file():
            raise InputError(
                f"docs/data/{self.path.name} is missing; docs/data/README.md has its form."
            )
        return yaml.safe_load(self.path.read_text(encoding="utf-8"))

    def of(self, name: str) -> str:
        """Time of one entry."""
        return clock(self.content["timed"][name]["seconds"])

    def table(self) -> Table:
        """One row per entry."""
        made = heads(2, "what", "command", "time")
        for each in self.content["timed"].values():
            made.add_row(each["what"], f"`{each['command']}`", clock(each["seconds"]))
        return made

    @cached_property
    def made(self) -> str:
        """Where the numbers come from, as a line under a table."""
        about = self.content
        return (
            f"*Measured at revision `{about['revision']}` on {about['date']}, {about['machine']}; "
            f"file `docs/data/{self.path.name}`.*"
        )


def clock(seconds: float) -> str:
    """A duration as one reads it: 12 s, 5 min 27 s, 1 h 5 min."""
    if seconds < 60:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if rest else f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min"


drag, flow, claims, accuracy = Drag(), Flow(), Claims(), Accuracy()
stability, speed, timings = Stability(), Speed(), Timings()
FILES = drag, flow, claims, accuracy, stability, speed
NAMES = {
    "table": table,
    "interval": interval,
    "holds": holds,
    "drag": drag,
    "flow": flow,
    "claims": claims,
    "accuracy": accuracy,
    "stability": stability,
    "speed": speed,
    "timings": timings,
}
