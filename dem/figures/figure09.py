"""Figure 9: discs, dumbbells and small discs; the cluster ahead of the cylinder is shaded."""

from dem.figures import BEDS, snapshots, style

TITLE = "Granules ahead of the cylinder (shaded) are pushed up and aside"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, BEDS["round"], "cluster", TITLE)
