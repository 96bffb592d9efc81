"""refinement.nc: one row a run of the sweep, and the round that its point is of."""

from pathlib import Path

from dem.experiment.config import Replicate
from dem.io.dataset import global_attributes, write
from dem.sweep.campaign import Campaign
from studies.common.table import every_run
from studies.refinement.layout import VARIABLES


def make(campaign: Campaign, output: Path, progress=lambda share: None) -> None:
    """Write refinement.nc; raises InputError for runs that are not made yet."""
    rounds = {}  # the first with a velocity, by block
    for name in campaign.sweep.blocks:
        for number in campaign.rounds(name):
            for run in campaign.block(name, number).unique():
                rounds.setdefault((name, run.configuration.cylinder.velocity), number)

    def row(name: str, run: Replicate, values: dict) -> dict:
        own = run.configuration
        velocity = own.cylinder.velocity
        return {
            "velocity": velocity, "seed": run.seed, "round": rounds.get((name, velocity), 0),
            "drag": values["drag"][own.in_window].mean(),
        }  # fmt: skip

    found, origin = every_run(campaign, ("drag",), row, progress)
    attrs = global_attributes(campaign.sweep.title, "python -m studies refinement table", **origin)
    write(output, found, attrs, VARIABLES)
