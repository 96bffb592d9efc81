"""Figure 10: discs, dumbbells and small discs in layers."""

from dem.figures.snapshots import beds

FILE = "snapshots"
CAPTION = "Beds of discs, dumbbells and small discs in layers"
CASES = {"any": ("c1", "d1", "c2")}


def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    title = "Layers before, half-way through and after the stroke"
    return beds(dataset, CASES["any"], "layer", title)
