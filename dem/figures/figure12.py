"""Figure 12: ellipses of three aspect ratios in layers."""

from dem.figures.snapshots import beds

FILE = "snapshots"
CAPTION = "Beds of ellipses in layers"
CASES = {"any": ("e1", "e2", "e3")}


def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    title = "Layers of ellipses before, half-way through and after the stroke"
    return beds(dataset, CASES["any"], "layer", title)
