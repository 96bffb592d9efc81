"""Files of runs that nobody made, whose truth is known."""

import json

import numpy as np
import xarray as xr
from sweeps import dataset_of

from dem.analysis.rft import GENERIC, Plates, Resistance

VELOCITY = np.array([0.03, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0])  # m/s
NUMBERS = np.array([0.01, 0.1])  # inertial ones
PRESSURE, DENSITY = 1e5, 2500.0  # Pa and kg/m3 of sheared beds
KNOWN = Resistance(GENERIC, np.zeros((9, 9)))  # of sand in which plates are drawn
BETA, GAMMA = (
    x.ravel() for x in np.radians(np.meshgrid([-60, -30, 0, 30, 60, 90], np.arange(-90, 91, 45)))
)
THICKNESS, LENGTH = 1e-3, 8e-3  # m, of plates


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


def plates(noise=0.0, seeds=4, rng=None, beta=BETA, gamma=GAMMA):
    """Plates between 10 and 20 mm deep, with the known stress; noise (N/m3) differs between beds."""
    rng = rng or np.random.default_rng(1)
    alpha = KNOWN.alpha(beta, gamma)[:, None] + rng.normal(0.0, noise, (len(beta), seeds, 2))
    depth = np.broadcast_to(np.linspace(0.01, 0.02, 10), (len(beta), seeds, 10))
    return Plates(beta, gamma, depth, alpha[:, :, None] * depth[..., None])


def plated(plates, back=False, surface=0.04):
    """The same as a combined file of a scene; back: plates that move along -x, seen in a mirror."""
    (cells, seeds), side = plates.depth.shape[:2], -1.0 if back else 1.0
    way = 0.01 * np.stack([side * np.cos(plates.direction), -np.sin(plates.direction)])
    middle = np.array([0.0, surface - 0.015])
    place = middle[:, None, None] + way[..., None] * np.array([-0.5, 0.0, 0.5])
    share = (np.arange(50) + 0.5) / 50
    depth = surface - np.apply_along_axis(
        lambda y: np.interp(share, [0.0, 0.5, 1.0], y), 1, place[1]
    )
    force = plates.alpha[:, :, None] * depth[:, None, :, None] * LENGTH * THICKNESS
    over = ("cell_number", "seed")
    values = {
        "solid_force_x": ((*over, "solid", "time"), -side * force[..., None, :, 0]),
        "solid_force_y": ((*over, "solid", "time"), force[..., None, :, 1]),
        "solid_angle": (
            (*over, "snapshot", "solid"),
            np.tile(side * plates.angle[:, None, None, None], (1, seeds, 3, 1)),
        ),
        "surface_height": ((*over, "snapshot", "cell"), np.full((cells, seeds, 3, 5), surface)),
        "run_id": (over, np.full((cells, seeds), "x")),
    }
    for name, row in zip(("solid_x", "solid_y"), place, strict=True):
        values[name] = (
            (*over, "snapshot", "solid"),
            np.tile(row[:, None, :, None], (1, seeds, 1, 1)),
        )
    coords = {
        "time": 0.1 * share,
        "snapshot_time": ("snapshot", [0.0, 0.05, 0.1]),
        "solid": ["plate"],
        "solids_plate_angle": ("cell_number", side * plates.angle),
    }
    known = {"solids": {"plate": {"diameter": LENGTH}}, "material": {"thickness": THICKNESS}}
    return xr.Dataset(values, coords, {"configuration": json.dumps(known), "title": "a plate"})
