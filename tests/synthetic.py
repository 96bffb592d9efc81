"""Files of runs that nobody made, whose truth is known."""

import json

import numpy as np
import xarray as xr
from sweeps import dataset_of

VELOCITY = np.array([0.03, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0])  # m/s
NUMBERS = np.array([0.01, 0.1])  # inertial ones
PRESSURE, DENSITY = 1e5, 2500.0  # Pa and kg/m3 of sheared beds


def drags(limit, growth, exponent, beds=6, scatter=0.1, noise=0.03, seed=1):
    """Drag (velocity, seed) in N: each bed has a level of its own, and each run some noise."""
    rng = np.random.default_rng(seed)
    level = rng.normal(1.0, scatter, beds)
    wobble = rng.normal(1.0, noise, (len(VELOCITY), beds))
    return (limit + growth * VELOCITY[:, None] ** exponent) * level * wobble


def drawn(drag, velocity=VELOCITY):
    """Runs with some drag (friction, velocity, seed) in N, the same along the stroke."""
    drag = np.asarray(drag, float)
    axes = {"friction": [str(place) for place in range(len(drag))], "cylinder_velocity": velocity}
    runs = dataset_of(drag, axes)
    runs = runs.assign(packing_pressure=(runs["run_id"].dims, np.full(drag.shape, 1e7)))
    configuration = json.dumps({"cylinder": {"diameter": 3e-3, "velocity": 2.0}})
    runs = runs.assign_attrs(cylinder_velocity=2.0, configuration=configuration)
    return runs.assign_coords(diameter=1e-3, density=4000.0).expand_dims("shape")


def sheared(friction, noise=0.02, seeds=3):
    """Runs whose beds have some friction (place, number), nine tenths of the rate that is asked for, and
    the packing fraction 0.8."""
    rng = np.random.default_rng(0)
    dims = "friction", "shear_inertial_number", "seed", "shear_strain"
    shape = (*np.shape(friction), seeds, 40)
    unit = np.sqrt(DENSITY * 0.25 * np.pi * 1e-6 / PRESSURE)  # s
    stress = PRESSURE * np.array(friction)[..., None, None]
    means = {
        "lid_shear_stress": stress,
        "lid_normal_stress": PRESSURE,
        "shear_stress": stress,
        "normal_stress": PRESSURE,
        "shear_rate": 0.9 * NUMBERS[:, None, None] / unit,
        "shear_fraction": 0.8,
    }
    variables = {name: (dims, mean * rng.normal(1.0, noise, shape)) for name, mean in means.items()}
    variables["run_id"] = dims[:-1], np.full(shape[:-1], "x")
    coordinates = {
        "friction": [str(place) for place in range(len(friction))],
        "shear_inertial_number": NUMBERS,
        "shear_strain": np.linspace(0.1, 4.0, 40),
    }
    cell = {"shear": {"pressure": PRESSURE, "strain": 4.0}}
    runs = xr.Dataset(variables, coordinates, {"configuration": json.dumps(cell)})
    return runs.assign_coords(diameter=1e-3, density=DENSITY)


def jammed(granules=(50, 100, 200), beds=4, noise=1e-3, ratios=2):
    """Beds of ellipses of several aspect ratios that jam, if of infinitely many granules, at the packing
    fraction 0.84, on four contacts a granule."""
    n, dims = np.array(granules)[:, None], ("shape", "ratio", "size", "seed")
    shape = 1, ratios, len(granules), beds
    scatter = noise * np.random.default_rng(1).standard_normal(shape) * np.sqrt(100.0 / n)
    return xr.Dataset(
        {
            "onset_fraction": (dims, 0.84 - 0.05 * n**-0.5 + scatter),
            "onset_contacts": (dims, np.broadcast_to(2.0 * n - 1.0, shape)),
            "onset_rattlers": (dims, np.zeros(shape)),
            "run_id": (dims, np.full(shape, "x")),
        },
        {
            "granules": (("shape", "size"), [list(granules)]),
            "aspect_ratio": (("shape", "ratio"), [np.linspace(1.0, 1.5, ratios)]),
            "seed": np.arange(beds),
        },
    )
