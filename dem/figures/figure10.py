"""Figure 10: discs, dumbbells and small discs in layers."""

from dem.figures import snapshots, style

SHAPES = ("c1", "d1", "c2")
TITLE = "Layers before, half-way through and after the stroke"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, SHAPES, "layers", TITLE)
