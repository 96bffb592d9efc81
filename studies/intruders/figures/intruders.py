"""Drag and side force of single intruders: by their outline, and of a plate against its angle."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import window_text, within
from dem.base.statistics import mean_interval
from dem.figures import style

FILE = "solids"
CAPTION = "Drag and side force of intruders by their outline, and of a plate by its angle"
AXES = {"intruder": 2, "seed": 2}
PLATE = "plate "  # how the label of a plate begins, before its angle in degrees
WORDS = {
    "cylinder": "cylinder",
    "smooth": "cylinder without friction",
    "free": "cylinder that turns freely",
    "ellipse": "ellipse, half as long as wide",
    "square": "square",
    "tip": "wedge, tip ahead",
    "base": "wedge, base ahead",
}
# N/cm3, of Li, Zhang and Goldman (2013) for granules of any kind, as public implementations have them
B11, B_11, C11, C01, C_11 = 0.212, 0.055, -0.124, 0.253, 0.007


def resistive(degrees) -> np.ndarray:
    """Drag and side force (2, ...) by resistive force theory on a plate that moves level, relative
    to the drag at 0 degrees, across the motion.

    They are means of a plate and its mirror image, in which what gravity adds cancels: of the
    Fourier series in twice the angle the even part for the drag, the odd part for the side force.
    """
    twice = 2.0 * np.radians(degrees)
    forces = C01 - (C11 + C_11) * np.cos(twice), (B11 - B_11) * np.sin(twice)
    return np.array(forces) / (C01 - C11 - C_11)


def force(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """A force (N) of each run, mean within the window, over intruder and seed."""
    window = dataset.attrs["window_start"], dataset.attrs["window_stop"]
    mean = within(dataset[name], *window).mean("displacement")
    return mean.squeeze([dim for dim in mean.dims if mean.sizes[dim] == 1 and dim != "solid"])


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Outlines on the left, angles of a plate on the right."""
    drag, side = (
        force(dataset, f"solid_{name}").sel(solid="cylinder") for name in ("drag", "side_force")
    )
    labels = dataset["intruder"].values.tolist()
    outlines = [label for label in labels if not label.startswith(PLATE)]
    angles = {label: float(label.removeprefix(PLATE)) for label in labels if label not in outlines}
    figure, (left, right) = style.panels(2, 2, 0.6, 3.8)
    looks = (
        (drag, {"marker": "o", "color": style.CURVE, "label": "drag"}),
        (side, {"marker": "s", "color": "0.35", "markerfacecolor": "white", "label": "side force"}),
    )
    for values, look in looks:
        means = [mean_interval(values.sel(intruder=label)) for label in outlines]
        style.intervals(left, np.arange(len(outlines))[::-1], means, across=True, **look)
        if angles:
            means = [mean_interval(values.sel(intruder=label)) for label in angles]
            style.intervals(right, [*angles.values()], means, **look)
    if PLATE + "0" in angles:
        degrees = np.linspace(0.0, 90.0, 91)
        scale = float(drag.sel(intruder=PLATE + "0").mean())
        look = {"color": "0.5", "linewidth": 1.0, "zorder": 0}
        words = ["resistive force theory", "_"]  # one for both
        right.plot(degrees, scale * resistive(degrees).T, label=words, **look)
    left.set_yticks(
        range(len(outlines)), [WORDS.get(outline, outline) for outline in outlines[::-1]]
    )
    left.set(xlabel=f"Mean force from {window_text(dataset)} (N)")
    right.set(xlabel="Angle of the plate (degrees)", ylabel="Mean force (N)")
    right.set_xticks([*angles.values()])
    for axes in (left, right):
        axes.axhline(0.0, **style.REFERENCE) if axes is right else axes.axvline(
            0.0, **style.REFERENCE
        )
    left.set_title("Outlines of one width")
    right.set_title("Plate (0: across the motion)")
    style.legend(figure, right, ncols=3)
    means = drag.sel(intruder=outlines).mean("seed")
    most, least = (
        WORDS.get(str(end.item()), str(end.item()))
        for end in (means.idxmax("intruder"), means.idxmin("intruder"))
    )
    figure.suptitle(
        f"Of outlines of one width, the most drag: {most}; the least: {least}\n(bars: 95 % intervals)"
    )
    return figure
