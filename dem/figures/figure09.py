"""Figure 9: discs, dumbbells and small discs; the cluster ahead of the cylinder is shaded."""

from dem.figures.snapshots import beds

FILE = "snapshots"
CAPTION = "Beds of discs, dumbbells and small discs, the granules ahead of the cylinder shaded"
CASES = {"any": ("c1", "d1", "c2")}


def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    title = "Granules ahead of the cylinder (shaded) are pushed up and aside"
    return beds(dataset, CASES["any"], "cluster", title)
