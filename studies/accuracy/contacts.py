"""Error of a contact against the time to find it, by method.

Every method meets the same pairs of ellipses with known contacts. Its error has two parts: the
solver against its own definition in extended precision, and the definition against the common
normal, the direction of the shortest translation that separates the two.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.shapes.common_normal import CommonNormal
from studies.accuracy import trials
from studies.accuracy.pairs import Contact, Pairs, difference, dot, make_pairs, starts
from studies.common.timing import one_core

SEED = 1
WRONG_OVERLAP = 0.1  # a contact whose overlap is off by more than this share,
WRONG_NORMAL = 0.1  # or whose normal is by more than this (rad), has failed
COLD = "cold"
DEFAULT = trials.common_normal(CommonNormal().tolerance).name
BED_RATIO = 1.375  # greatest aspect ratio in the beds of the paper
SLIGHT = 0.01  # excess of an aspect ratio over 1 that no bed has, unless it is 0
BED_OVERLAPS = (1e-6, 0.3)  # what their contacts pass through, over b
PARTS = ("overlap", "normal", "point")


class Plan(NamedTuple):
    """pairs: a stratum, a multiple of 64; checked: of these, compared with the definitions in
    extended precision, and confirmed, with 50 digits; repeats: of each timing.

    Strata: aspect ratios; overlaps over the smaller b; starts, rad off the right normal, NaN for
    the line of centres. Methods: tolerances (rad) of the common normal, sides of polygons. gap:
    over b, between ellipses that are near but apart.
    """

    pairs: int = 1024
    checked: int = 128
    confirmed: int = 1
    repeats: int = 9
    ratios: tuple[float, ...] = (1.0, 1.0 + 1e-8, 1.125, 1.375, 2.0, 5.0, 10.0)
    overlaps: tuple[float, ...] = (1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.1, 0.3, 0.6)
    starts: tuple[float, ...] = (0.0, 1e-4, 1e-2, np.nan)
    tolerances: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-6)
    sides: tuple[int, ...] = (16, 64, 256)
    gap: float = 1e-2

    @property
    def methods(self) -> list[trials.Method]:
        """All that are compared."""
        return [
            *map(trials.common_normal, self.tolerances),
            trials.POTENTIAL,
            trials.INTERSECTION,
            *map(trials.polygon, self.sides),
        ]


USUAL = Plan()
SMOKE = Plan(
    pairs=64, checked=16, repeats=2, ratios=(1.0, 1.375), overlaps=(1e-6, 1e-2, 0.3),
    tolerances=(1e-2, 1e-4), sides=(16, 64),
)  # fmt: skip


def errors(contact: Contact, right: Contact, size):
    """Of the overlap over the right one, of the normal (rad), of the contact point over `size`."""
    overlap = np.abs(contact.overlap - right.overlap) / np.abs(right.overlap)
    sine = contact.normal[:, 0] * right.normal[:, 1] - contact.normal[:, 1] * right.normal[:, 0]
    normal = np.abs(np.arctan2(sine, dot(contact.normal, right.normal)))
    apart = contact.point - right.point
    return [each.astype(float) for each in (overlap, normal, np.sqrt(dot(apart, apart)) / size)]


def worst(values) -> float:
    """The greatest that is a number, or NaN."""
    return np.fmax.reduce(values)


def against_truth(contact: Contact, pairs: Pairs, prefix: str) -> dict:
    """Errors, and the share that fails; a missed contact has an overlap of zero: an error of 1."""
    overlap, normal, point = errors(contact, pairs.truth, pairs.least_axis)
    missed = np.isnan(overlap)
    failed = missed | (overlap > WRONG_OVERLAP) | (normal > WRONG_NORMAL)
    result = {f"{prefix}_failures": failed.mean()}
    for part, values in zip(PARTS, (np.where(missed, 1.0, overlap), normal, point), strict=True):
        result[f"{prefix}_{part}_error"] = worst(values)
        known = values[~np.isnan(values)]
        result[f"{prefix}_{part}_error_median"] = np.median(known) if len(known) else np.nan
    return result


def against_definition(contact: Contact, right: Contact, size) -> dict:
    """Errors of the solver, where both have a contact, and how often only one of them has."""
    result = {
        "contact_solver_misses": (np.isnan(contact.overlap) != np.isnan(right.overlap)).mean()
    }
    for part, values in zip(PARTS, errors(contact, right, size), strict=True):
        result[f"contact_solver_{part}_error"] = worst(values)
    return result


class Turns(NamedTuple):
    """What is timed in turns, (method, start) as indices (t, 2), and which of these counts for
    each method and start (m, s): a method without memory is the same from every start."""

    order: list[tuple[int, int]]
    counted: np.ndarray

    @classmethod
    def of(cls, methods, starts: int) -> "Turns":
        order = [
            (m, s)
            for m, method in enumerate(methods)
            for s in range(starts if method.remembers else 1)
        ]
        counted = [
            [order.index((m, s if method.remembers else 0)) for s in range(starts)]
            for m, method in enumerate(methods)
        ]
        return cls(order, np.array(counted))


def measure_stratum(rng, plan: Plan, ratio: float, overlap: float) -> dict:
    """Variables of one aspect ratio and overlap, over methods first, then starts."""
    pairs = make_pairs(rng, plan.pairs, ratio, overlap)
    some, methods = pairs.first(plan.checked), plan.methods
    guesses = [starts(rng, pairs, off) for off in plan.starts]
    rights = [method.definition(some) for method in methods]
    turns, rows = Turns.of(methods, len(guesses)), []
    for m, s in turns.order:
        contact = trials.find(methods[m], pairs, guesses[s])
        checked = Contact(*(array[: plan.checked] for array in contact))
        rows.append(
            against_truth(contact, pairs, "contact")
            | against_definition(checked, rights[m], some.least_axis)
        )
    spent = trials.time_all(
        [(methods[m], guesses[s]) for m, s in turns.order], pairs, plan.repeats
    )  # fmt: skip
    known = [against_truth(right, some, "contact_definition") for right in rights]
    result = {name: np.array([row[name] for row in rows])[turns.counted] for name in rows[0]}
    result |= {name: np.array([row[name] for row in known]) for name in known[0]}
    confirmed = max(max(difference(pairs, k)) for k in range(plan.confirmed))
    return result | {"contact_time": spent[turns.counted], "contact_truth_error": confirmed}


def reject_times(rng, plan: Plan, ratio: float):
    """Seconds per pair (method, start, repeat) of ellipses that are near but apart."""
    pairs, methods = make_pairs(rng, plan.pairs, ratio, -plan.gap), plan.methods
    guesses = [starts(rng, pairs, off) for off in plan.starts]
    turns = Turns.of(methods, len(guesses))
    tried = [(methods[m], guesses[s]) for m, s in turns.order]
    return trials.time_all(tried, pairs, plan.repeats)[turns.counted]


def measure(plan: Plan = USUAL, progress=lambda done: None) -> dict:
    """Variables of studies.accuracy.layout_contacts; progress gets the share done."""
    rng = np.random.default_rng(SEED)
    grid, rejected = [], []
    with one_core():
        for i, ratio in enumerate(plan.ratios):
            grid.append([])
            for j, overlap in enumerate(plan.overlaps):
                grid[i].append(measure_stratum(rng, plan, ratio, overlap))
                progress((i + (j + 1) / len(plan.overlaps)) / len(plan.ratios))
            rejected.append(reject_times(rng, plan, ratio))
    values = {}
    for name in grid[0][0]:
        table = np.array([[stratum[name] for stratum in row] for row in grid])
        values[name] = np.moveaxis(table, 2, 0) if table.ndim > 2 else table  # methods first
    labels = [COLD if np.isnan(off) else f"{off:g} rad" for off in plan.starts]
    return values | {
        "contact_reject_time": np.moveaxis(np.array(rejected), 1, 0),
        "contact_method": np.array([method.name for method in plan.methods]),
        "contact_kind": np.array([method.kind for method in plan.methods]),
        "contact_remembers": np.array([method.remembers for method in plan.methods], np.int8),
        "contact_aspect_ratio": np.array(plan.ratios),
        "contact_overlap": np.array(plan.overlaps),
        "contact_start": np.array(labels),
        "contact_pairs": plan.pairs,
        "contact_checked_pairs": plan.checked,
        "contact_gap": plan.gap,
    }


def in_the_beds(dataset: xr.Dataset) -> xr.Dataset:
    """The strata that the beds of the paper visit, with carried normals."""
    ratio, overlap = dataset["contact_aspect_ratio"].values, dataset["contact_overlap"].values
    low, high = BED_OVERLAPS
    visited = (ratio <= BED_RATIO) & ((ratio == 1.0) | (ratio > 1.0 + SLIGHT))
    return dataset.isel(
        contact_aspect_ratio=np.flatnonzero(visited),
        contact_overlap=np.flatnonzero((low <= overlap) & (overlap <= high)),
        contact_start=np.flatnonzero(dataset["contact_start"].values != COLD),
    )


def pareto(dataset: xr.Dataset) -> xr.DataArray:
    """Whether a method is on the front of worst overlap error against time, for each stratum.

    It is, unless a method of another kind takes no longer and errs no more. Methods of one kind,
    which differ in one number, do not compete with each other.
    """
    spent, error = (
        dataset["contact_time"].median("contact_repeat"),
        dataset["contact_overlap_error"],
    )
    kind = dataset["contact_kind"].astype(str)
    rivals, their_error, their_kind = (
        a.rename(contact_method="rival") for a in (spent, error, kind)
    )
    better = (rivals < spent) | (their_error < error)
    beaten = better & (rivals <= spent) & (their_error <= error) & (their_kind != kind)
    return ~beaten.any("rival").transpose(*error.dims)
