"""budget.nc: one row a run of the sweep, from the batches of all its blocks."""

from pathlib import Path

import numpy as np

from dem.experiment.kinds import drag
from dem.io.dataset import global_attributes, write
from dem.sweep.campaign import Campaign
from studies.budget.layout import VARIABLES
from studies.common.table import origin, rows, wanted_of

STOPS = 10  # ends of the mean, evenly up to that of the averaging window


def make(campaign: Campaign, output: Path, progress=lambda share: None) -> None:
    """Write budget.nc; raises InputError for runs that are not made yet."""
    sweep, found, every = campaign.sweep, [], []
    start, stop = sweep.record.window
    stops = np.linspace(start, stop, STOPS + 1)[1:]
    for done, name in enumerate(sweep.blocks):
        wanted, files = wanted_of([campaign.block(name)]), campaign.files(name)
        every += files
        for ids, values in rows(files, ("drag", "steps", "run_time", "spent", "failure"), wanted):
            for run, force, steps, time, spent, _ in zip(ids, *values.values(), strict=True):
                own = wanted[run]
                moved = drag.axes(own.configuration)["displacement"]
                found.append({
                    "part": name, "shape": own.label, "seed": own.seed, "granules": own.shape.granules,
                    "fraction": own.configuration.numerics.step_fraction, "stroke": own.configuration.cylinder.stroke,
                    "drag": [force[(moved >= start) & (moved <= end)].mean() for end in stops],
                    "time_step": own.configuration.cylinder.stroke / own.configuration.cylinder.velocity / steps if steps > 0 else np.nan,
                    "time": time, "spent": spent,
                })  # fmt: skip
        progress((done + 1) / len(sweep.blocks))
    found.sort(key=lambda row: (list(sweep.blocks).index(row["part"]), row["shape"], row["granules"], row["fraction"], row["seed"]))
    values = {f"run_{key}": np.array([row[key] for row in found]) for key in found[0]} | {"window_stop": stops}
    attrs = global_attributes(f"{sweep.title}: what a budget buys", "python -m studies budget table", **origin(every))
    write(output, values, attrs, VARIABLES)
