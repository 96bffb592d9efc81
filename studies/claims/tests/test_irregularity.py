"""Whether flows of two shapes are told apart."""

import numpy as np
import xarray as xr

from studies.claims.irregularity import compared


def test_verdicts_of_known_flows():
    """Twice as irregular is found to be so, with an interval that covers it."""
    rng = np.random.default_rng(3)
    runs = np.array([[1.0], [2.0]]) * rng.normal(1.0, 0.1, (2, 40))
    dataset = xr.Dataset(
        {"mixing": (("case", "seed", "snapshot"), runs[..., None] * np.ones(4))},
        {
            "case": ["round", "long"],
            "shape": ("case", ["c1", "e3"]),
            "density": ("case", [1.0, 1.0]),
            "snapshot_displacement": ("snapshot", [0.0, 1e-3, 2e-3, 9e-3]),
        },
        {"window_start": 1e-3, "window_stop": 5e-3},
    )
    found = compared(dataset, "mixing")
    assert abs(found.ratio - 2.0) < found.half < 0.2 and found.runs == 40
    assert compared(dataset.sel(case=["round"]), "mixing") is None
