"""Runs of the experiment without walls, which have kernels of their own."""

import numpy as np

import dem


def test_a_cylinder_leaves_through_the_top_of_a_box_without_walls():
    record = {"snapshots": 3, "observables": ["drag", "snapshots", "flow", "alignment"]}
    values = {"extends": "config/smoke.yaml", "shape": "c1", "seed": 1, "record": record}
    result = dem.run_experiment(values | {"periodic": "xy", "cylinder": {"start": 0.9}})
    assert np.isnan(result["wall_force"].values).all()
    assert result["drag"].mean() > 0.0 and result["packing_pressure"] > 0.0
    assert np.isfinite(result["non_affine"].values[1:]).all()
