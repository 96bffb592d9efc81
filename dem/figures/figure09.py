"""Figure 9: discs, dumbbells and small discs; the cluster ahead of the cylinder is shaded."""

from dem.figures import snapshots, style

SHAPES = ("c1", "d1", "c2")
TITLE = "Granules ahead of the cylinder (shaded) are pushed up and aside"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, SHAPES, "cluster", TITLE)
