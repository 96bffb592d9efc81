"""Figure 11: ellipses of three aspect ratios; the cluster ahead of the cylinder is shaded."""

from dem.figures.snapshots import beds

FILE = "snapshots"
CAPTION = "Beds of ellipses, the granules ahead of the cylinder shaded"
CASES = {"any": ("e1", "e2", "e3")}


def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    title = "Ellipses ahead of the cylinder (shaded) are pushed up and aside"
    return beds(dataset, CASES["any"], "cluster", title)
