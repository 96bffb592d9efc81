"""Figure 11: ellipses of three aspect ratios; the cluster ahead of the cylinder is shaded."""

from dem.figures import BEDS, snapshots, style

TITLE = "Ellipses ahead of the cylinder (shaded) are pushed up and aside"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, BEDS["ellipses"], "cluster", TITLE)
