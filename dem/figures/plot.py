"""Figures of a result of dem.simulate: `dem.plot.bed` and `dem.plot.forces`."""

from typing import Annotated

import numpy as np
from matplotlib.figure import Figure
from pydantic import Field, InstanceOf

from dem.base.errors import InputError
from dem.base.refusals import parsed
from dem.base.types import Count, checked
from dem.dynamics.result import Result
from dem.figures import style
from dem.figures.bed import view_of
from dem.figures.film import figure_of
from dem.figures.frames import draw_forces, forces_of, of_result

__all__ = ["bed", "forces"]
LONGEST = 6.0  # inches, of the longer side of a bed
AROUND = 1.8, 1.0  # inches, for numbers, words and colour bar


@checked
@style.styled
def bed(
    result: InstanceOf[Result], frame: Count = -1, color: str = "force", forces: bool = False
) -> Figure:
    """Draw granules, walls and cylinder of one frame, to scale, on axes in mm.

    All frames of a result have the same view. What is solid is hatched.

    Parameters
    ----------
    result : Result
        What dem.simulate returned.
    frame : int
        Number of the frame (without unit); 0 is the start, -1 the last one.
    color : str
        Colour of granules: "force", the sum of normal forces on a granule (N), on a scale of this
        frame; "speed" (m/s), on a scale of all frames; or "layer", horizontal layers of the first
        frame.
    forces : bool
        Whether to draw the contact forces, as lines: the thicker, the greater the force.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; its method savefig writes it.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]))
    >>> state = dem.State([[0, 0], [2.1e-3, 0]], velocity=[[1, 0], [-1, 0]])
    >>> result = dem.simulate(scene, state, duration=1e-4, frames=2)
    >>> dem.plot.bed(result, frame=1, color="speed").axes[0].get_title(loc="left")
    't = 50 µs'
    """
    frames = of_result(result)
    count = len(frames.position)
    frame = parsed(Annotated[Count, Field(ge=-count, lt=count)], frame, "frame") % count
    size = np.ptp(view_of(frames), axis=0)
    size = tuple(size * LONGEST / size.max() + AROUND)
    return figure_of(frames._replace(record=None), color, forces, [frame], size)[0]


@checked
@style.styled
def forces(result: InstanceOf[Result]) -> Figure:
    """Draw the forces on cylinder and walls against time.

    Each step is the mean over the time between two frames.

    Parameters
    ----------
    result : Result
        What dem.simulate returned, of a scene with solids or walls.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; its method savefig writes it.

    Raises
    ------
    InputError
        If the scene has neither.

    Examples
    --------
    >>> import dem
    >>> scene = dem.Scene(
    ...     dem.Disc([1e-3]), friction=dem.Friction(), walls=[[0, -1, 0]], gravity=(0, -9.81)
    ... )
    >>> state = dem.State([[0, 1.01e-3]], velocity=[[0, -1]])
    >>> result = dem.simulate(scene, state, duration=1e-4, frames=10)
    >>> dem.plot.forces(result).axes[0].get_ylabel()
    'Normal force on walls (N)'
    """
    groups = forces_of(result)
    if not groups:
        raise InputError("result has no forces: its scene has neither solids nor walls.")
    figure, rows = style.panels(len(groups), 1, 1.0, 3.0, sharex=True)
    for axes, group in zip(rows, groups, strict=True):
        draw_forces(axes, result, *group)
        axes.label_outer()
    return figure
