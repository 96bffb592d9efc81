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
from studies.accuracy.pairs import Contact, Pairs, dot, make_pairs, starts
from studies.common.timing import one_core

SEED = 1
WRONG_OVERLAP = 0.1  # a contact whose overlap is off by more than this share,
WRONG_NORMAL = 0.1  # or whose normal is by more than this (rad), has failed
COLD = "cold"
DEFAULT = trials.common_normal(CommonNormal().tolerance).name
BED_RATIO = 1.375  # greatest aspect ratio in the beds of the paper
SLIGHT = 0.01  # excess of an aspect ratio over 1 that no bed has, unless it is 0
BED_OVERLAPS = (1e-6, 0.3)  # what their contacts pass through, over b


class Plan(NamedTuple):
    """pairs: a stratum, a multiple of 64; checked: of these, compared with the definitions in
    extended precision; repeats: of each timing.

    Strata: aspect ratios; overlaps over the smaller b; starts, rad off the right normal, NaN for
    the line of centres. tolerances (rad): of the common normal.
    """

    pairs: int = 1024
    checked: int = 128
    repeats: int = 9
    ratios: tuple[float, ...] = (1.0, 1.0 + 1e-8, 1.125, 1.375, 2.0, 5.0, 10.0)
    overlaps: tuple[float, ...] = (1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.1, 0.3, 0.6)
    starts: tuple[float, ...] = (0.0, 1e-4, 1e-2, np.nan)
    tolerances: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-6)

    @property
    def methods(self) -> list[trials.Method]:
        """All that are compared."""
        return [*map(trials.common_normal, self.tolerances), trials.POTENTIAL]


USUAL = Plan()
SMOKE = Plan(
    pairs=64, checked=16, repeats=2, ratios=(1.0, 1.375), overlaps=(1e-6, 1e-2, 0.3),
    tolerances=(1e-2, 1e-4),
)  # fmt: skip


def errors(contact: Contact, right: Contact):
    """Of the overlap over the right one, and of the normal (rad); NaN where there is no contact."""
    overlap = np.abs(contact.overlap - right.overlap) / np.abs(right.overlap)
    sine = contact.normal[:, 0] * right.normal[:, 1] - contact.normal[:, 1] * right.normal[:, 0]
    normal = np.abs(np.arctan2(sine, dot(contact.normal, right.normal)))
    return overlap.astype(float), normal.astype(float)


def worst(values) -> float:
    """The greatest that is a number, or NaN."""
    return np.fmax.reduce(values)


def worst_errors(of: str, contact: Contact, right: Contact) -> dict:
    """Worst errors where both have a contact."""
    overlap, normal = map(worst, errors(contact, right))
    return {f"contact_{of}_overlap_error": overlap, f"contact_{of}_normal_error": normal}


def against_truth(contact: Contact, pairs: Pairs) -> dict:
    """Share that fails, and worst error; a missed contact has an overlap of zero: an error of 1."""
    overlap, normal = errors(contact, pairs.truth)
    good = (overlap <= WRONG_OVERLAP) & (normal <= WRONG_NORMAL)
    overlap = np.where(np.isnan(overlap), 1.0, overlap)
    return {"contact_failures": 1.0 - good.mean(), "contact_overlap_error": worst(overlap)}


def measure_stratum(rng, plan: Plan, ratio: float, overlap: float) -> dict:
    """Variables of one aspect ratio and overlap, over methods first, then starts."""
    pairs = make_pairs(rng, plan.pairs, ratio, overlap)
    some, methods = pairs.first(plan.checked), plan.methods
    guesses = [starts(rng, pairs, off) for off in plan.starts]
    rows, known, shape = [], [], (len(methods), len(guesses))
    for method in methods:
        right = method.definition(some)
        known.append(worst_errors("definition", right, some.truth))
        for guess in guesses:
            contact = trials.find(method, pairs, guess)
            checked = Contact(*(array[: plan.checked] for array in contact))
            rows.append(against_truth(contact, pairs) | worst_errors("solver", checked, right))
    spent = trials.time_all([(m, g) for m in methods for g in guesses], pairs, plan.repeats)
    found = {name: np.reshape([row[name] for row in rows], shape) for name in rows[0]}
    found |= {name: np.array([row[name] for row in known]) for name in known[0]}
    return found | {"contact_time": spent.reshape(*shape, -1)}


def measure(plan: Plan = USUAL, progress=lambda done: None) -> dict:
    """Variables of studies.accuracy.layout; progress gets the share done."""
    rng, grid = np.random.default_rng(SEED), []
    with one_core():
        for i, ratio in enumerate(plan.ratios):
            grid.append([])
            for j, overlap in enumerate(plan.overlaps):
                grid[i].append(measure_stratum(rng, plan, ratio, overlap))
                progress((i + (j + 1) / len(plan.overlaps)) / len(plan.ratios))
    values = {
        name: np.moveaxis([[stratum[name] for stratum in row] for row in grid], 2, 0)
        for name in grid[0][0]
    }
    labels = [COLD if np.isnan(off) else f"{off:g} rad" for off in plan.starts]
    return values | {
        "contact_method": np.array([method.name for method in plan.methods]),
        "contact_kind": np.array([method.kind for method in plan.methods]),
        "contact_remembers": np.array([bool(method.doubts) for method in plan.methods], np.int8),
        "contact_aspect_ratio": np.array(plan.ratios),
        "contact_overlap": np.array(plan.overlaps),
        "contact_start": np.array(labels),
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
