"""Coefficients of resistive force theory from grains, and forces on outlines that they predict."""

from functools import cached_property
from itertools import product

import numpy as np
import xarray as xr
from rich.table import Table
from scipy.special import fdtri

from dem.analysis.rft import GENERIC, NAMES, Plates, Resistance, fitted, linearity, measured
from dem.base.statistics import Estimate, mean_interval, ratio_interval, student
from studies.common.findings import Findings, estimate, interval, numbers, percent

__all__ = [
    "half_speed",
    "kinds",
    "lengths",
    "lift",
    "proof",
    "rft",
    "twice_speed",
    "usual_speed",
]

WAY = {"down": 90.0, "down ahead": 45.0, "ahead": 0.0, "up ahead": -45.0, "up": -90.0}  # degrees
CLOSE = 0.1  # of a force: a prediction within that share of it is good
SUMS = {
    "short": "plates of 8 mm",
    "long": "plates of 16 mm",
    "theory": "nine coefficients of plates of 16 mm",
    "sides": "plates of both lengths, without their ends",
    "plates": "plates of both lengths, with their ends",
}


def factor(one: Resistance, base: np.ndarray, of: np.ndarray | None = None) -> Estimate:
    """By which a profile, the base, is nearest to the first, with its interval; of: covariance of the base."""
    square = base @ base
    ratio, weight = float(base @ one.coefficients / square), base / square
    variance = weight @ one.covariance @ weight
    if of is not None:
        slope = (one.coefficients - 2.0 * ratio * base) / square
        variance += slope @ of @ slope
    half = float(student(np.sqrt(variance), np.inf))
    return Estimate(ratio, ratio - half, ratio + half)


def ratio(ours: np.ndarray, theirs: np.ndarray) -> Estimate:
    """Factor on the stress over depth (c, s, 2) of others, over plates."""
    base = theirs.mean(axis=1, keepdims=True)
    return ratio_interval(
        *(
            (each * base).sum(axis=2).ravel() / (base**2).sum(axis=2).repeat(each.shape[1])
            for each in (ours, theirs)
        )
    )


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

    @cached_property
    def means(self) -> np.ndarray:
        """Stress over depth (c, 2) in N/m3 of each angle and direction."""
        return np.nanmean(self.plates.alpha, axis=1)

    @property
    def scale(self) -> Estimate:
        """On the generic profile."""
        return factor(self.resistance, GENERIC)

    def left(self, profile: np.ndarray) -> float:
        """Share of the stress that a profile leaves: root mean square."""
        form = Resistance(profile, np.zeros((9, 9))).alpha(self.plates.angle, self.plates.direction)
        return float(np.sqrt(np.mean((self.means - form) ** 2) / np.mean(self.means**2)))

    @property
    def generic(self) -> float:
        """Share that the generic profile leaves, once scaled."""
        return self.left(self.scale.value * GENERIC)

    @property
    def scatter(self) -> float:
        """Share that the scatter of beds alone would leave."""
        alpha = self.plates.alpha
        error = np.nanvar(alpha, axis=1, ddof=1) / alpha.shape[1]
        return float(np.sqrt(np.mean(error) / np.mean(self.means**2)))

    def table(self) -> Table:
        """One row per coefficient."""
        table = numbers("coefficient", "ours, N/cm3", "generic profile, scaled")
        sand, ours, half = (
            self.scale.value * GENERIC,
            self.resistance.coefficients,
            self.resistance.error,
        )
        for name, c, h, s in zip(NAMES, 1e-6 * ours, 1e-6 * half, 1e-6 * sand, strict=True):
            table.add_row(name, estimate((c, c - h, c + h), "", 3), f"{s:.3f}")
        return table

    @property
    def linear(self) -> bool:
        """Whether stress over depth is the same in all ranges of depth, within intervals."""
        _, shares = linearity(self.plates)
        return bool(((shares[:, 1] < 1.0) & (shares[:, 2] > 1.0)).all())


class Speed(Maps):
    """A few plates at another velocity."""

    command = "snakemake -j2 --configfile studies/rft/speeds.yaml"

    def __init__(self, block: str):
        self.name, self.block = f"{block}_speed", block

    @property
    def source(self) -> str:
        """Where the command writes it."""
        return f"rft/speeds/{self.block}/scene.nc"

    def over(self, other: "Speed") -> Estimate:
        """Factor on the stress at another velocity, over plates."""
        return ratio(self.plates.alpha, other.plates.alpha)


class Lengths(Findings):
    """Plates of two lengths, lengths.nc."""

    name, command = "lengths", "snakemake -j2 --configfile studies/rft/lengths.yaml"
    source = "rft/lengths/scene.nc"

    @cached_property
    def plates(self) -> list[Plates]:
        """What runs measured, by the length."""
        return [measured(self.dataset.isel(solids_plate_diameter=[at])) for at in (0, 1)]

    def _alpha(self, way: str) -> np.ndarray:
        """Stress over depth (2, c, s, 2) in N/m3 on plates of both lengths in a direction."""
        at = [np.abs(np.degrees(each.direction) - WAY[way]) < 0.1 for each in self.plates]
        return np.array([each.alpha[here] for each, here in zip(self.plates, at, strict=True)])

    def over(self, way: str) -> Estimate:
        """Stress on the longer plates over that on the shorter ones in a direction, over plates."""
        short, long = self._alpha(way)
        return ratio(long, short)

    def ends(self, way: str) -> tuple[np.ndarray, np.ndarray, int]:
        """Force over depth and thickness (c, 2) in N/m2 on the ends of plates, against x and upwards; its variance (2,)
        by beds, with degrees of freedom."""
        short, long = self.dataset["solids_plate_diameter"].values
        alpha, lever = self._alpha(way), 1.0 / (1.0 / short - 1.0 / long)
        seeds, freedom = alpha.shape[2], alpha[..., 0].size - alpha[..., 0, 0].size
        beds = 2.0 * lever**2 * alpha.var(axis=2, ddof=1).mean(axis=(0, 1)) / seeds
        return lever * np.subtract(*alpha.mean(axis=2)), beds, freedom

    def unequal(self, way: str) -> np.ndarray:
        """Variance (2,) of the force on ends over angles, over that by beds."""
        ends, beds, _ = self.ends(way)
        return ends.var(axis=0, ddof=1) / beds

    @property
    def limit(self) -> float:
        """Of that ratio where ends feel the same at all angles: it is higher in one case of twenty."""
        ends, _, freedom = self.ends("ahead")
        return float(fdtri(len(ends) - 1, freedom, 0.95))

    def claims(self, way: str) -> str:
        """Axes along which theory claims forces in a direction: ends feel the same at all angles."""
        return "".join(np.array(["x", "y"])[self.unequal(way) < self.limit])

    def table(self) -> Table:
        """One row per direction."""
        heads = "stress on longer plates", "ends, N/cm2, x", "y", "unequal, x", "y", "theory claims"
        table = numbers("direction", *heads)
        for way in WAY:
            ends, beds, freedom = self.ends(way)
            half = 1e-4 * student(np.sqrt(beds / len(ends)), freedom)
            row = [
                interval(e, h, "", 3) for e, h in zip(1e-4 * ends.mean(axis=0), half, strict=True)
            ]
            row += [f"{ratio:.1f}" for ratio in self.unequal(way)]
            table.add_row(way, estimate(self.over(way)), *row, self.claims(way) or "none")
        return table


class Forces(Findings):
    """Outlines that no coefficient was fitted to; sums as in SUMS."""

    def __init__(self, name: str, *sweeps: str):
        self.name, self.sweeps = name, " ".join(sweeps)

    @property
    def source(self) -> str:
        """Where the command writes it."""
        return f"rft/{self.name}.nc"

    @property
    def command(self) -> str:
        """After the sweeps."""
        data = "results/rft/lengths/scene.nc"
        return f"python -m studies rft proof {data} {self.sweeps} -o results/{self.source}"

    @cached_property
    def force(self) -> xr.DataArray:
        """In N, with its ends: measured, and by each sum."""
        return self.dataset["force"].transpose("by", "end", "axis", "cell")

    @cached_property
    def good(self) -> xr.DataArray:
        """Whether components are predicted within a tenth, or differ by less than the intervals of both."""
        off = np.abs(self.force - self.force.sel(by="measured"))[:, 0]
        half = (self.force[:, 2] - self.force[:, 0]).reset_coords(drop=True)
        return (off <= CLOSE * np.abs(self.force.sel(by="measured")[0])) | (
            off <= np.hypot(half, half.sel(by="measured"))
        )

    def at(self, **labels: str) -> np.ndarray:
        """Numbers of cells with some labels: outline, direction."""
        here = [self.dataset[name].values == label for name, label in labels.items()]
        return np.flatnonzero(np.all([np.ones(self.dataset.sizes["cell"], bool), *here], axis=0))

    def count(self, by: str = "plates", axes: str = "xy", **labels: str) -> np.ndarray:
        """How many components are good, and of how many."""
        good = self.good.sel(by=by, axis=list(axes))[:, self.at(**labels)]
        return np.array([good.sum(), good.size])

    def claimed(self, **labels: str) -> np.ndarray:
        """The same of those that theory claims."""
        ways = dict.fromkeys(self.dataset["direction"].values.tolist())
        return sum(self.count(axes=lengths.claims(way), direction=way, **labels) for way in ways)

    def over(self, by: str = "plates", **labels: str) -> float:
        """Length of predicted over that of measured forces, by the mean of its logarithm."""
        size = np.hypot(*self.force[:, 0, :, self.at(**labels)].transpose("axis", "by", "cell"))
        return float(np.exp(np.log(size.sel(by=by) / size.sel(by="measured")).mean()))

    def lacks(self, axis: str, **labels: str) -> float:
        """Mean of measured less predicted forces (mN)."""
        value = self.force[:, 0, :, self.at(**labels)].sel(axis=axis).mean("cell")
        return float(1e3 * (value.sel(by="measured") - value.sel(by="plates")))

    def exponent(self, direction: str) -> Estimate:
        """Of the power of depth by which forces grow between the two depths, over outlines."""
        cells = self.at(direction=direction)
        force = np.hypot(*self.force.sel(by="measured")[0, :, cells].values)
        steps = np.diff(np.log([force, self.dataset["depth"].values[cells]]).reshape(2, -1, 2))[
            ..., 0
        ]
        return mean_interval(steps[0] / steps[1])

    def rises(self, along: str, axis: str) -> np.ndarray:
        """How many forces are larger at the next depth or speed, and of how many."""
        size = np.abs(self.force.sel(by="measured", axis=axis)[0])
        size = size.assign_coords(depth=("cell", np.round(1e3 * self.dataset["depth"].values)))
        steps = size.set_index(cell=["depth", "speed"]).unstack("cell").diff(along)
        return np.array([(steps > 0.0).sum(), steps.size])

    def halves(self) -> Estimate:
        """Drag of halves of a disc that move ahead over that of the disc, by depth and side."""
        drag = self.force.sel(by="measured", axis="x")[0]
        whole, *sides = (
            drag[self.at(outline=outline, direction="ahead")].values
            for outline in ("disc", "round ahead", "flat ahead")
        )
        return mean_interval(np.ravel(sides / whole))

    def shares(self, name: str) -> Table:
        """Good forces by direction and axis, a row per sum or per outline."""
        places = list(product(dict.fromkeys(self.dataset["direction"].values.tolist()), "xy"))
        table = numbers(name, *(f"{way}, {axis}" for way, axis in places), "all", "over measured")
        outlines = dict.fromkeys(self.dataset["outline"].values.tolist())
        rows = (
            {by: {"by": by} for by in SUMS}
            if name == "sum over"
            else {x: {"outline": x} for x in outlines}
        )
        for row, at in rows.items():
            counts = [self.count(axes=axis, direction=way, **at) for way, axis in places]
            words = ["{} of {}".format(*count) for count in (*counts, self.count(**at))]
            table.add_row(SUMS.get(row, row), *words, f"{self.over(**at):.2f}")
        return table

    def forces(self) -> Table:
        """One row per cell: forces along x and y in mN; bold what is not good."""
        heads = [f"{axis}, {words}" for axis in "xy" for words in ("measured", "predicted")]
        table = numbers("outline", "direction", "depth, mm", "velocity, m/s", *heads, words=2)
        for number in self.at():
            cell, row = self.force[..., number], []
            for axis, by in product("xy", ("measured", "plates")):
                value, _, high = 1e3 * cell.sel(axis=axis, by=by).values
                text = interval(value, high - value, "", 1)
                row.append(text if self.good[..., number].sel(axis=axis, by=by) else f"**{text}**")
            place = f"{1e3 * self.dataset['depth'][number]:.0f}", f"{cell['speed']:g}"
            table.add_row(cell["outline"].item(), cell["direction"].item(), *place, *row)
        return table


class Kinds(Findings):
    """The plate of eight diameters in several kinds of grains, kinds.nc."""

    name, command = "kinds", "snakemake -j2 --configfile studies/rft/sweep.yaml"
    source = "rft/kinds/scene.nc"

    @cached_property
    def grains(self) -> dict[str, Maps]:
        """Maps by kind."""
        return {
            name: rft.of(self.dataset.sel(grains=name))
            for name in self.dataset["grains"].values.tolist()
        }

    def over(self, grains: str) -> Estimate:
        """Factor on the coefficients of discs."""
        discs = self.grains["discs"].resistance
        return factor(self.grains[grains].resistance, discs.coefficients, discs.covariance)

    def left(self, grains: str) -> float:
        """Share that the profile of discs leaves, once scaled."""
        discs = self.grains["discs"].resistance.coefficients
        return self.grains[grains].left(self.over(grains).value * discs)

    def own(self, grains: str) -> float:
        """Share that nine coefficients of their own leave."""
        return self.grains[grains].resistance.left

    @property
    def generic_leaves_more(self) -> bool:
        """Whether the generic profile leaves more than that of discs, both scaled, of all grains."""
        return all(maps.generic > self.left(name) for name, maps in self.grains.items())

    def table(self) -> Table:
        """One row per kind of grains."""
        heads = "factor on the generic profile", "it leaves", "factor on that of discs", "it leaves"
        table = numbers("grains", *heads, "nine coefficients leave", "scatter of beds")
        for name, maps in self.grains.items():
            shares = [
                percent(share)
                for share in (maps.generic, self.left(name), self.own(name), maps.scatter)
            ]
            scales = estimate(maps.scale, "", 3), estimate(self.over(name))
            table.add_row(name, scales[0], shares[0], scales[1], *shares[1:])
        return table


rft, kinds, lengths = Maps(), Kinds(), Lengths()
proof = Forces("proof", "outlines", "half", "corner")
lift = Forces("lift", "lift")
half_speed, usual_speed, twice_speed = Speed("half"), Speed("usual"), Speed("twice")
