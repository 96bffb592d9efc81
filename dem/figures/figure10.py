"""Figure 10: discs, dumbbells and small discs in layers."""

from dem.figures import BEDS, snapshots, style

TITLE = "Layers before, half-way through and after the stroke"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each shape; raises InputError without any."""
    return snapshots.beds(dataset, BEDS["round"], "layers", TITLE)
