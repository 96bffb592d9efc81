"""Coefficients of resistive force theory from grains, and forces on outlines that they predict."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.rft import GENERIC, NAMES, Plates, Resistance, fitted, linearity, measured
from dem.base.statistics import Estimate, mean_interval, ratio_interval, student
from studies.common.findings import Findings, estimate, interval, numbers, percent

__all__ = ["half_speed", "kinds", "lengths", "proof", "rft", "twice_speed", "usual_speed"]

CLOSE = 0.1  # of a force: a prediction within that share of it is good


def about(value: float, variance: float) -> Estimate:
    """With its 95 % interval, by many resamples."""
    half = float(student(np.sqrt(variance), np.inf))
    return Estimate(value, value - half, value + half)


def factor(one: Resistance, other: Resistance | None = None) -> Estimate:
    """By which another profile, the generic one if absent, is nearest to the first."""
    base = GENERIC if other is None else other.coefficients
    ratio, square = float(base @ one.coefficients / (base @ base)), base @ base
    variance = base @ one.covariance @ base / square**2
    if other is not None:
        slope = (one.coefficients - 2.0 * ratio * base) / square
        variance += slope @ other.covariance @ slope
    return about(ratio, variance)


def alpha_of(plates: Plates, angle: float, direction: float) -> np.ndarray:
    """Stress over depth (s, 2) of each run at an angle and in a direction (degrees)."""
    at = np.degrees(plates.angle) - angle, np.degrees(plates.direction) - direction
    return plates.alpha[np.hypot(*at).argmin()]


def remains(plates: Plates, resistance: Resistance) -> float:
    """Root mean square of measured stress over depth less that of coefficients, over that of measured."""
    seen = np.nanmean(plates.alpha, axis=1)
    off = seen - resistance.alpha(plates.angle, plates.direction)
    return float(np.sqrt(np.mean(off**2) / np.mean(seen**2)))


def scatter(plates: Plates) -> float:
    """What the scatter of beds alone would leave of the means of all cells, in the same measure."""
    seen = np.nanmean(plates.alpha, axis=1)
    error = np.nanvar(plates.alpha, axis=1, ddof=1) / plates.alpha.shape[1]
    return float(np.sqrt(np.mean(error) / np.mean(seen**2)))


class Maps(Findings):
    """The plate of config/rft.yaml, rft.nc."""

    name, command = "rft", "dem sweep config/rft.yaml -j 2"
    source = "rft/scene.nc"

    @cached_property
    def plates(self) -> Plates:
        """What its runs measured."""
        return measured(self.dataset)

    @cached_property
    def resistance(self) -> Resistance:
        """The coefficients."""
        return fitted(self.plates)

    def scale(self) -> Estimate:
        """On the generic profile."""
        return factor(self.resistance)

    def generic(self) -> float:
        """Share that the generic profile leaves, once scaled."""
        return remains(self.plates, Resistance(self.scale().value * GENERIC, np.zeros((9, 9))))

    def scatter(self) -> float:
        """Share that beds alone would leave."""
        return scatter(self.plates)

    def alpha(self, angle: float, direction: float) -> np.ndarray:
        """Stress over depth (s, 2) in N/cm3 of each run at an angle and in a direction (degrees)."""
        return 1e-6 * alpha_of(self.plates, angle, direction)

    def sliding(self) -> Estimate:
        """Stress against a flat plate that moves along itself, over that against an upright one."""
        return ratio_interval(self.alpha(0.0, 0.0)[:, 0], self.alpha(90.0, 0.0)[:, 0])

    def lift(self) -> Estimate:
        """Stress upwards over depth (N/cm3) on a flat plate that moves along itself."""
        return mean_interval(self.alpha(0.0, 0.0)[:, 1])

    def lift_fitted(self) -> float:
        """The same by the coefficients."""
        return float(1e-6 * self.resistance.alpha(0.0, 0.0)[1])

    def table(self) -> Table:
        """One row per coefficient."""
        heads = "ours, N/cm3", "generic profile, scaled", "over A00, ours", "over A00, generic"
        table, ours = numbers("coefficient", *heads), 1e-6 * self.resistance.coefficients
        for name, value, half, sand in zip(
            NAMES,
            ours,
            1e-6 * self.resistance.error,
            self.scale().value * GENERIC * 1e-6,
            strict=True,
        ):
            over = (
                f"{value / ours[0]:.2f}",
                f"{sand / (self.scale().value * GENERIC[0] * 1e-6):.2f}",
            )
            table.add_row(
                name, estimate((value, value - half, value + half), "", 3), f"{sand:.3f}", *over
            )
        return table

    def depths(self) -> Table:
        """One row per range of depth."""
        edges, shares = linearity(self.plates)
        table = numbers("depth, mm", "stress over depth, relative to that of the run", words=1)
        for low, high, share in zip(1e3 * edges[:-1], 1e3 * edges[1:], shares, strict=True):
            table.add_row(f"{low:.1f} to {high:.1f}", estimate(share))
        return table


class Proof(Findings):
    """Outlines that no coefficient was fitted to, proof.nc. by: theory, which is by coefficients, or plates."""

    name = "proof"
    command = "python -m studies rft proof results/rft/scene.nc -o results/rft/proof.nc"
    source = "rft/proof.nc"

    def at(self, **labels) -> xr.DataArray:
        """Forces (N) of cells at some labels: outline, direction."""
        force = self.dataset["force"]
        for name, label in labels.items():
            force = force.isel(cell=np.flatnonzero(force[name] == label))
        return force.transpose("by", "end", "axis", "cell")

    def good(self, by: str, **at) -> np.ndarray:
        """Whether components are predicted within a tenth, or differ by less than the intervals of both."""
        seen, guess = (self.at(**at).sel(by=name).values for name in ("measured", by))
        off, half = np.abs(guess[0] - seen[0]), np.hypot(guess[2] - guess[0], seen[2] - seen[0])
        return (off <= CLOSE * np.abs(seen[0])) | (off <= half)

    def lifts(self, by: str) -> str:
        """How many forces upwards on outlines that move ahead are good, in words."""
        _, good = self.good(by, direction="ahead")
        return f"{good.sum()} of {good.size}"

    def drags(self, by: str) -> str:
        """The same of their forces along x."""
        good, _ = self.good(by, direction="ahead")
        return f"{good.sum()} of {good.size}"

    def count(self, by: str, **at) -> str:
        """How many are good, in words."""
        good = self.good(by, **at)
        return f"{good.sum()} of {good.size}"

    def share(self, by: str, **at) -> float:
        """Of good components."""
        return float(self.good(by, **at).mean())

    def over(self, by: str, **at) -> float:
        """Length of predicted over that of measured forces, by the mean of its logarithm."""
        seen, guess = (np.hypot(*self.at(**at).sel(by=name).values[0]) for name in ("measured", by))
        return float(np.exp(np.log(guess / seen).mean()))

    def turned(self, by: str, **at) -> float:
        """Median angle (degrees) between predicted and measured forces."""
        x, y = self.at(**at).isel(end=0).transpose("axis", "by", "cell").values
        angle = dict(zip(self.dataset["by"].values.tolist(), np.arctan2(y, x), strict=True))
        off = np.angle(np.exp(1j * (angle[by] - angle["measured"])), deg=True)
        return float(np.median(np.abs(off)))

    def exponent(self, direction: str) -> Estimate:
        """Of the power of depth by which forces grow between the two depths, over outlines."""
        force = np.hypot(*self.at(direction=direction).sel(by="measured").values[0])
        depth = self.dataset["depth"].values[self.dataset["direction"].values == direction]
        pairs = np.log([force, depth]).reshape(2, -1, 2)
        return mean_interval((pairs[0, :, 1] - pairs[0, :, 0]) / (pairs[1, :, 1] - pairs[1, :, 0]))

    def table(self) -> Table:
        """One row per outline, and one per direction."""
        heads = []
        for words in ("coefficients", "measured plates"):
            heads += [f"{words}: good", "over measured", "turned, degrees"]
        table = numbers("outline", "direction", *heads, words=2)
        for name in ("outline", "direction"):
            for label in dict.fromkeys(self.dataset[name].values.tolist()):
                at, cells = {name: label}, []
                for by in ("theory", "plates"):
                    cells += [
                        self.count(by, **at),
                        f"{self.over(by, **at):.2f}",
                        f"{self.turned(by, **at):.0f}",
                    ]
                table.add_row(*((label, "all") if name == "outline" else ("all", label)), *cells)
        return table

    def forces(self) -> Table:
        """One row per cell: forces along x and y in mN; bold what is not good."""
        kinds = "measured", "theory", "plates"
        heads = [
            f"{axis}, {words}" for axis in "xy" for words in ("measured", "coefficients", "plates")
        ]
        table = numbers("outline", "direction", "depth, mm", *heads, words=2)
        good = {"measured": np.ones((2, self.dataset.sizes["cell"]), bool)}
        good |= {by: self.good(by) for by in kinds[1:]}
        forces = 1e3 * self.at().sel(by=list(kinds)).transpose("cell", "axis", "by", "end").values
        for cell, depth in enumerate(1e3 * self.dataset["depth"].values):
            labels = (str(self.dataset[name].values[cell]) for name in ("outline", "direction"))
            row = []
            for axis, by in np.ndindex(2, len(kinds)):
                value, _, high = forces[cell, axis, by]
                text = interval(value, high - value, "", 1)
                row.append(text if good[kinds[by]][axis, cell] else f"**{text}**")
            table.add_row(*labels, f"{depth:.0f}", *row)
        return table


class Speed(Maps):
    """A few plates at another velocity."""

    def __init__(self, name: str, block: str):
        self.name, self.block = name, block

    command = "snakemake -j2 --configfile studies/rft/speeds.yaml"

    @property
    def source(self) -> str:
        """Where the command writes it."""
        return f"rft/speeds/{self.block}/scene.nc"

    def over(self, other: "Speed") -> Estimate:
        """Factor on the stress at another velocity, over beds: of an angle and a seed, with all directions."""
        ours, theirs = (each.plates.alpha for each in (self, other))
        base = np.nanmean(theirs, axis=1, keepdims=True)
        parts, angle = (
            np.array([(ours - theirs) * base, base**2 + 0.0 * ours]),
            np.abs(self.plates.angle),
        )
        groups = [np.abs(angle - each) < 1e-3 for each in np.unique(angle.round(3))]
        sums = [parts[:, group].sum(axis=(1, 3)) for group in groups]
        return mean_interval(np.concatenate([1.0 + off / square for off, square in sums]))

    def table(self) -> Table:
        """One row per plate and velocity."""
        heads = "direction, degrees", "velocity, m/s", "against x, N/cm3", "upwards, N/cm3"
        table = numbers("angle, degrees", *heads, words=0)
        for cell in np.lexsort([self.plates.direction.round(3), self.plates.angle.round(3)]):
            for speed, value in ((half_speed, 0.05), (usual_speed, 0.1), (twice_speed, 0.2)):
                plates = speed.plates
                row = (
                    f"{np.degrees(plates.angle[cell]):.0f}",
                    f"{np.degrees(plates.direction[cell]):.0f}",
                )
                means = [estimate(mean_interval(1e-6 * x), "", 3) for x in plates.alpha[cell].T]
                table.add_row(*row, f"{value:g}", *means)
        return table


class Lengths(Findings):
    """Plates of two lengths, lengths.nc."""

    name, command = "lengths", "snakemake -j2 --configfile studies/rft/lengths.yaml"
    source = "rft/lengths/scene.nc"

    def over(self) -> Estimate:
        """Stress against plates that lie or stand and move along x or down, of twice the length over that of
        the other."""
        plates = [measured(self.dataset.isel(solids_plate_diameter=[at])) for at in (0, 1)]
        ways = (0.0, 0.0, 0), (0.0, 90.0, 1), (90.0, 0.0, 0), (90.0, 90.0, 1)
        short, long = (
            np.array([alpha_of(each, angle, way)[:, axis] for angle, way, axis in ways])
            for each in plates
        )
        mean = short.mean(axis=1, keepdims=True)
        return ratio_interval((long / mean).ravel(), (short / mean).ravel())


class Kinds(Findings):
    """The plate in several kinds of grains, kinds.nc."""

    name, command = "kinds", "snakemake -j2 --configfile studies/rft/sweep.yaml"
    source = "rft/kinds/scene.nc"

    @cached_property
    def plates(self) -> dict[str, Plates]:
        """What runs measured, by grains."""
        names = self.dataset["grains"].values.tolist()
        return {name: measured(self.dataset.sel(grains=name)) for name in names}

    @cached_property
    def resistance(self) -> dict[str, Resistance]:
        """The coefficients, by grains."""
        return {name: fitted(plates) for name, plates in self.plates.items()}

    def scale(self, grains: str) -> Estimate:
        """On the generic profile."""
        return factor(self.resistance[grains])

    def over(self, grains: str) -> Estimate:
        """Factor on the coefficients of discs."""
        return factor(self.resistance[grains], self.resistance["discs"])

    def left(self, grains: str, profile: str) -> float:
        """Share that a profile leaves: nine coefficients of these grains, those of discs or the generic ones, scaled."""
        mine = self.resistance[grains]
        shapes = {
            "own": mine.coefficients,
            "discs": self.over(grains).value * self.resistance["discs"].coefficients,
        }
        shapes["generic"] = self.scale(grains).value * GENERIC
        return remains(self.plates[grains], Resistance(shapes[profile], mine.covariance))

    def scatter(self, grains: str) -> float:
        """Share that beds alone would leave."""
        return scatter(self.plates[grains])

    @property
    def generic_leaves_more(self) -> bool:
        """Whether the generic profile leaves more than that of discs, both scaled, of all grains."""
        return all(self.left(x, "generic") > self.left(x, "discs") for x in self.plates)

    def suffices(self, share: float, *grains: str) -> bool:
        """Whether the profile of discs, scaled, leaves at most so much more than nine coefficients of their own do."""
        return all(self.left(x, "discs") < self.left(x, "own") + share for x in grains)

    def table(self) -> Table:
        """One row per kind of grains."""
        heads = "factor on the generic profile", "it leaves", "factor on that of discs", "it leaves"
        table = numbers("grains", *heads, "nine coefficients leave", "scatter of beds")
        for name in self.plates:
            other = (
                ("", "")
                if name == "discs"
                else (estimate(self.over(name)), percent(self.left(name, "discs")))
            )
            own = percent(self.left(name, "own")), percent(self.scatter(name))
            table.add_row(
                name,
                estimate(self.scale(name), "", 3),
                percent(self.left(name, "generic")),
                *other,
                *own,
            )
        return table


rft, proof, kinds, lengths = Maps(), Proof(), Kinds(), Lengths()
half_speed, usual_speed, twice_speed = (
    Speed(f"{name}_speed", name) for name in ("half", "usual", "twice")
)
