"""Figure 10: discs, dumbbells and small discs in layers."""

from dem.figures import snapshots, style

CASES = ("c1", "d1", "c2")
TITLE = "Layers bend up with the cylinder and close behind it"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each case; raises InputError without the cases."""
    return snapshots.beds(dataset, CASES, "layers", TITLE)
