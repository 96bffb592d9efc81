"""A sweep with some of its values changed, each named by its path: {"friction.granule": 0.2}."""

import json

from dem.experiment.config import Replicate, Sweep, parse


def changed(sweep: Sweep, changes: dict, shape: str, density: float, seed: int) -> Replicate:
    """One run of the changed sweep; raises InputError where that cannot be simulated."""
    data = json.loads(sweep.model_dump_json(exclude={"accuracy", "claims"}))
    data |= {"seeds": [seed], "shapes": {shape: data["shapes"][shape]}}
    data["cases"] = {"run": {"shape": shape, "density": density}}
    for path, value in changes.items():
        *groups, last = path.split(".")
        at = data
        for name in groups:
            at = at.get(name, {})
        if last in at:  # a change of another shape is none of this run
            at[last] = value
    return parse(data, f"the run of {shape}, seed {seed}").replicate(shape, density, seed)
