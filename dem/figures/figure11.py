"""Figure 11: ellipses of three aspect ratios; the cluster ahead of the cylinder is shaded."""

from dem.figures import snapshots, style

SHAPES = ("e1", "e2", "e3")
TITLE = "Ellipses ahead of the cylinder (shaded) are pushed up and aside"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, SHAPES, "cluster", TITLE)
