"""Resistive force theory: stress on a small plate over its depth, measured, fitted, summed over outlines.

A plate of length L that moves slowly at a depth z below a free surface feels a stress that grows with
z, and depends on its angle beta and its direction gamma:

    sigma_x = -alpha_x(beta, gamma) z,    sigma_y = alpha_y(beta, gamma) z,

beta anticlockwise from the horizontal, gamma downwards from the direction of x, in which the plate
moves (a plate that moves along -x is seen in a mirror). Li, Zhang and Goldman (Science 339, 1408, 2013,
arXiv 1303.7065) fit nine terms of a Fourier series to both, and sum them over the leading sides of an
outline. alpha_y is their alpha_z. SI units: alpha in N/m3, angles in rad.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from dem.analysis.values import value_of
from dem.base.errors import InputError
from dem.base.files import atomic, check_output
from dem.base.statistics import Estimate, bootstrap_weights, mean_interval, student
from dem.io.dataset import FORMAT

NAMES = (
    "A00",
    "A10",
    "B11",
    "B01",
    "B-11",
    "C11",
    "C01",
    "C-11",
    "D10",
)  # of alpha_y, then of alpha_x
UP = 5  # terms of alpha_y
# of many sands, poppy seeds and glass beads (Li, Zhang and Goldman 2013, supplement), in N/m3
GENERIC = 1e6 * np.array([0.206, 0.169, 0.212, 0.358, 0.055, -0.124, 0.253, 0.007, 0.088])
MOVED = 0.1  # of the mean depth: a plate whose depth changes by more says how stress grows with it
BEGIN = 0.4  # share of the way after which the force has forgotten its beginning


def terms(angle: ArrayLike, direction: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Terms (..., 9) of alpha_y and of alpha_x at angles beta and directions gamma (rad)."""
    b, g = 2.0 * np.asarray(angle), np.asarray(direction)
    zero = np.zeros(np.broadcast_shapes(b.shape, g.shape))
    up = zero + 1.0, zero + np.cos(b), np.sin(b + g), zero + np.sin(g), np.sin(g - b)
    against = np.cos(b + g), zero + np.cos(g), np.cos(g - b), zero + np.sin(b)
    none = [zero] * UP, [zero] * len(against)
    return np.stack([*up, *none[1]], axis=-1), np.stack([*none[0], *against], axis=-1)


class Plates(NamedTuple):
    """What the runs of a plate measured, in c cells of an angle and a direction, with s seeds each.

    Attributes
    ----------
    angle, direction : ndarray of shape (c,)
        beta and gamma (rad).
    depth : ndarray of shape (c, s, t)
        Depth of the middle of the plate (m) in t bins.
    stress : ndarray of shape (c, s, t, 2)
        Stress (Pa) against the motion along x, and upwards; NaN of runs that failed.
    """

    angle: np.ndarray
    direction: np.ndarray
    depth: np.ndarray
    stress: np.ndarray

    @property
    def alpha(self) -> np.ndarray:
        """Stress over depth (c, s, 2) in N/m3 of each run, by least squares."""
        squared = (self.depth**2).sum(axis=2)[..., None]
        return (self.stress * self.depth[..., None]).sum(axis=2) / squared


def mirrored(angle: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """beta and gamma (rad) of plates at angles (n,), anticlockwise, with velocities (n, 2) in m/s; and
    the sign of x (n,): -1 of those that are seen in a mirror."""
    x, y = np.moveaxis(velocity, -1, 0)
    sign = np.where(x < -1e-9 * np.abs(y), -1.0, 1.0)
    beta = np.pi / 2.0 - np.mod(np.pi / 2.0 - sign * angle, np.pi)
    return (
        np.where(np.abs(beta + np.pi / 2.0) < 1e-4, np.pi / 2.0, beta),
        np.arctan2(-y, sign * x),
        sign,
    )


def measured(dataset: xr.Dataset) -> Plates:
    """Stress over depth from the runs of a plate, scene.nc of config/rft.yaml.

    Raises InputError where the runs have no single solid that moves below a free surface.
    """
    if dataset.sizes.get("solid") != 1:
        raise InputError("its runs must have one solid, the plate.")
    needed = [
        "solid_force_x",
        "solid_force_y",
        "solid_x",
        "solid_y",
        "solid_angle",
        "surface_height",
        "snapshot_time",
    ]
    runs = dataset[needed].isel(solid=0).load()
    runs = runs if "seed" in runs.dims else runs.expand_dims("seed")
    beside = {"seed", "time", "snapshot", "cell"}
    runs = runs.stack(cell_of=[dim for dim in runs.dims if dim not in beside])
    plate = dataset["solid"].item()
    length = value_of(runs, f"solids.{plate}.diameter")
    size = length * value_of(runs, "material.thickness")
    way = (
        runs[["solid_x", "solid_y"]]
        .to_array("axis")
        .transpose("cell_of", "seed", "snapshot", "axis")
    )
    share = (runs["time"] / runs["snapshot_time"][-1]).values
    late = share >= BEGIN
    first, last = way[:, :, 0].values, way[:, :, -1].values
    turned = runs["solid_angle"].isel(snapshot=0).transpose("cell_of", "seed").values
    beta, gamma, sign = mirrored(turned, last - first)
    surface = runs["surface_height"].isel(snapshot=0).median("cell").transpose("cell_of", "seed")
    y = first[..., 1, None] + share[late] * (last - first)[..., 1, None]
    depth = surface.values[..., None] - y
    end = 0.5 * np.reshape(length.values, (-1, 1)) * np.abs(np.sin(turned))
    if not np.nanmin(depth - end[..., None]) > 0.0:
        raise InputError("its plate leaves the bed; let all of it stay below the surface.")
    force = runs[["solid_force_x", "solid_force_y"]].to_array("axis")
    force = force.transpose("cell_of", "seed", "time", "axis").values[:, :, late]
    stress = force / np.reshape(size.values, (-1, 1, 1, 1))
    stress[..., 0] *= -sign[..., None]
    return Plates(np.nanmean(beta, axis=1), np.nanmean(gamma, axis=1), depth, stress)


class Loads(NamedTuple):
    """Force along x and y (N) and torque (N m) on an outline, each with its 95 % interval."""

    force_x: Estimate
    force_y: Estimate
    torque: Estimate


class Resistance(NamedTuple):
    """Nine coefficients of resistive force theory, and how well they are known.

    Attributes
    ----------
    coefficients : ndarray of shape (9,)
        In N/m3, in the order of `NAMES`.
    covariance : ndarray of shape (9, 9)
        Of the coefficients ((N/m3)^2), from beds that are drawn again.
    left : float
        What the form cannot express: root mean square of measured less fitted stress over depth
        (N/m3), over that of what was measured, without unit.
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    left: float = 0.0

    @property
    def scale(self) -> float:
        """Factor by which the generic profile of Li, Zhang and Goldman is nearest to this one."""
        return float(GENERIC @ self.coefficients / (GENERIC @ GENERIC))

    @property
    def error(self) -> np.ndarray:
        """Half the 95 % intervals (9,) of the coefficients (N/m3)."""
        return student(np.sqrt(np.diag(self.covariance)), np.inf)

    def alpha(self, angle: ArrayLike, direction: ArrayLike) -> np.ndarray:
        """Stress over depth (..., 2) in N/m3 of plates at angles beta with directions gamma (rad): against
        the motion along x, and upwards."""
        up, against = terms(angle, direction)
        return np.stack([against @ self.coefficients, up @ self.coefficients], axis=-1)

    def loads(
        self,
        outline: ArrayLike,
        position: Sequence[float],
        velocity: Sequence[float],
        thickness: float,
        surface: float = 0.0,
        spin: float = 0.0,
    ) -> Loads:
        """Force and torque on a rigid outline that moves slowly through the bed.

        Parameters
        ----------
        outline : array_like of shape (k, 2)
            Closed outline (m) about the position, anticlockwise, as `Solid.placed` returns it.
        position : tuple of float
            Position (x, y) in m, about which the torque is.
        velocity : tuple of float
            Velocity (x, y) of the position in m/s.
        thickness : float
            Thickness (m) out of the plane.
        surface : float
            Height (m) of the free surface.
        spin : float
            Angular velocity (rad/s), anticlockwise.

        Returns
        -------
        Loads
            Force and torque; each is summed over the sides that move into the bed, below the surface.

        Raises
        ------
        InputError
            If the outline is not one of finite points.
        """
        ring = np.asarray(outline, float)
        if ring.ndim != 2 or ring.shape[-1] != 2 or not np.isfinite(ring).all():
            raise InputError("outline must be points (x, y), in m.")
        side, middle = np.diff(ring, axis=0), 0.5 * (ring[1:] + ring[:-1])
        moving = np.asarray(velocity) + spin * np.column_stack([-middle[:, 1], middle[:, 0]])
        depth = surface - position[1] - middle[:, 1]
        leads = (side[:, 1] * moving[:, 0] - side[:, 0] * moving[:, 1] > 0.0) & (depth > 0.0)
        side, middle, depth = side[leads], middle[leads], depth[leads]
        beta, gamma, sign = mirrored(np.arctan2(side[:, 1], side[:, 0]), moving[leads])
        up, against = terms(beta, gamma)
        weight = (depth * np.hypot(*side.T) * thickness)[:, None]
        fx, fy = -sign[:, None] * against * weight, up * weight
        parts = fx, fy, middle[:, :1] * fy - middle[:, 1:] * fx
        return Loads(*(self._estimate(part.sum(axis=0)) for part in parts))

    def _estimate(self, weights: np.ndarray) -> Estimate:
        value = float(weights @ self.coefficients)
        half = float(student(np.sqrt(weights @ self.covariance @ weights), np.inf))
        return Estimate(value, value - half, value + half)


def fitted(plates: Plates) -> Resistance:
    """The nine coefficients by least squares over the cells, and their covariance.

    In each cell the seeds are drawn again on their own. Raises InputError where there are too few
    angles, directions or seeds.
    """
    up, against = terms(plates.angle, plates.direction)
    design = np.concatenate([against, up])
    if np.linalg.matrix_rank(design) < len(NAMES):
        raise InputError(
            "its plates have too few angles and directions for nine coefficients; give three of each or "
            "more."
        )
    alpha = plates.alpha
    there = np.isfinite(alpha).all(axis=-1)
    seeds = there.sum(axis=1)
    if seeds.min() < 2:
        raise InputError("a plate has fewer than two runs; let there be two seeds or more.")
    means = np.nanmean(alpha, axis=1)  # (c, 2)
    off = np.where(there[..., None], alpha - means[:, None], 0.0)
    weights = bootstrap_weights(there.shape[1], len(means))[1:] * there  # (r, c, s)
    weights /= np.maximum(weights.sum(axis=2, keepdims=True), 1e-300)
    drawn = np.einsum("rcs,csd->rdc", weights, off) * np.sqrt(seeds / (seeds - 1.0))
    inverse, wanted = np.linalg.pinv(design), means.T.ravel()
    coefficients = inverse @ wanted
    covariance = np.cov(inverse @ drawn.reshape(len(weights), -1).T)
    rest = wanted - design @ coefficients
    left = float(np.sqrt(np.mean(rest**2) / np.mean(wanted**2)))
    return Resistance(coefficients, covariance, left)


def linearity(plates: Plates, bins: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Edges (bins + 1,) of depth (m), and what stress is there over its depth times what `Plates.alpha`
    has of its run (bins, 3): the mean over plates that move up or down, without unit, and its 95 %
    interval over seeds."""
    way = np.nanmax(np.ptp(plates.depth, axis=2), axis=1)
    moves = way >= min(MOVED * np.nanmean(plates.depth), np.nanmax(way))
    depth, stress = plates.depth[moves], plates.stress[moves]
    expected = plates.alpha[moves][:, :, None] * depth[..., None]
    edges = np.linspace(np.nanmin(depth), np.nanmax(depth), bins + 1)
    place = np.clip(np.digitize(depth, edges) - 1, 0, bins - 1)
    rows = []
    for k in range(bins):
        here = ((place == k) & np.isfinite(stress[..., 0]))[..., None]
        shares = (np.where(here, stress, 0.0) * expected).sum(axis=(0, 2, 3))
        rows.append(mean_interval(shares / np.where(here, expected**2, 0.0).sum(axis=(0, 2, 3))))
    return edges, np.array(rows)


def dataset_of(plates: Plates, resistance: Resistance, of: dict) -> xr.Dataset:
    """All of it as a dataset; of: attributes of the file that the runs are in."""
    edges, shares = linearity(plates)
    fit = resistance.alpha(plates.angle, plates.direction)
    against = "stress over depth, against the motion along x, and upwards"
    variables = {
        "angle": ("plate", plates.angle, "rad", "angle of the plate, anticlockwise"),
        "direction": ("plate", plates.direction, "rad", "direction, downwards from that of x"),
        "alpha": (("plate", "seed", "axis"), plates.alpha, "N m-3", against),
        "alpha_fitted": (("plate", "axis"), fit, "N m-3", f"{against}, by the coefficients"),
        "coefficient": ("name", resistance.coefficients, "N m-3", "coefficient"),
        "half_interval": ("name", resistance.error, "N m-3", "half its 95 % interval"),
        "generic": (
            "name",
            resistance.scale * GENERIC,
            "N m-3",
            "generic profile, times the scale",
        ),
        "covariance": (("name", "other"), resistance.covariance, "N2 m-6", "of the coefficients"),
        "depth": ("bin", 0.5 * (edges[1:] + edges[:-1]), "m", "depth below the surface"),
        "linearity": (
            ("bin", "end"),
            shares,
            "1",
            "stress over depth relative to that of the whole run, with its interval",
        ),
    }
    tables = {
        name: (dims, values, {"units": units, "long_name": words})
        for name, (dims, values, units, words) in variables.items()
    }
    attrs = {"Conventions": "CF-1.11", "title": f"Resistive force theory: {of['title']}"}
    attrs |= {
        "configuration": of["configuration"],
        "scale": resistance.scale,
        "left": resistance.left,
    }
    return xr.Dataset(tables, {"name": list(NAMES), "axis": ["x", "y"]}, attrs)


def write(result: xr.Dataset, output: Path) -> None:
    """Write it as netCDF; or as JSON, the coefficients by name and their covariance in this order."""
    check_output("output", output, (".nc", ".json"))
    with atomic(output) as part:
        if output.suffix == ".nc":
            result.to_netcdf(part, format=FORMAT)
            return
        names = {
            name: result[name].to_series().to_dict() for name in ("coefficient", "half_interval")
        }
        names |= {"unit": "N/m3", "covariance": result["covariance"].values.tolist()}
        names |= result.attrs | {"configuration": json.loads(result.attrs["configuration"])}
        part.write_text(json.dumps(names, indent=1) + "\n", encoding="utf-8")
