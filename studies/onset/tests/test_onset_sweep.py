"""The sweep over aspect ratios and numbers of granules."""

from pathlib import Path

from dem.experiment.box import height_of_box
from dem.experiment.granule_sizes import diameters_of
from dem.sweep.config import load

STUDY = Path(__file__).parent.parent


def test_boxes_of_the_sweep_are_about_square():
    for run in load(STUDY / "sweep.yaml").block("drag").runs.values():
        configuration = run.configuration
        height = height_of_box(configuration, diameters_of(run))
        assert 0.8 < height / configuration.box_width < 1.25
