"""Figure 12: ellipses of three aspect ratios in layers."""

from dem.figures import snapshots, style

CASES = ("e1", "e2", "e3")
TITLE = "Layers of ellipses bend up with the cylinder and close behind it"


@style.styled
def plot(dataset):
    """Three displacements of the first seed of each case; raises InputError without the cases."""
    return snapshots.beds(dataset, CASES, "layers", TITLE)
