"""Figure 12: ellipses of three aspect ratios in layers."""

from dem.figures import BEDS, snapshots, style

TITLE = "Layers of ellipses before, half-way through and after the stroke"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, BEDS["ellipses"], "layers", TITLE)
