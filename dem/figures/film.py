"""Pictures and films of one replicate or one result, coloured by speed, force, layer or cluster."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from imageio_ffmpeg import get_ffmpeg_exe
from matplotlib.animation import FFMpegWriter, FuncAnimation
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.base.files import atomic, check_output
from dem.dynamics.result import Result
from dem.experiment.snapshots import Snapshots
from dem.figures import style
from dem.figures.bed import draw, view_of
from dem.figures.frames import Frames, frames_of, sums_of_forces

FILMS, PICTURES = {".mp4": "h264", ".gif": "gif"}, (".png", ".svg", ".pdf")  # codecs of films
SIZE, DPI = (12.8, 7.2), 100  # 720p
TALL = 1.6  # height over width, or the inverse, from which the record is below the bed
SECONDS = 10.0  # of a film
RC = style.RC | {"font.size": 13.0}


def figure_of(
    frames: Frames, color: str, forces: bool, shown: Sequence[int] | None = None, size=None
) -> tuple[Figure, Callable[[int], None]]:
    """A figure of the bed, with its record beside it if it has one, and what shows a frame there.

    shown: frames whose forces set the scale, the first of which is shown; None for all. size: in
    inches; None for the size of a film, which is upright where the bed is tall.
    """
    known = "speed", "force", *frames.paints
    if color not in known:
        raise InputError(f"color is {color!r}; it must be one of {', '.join(known)}.")
    shown = range(len(frames.position)) if shown is None else shown
    contacts = {k: frames.contacts(k) for k in shown} if forces or color == "force" else {}
    pushing = (listed.force.max(initial=0.0) for listed in contacts.values())
    strongest, view = max(pushing, default=0.0) or 1.0, view_of(frames)
    aspect = np.divide(*np.ptp(view, axis=0)[::-1])
    form = "A;A;A;B" if aspect > TALL else "A;B" if aspect < 1.0 / TALL else 8 * "A" + 7 * "B"
    figure = Figure(size or (SIZE[::-1] if aspect > TALL else SIZE), DPI)
    left, *right = figure.subplot_mosaic(form if frames.record else "A").values()
    scale = {"norm": Normalize(0.0, frames.fastest), "cmap": "viridis"}
    words = "Speed (m/s)"
    if color == "force":
        scale["norm"] = LogNorm(1e-3 * strongest, 2.0 * strongest)
        words = "Sum of normal forces (N); white: none"
    if color not in frames.paints:
        figure.colorbar(ScalarMappable(**scale), ax=left, label=words, shrink=0.8)
    for axes in right:
        frames.record(axes)
    marks = [axes.axvline(0.0, color="black", linewidth=1.6) for axes in right]
    if frames.title:
        figure.suptitle(f"{frames.title}: {color}", fontsize=15)

    def show(frame: int) -> None:
        if color in frames.paints:
            look = {"facecolors": frames.paints[color]}
        elif color == "speed":
            look = scale | {"array": np.linalg.norm(frames.velocity[frame], axis=-1)}
        else:
            look = scale | {"array": sums_of_forces(contacts[frame], len(frames.rings))}
        draw(left, frames, frame, view, contacts[frame] if forces else None, strongest, **look)
        left.set_title(frames.captions[frame], loc="left", fontsize=13)
        for mark in marks:
            mark.set_xdata([frames.marks[frame]] * 2)

    show(shown[0])
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.12)  # inches
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out once: that takes as long as drawing
    return figure, show


def picture(motion: Snapshots, path: Path, at: float | None, color: str, forces: bool) -> None:
    """One snapshot, the nearest to a displacement (m) or a time of a scene (s), in a file of PICTURES.

    at: None for the middle. Raises InputError for one beyond the end.
    """
    end, unit = float(motion.marks[-1]), "s" if motion.displacement is None else "m"
    at = 0.5 * end if at is None else at
    if not 0.0 <= at <= end:
        raise InputError(f"at is {at:g} {unit}; it must lie between 0 and the end, {end:g} {unit}.")
    with style.context(RC, after_reset=True):
        figure, show = figure_of(frames_of(motion), color, forces)
        show(motion.nearest(at))
        style.write(figure, path)


def encoder() -> str:
    """Path of an ffmpeg; raises InputError on a computer without one."""
    try:
        return get_ffmpeg_exe()
    except RuntimeError:
        raise InputError("there is no encoder of films on this computer; install ffmpeg.") from None


def film(
    result: Result | Snapshots,
    path: str | os.PathLike[str],
    color: str = "speed",
    forces: bool = False,
    progress: Callable[[float], object] = lambda done: None,
    panel: str | None = "force",
    solid: int | None = None,
) -> Path:
    """Film all frames of a result, with the forces on solids or walls beside the granules.

    The film shows true outlines, to scale, on axes in mm.

    Parameters
    ----------
    result : Result
        What dem.simulate returned.
    path : str or path
        File to write; it ends in .mp4 or .gif.
    color : str
        Colour of granules: "speed" (m/s), "force", the sum of normal forces on a granule (N), or
        "layer", horizontal layers of the first frame.
    forces : bool
        Whether to draw the contact forces, as lines: the thicker, the greater the force.
    progress : callable
        It is called after each frame with the share that is done, from 0 to 1.
    panel : str, optional
        What is beside the bed against time: "force" or "torque" on the solids, None for nothing.
        Without solids it is the forces on walls, for a run of the paper the drag.
    solid : int, optional
        Number of the solid of the panel (without unit); by default all are added.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If a value cannot be used or there are fewer than two frames; nothing is written.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]))
    >>> state = dem.State([[0, 0], [2.1e-3, 0]], velocity=[[1, 0], [-1, 0]])
    >>> result = dem.simulate(scene, state, duration=1e-4, frames=2)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     dem.film(result, folder + "/collision.gif").name
    'collision.gif'
    """
    path = check_output("path", path, tuple(FILMS))
    frames = frames_of(result, panel or "force", solid)
    if (count := len(frames.position)) < 2:
        raise InputError(f"result has {count} frame; a film needs two: simulate with more frames.")
    if panel is None:
        frames = frames._replace(record=None)
    suffix = path.suffix.lower()
    with style.context(RC | {"animation.ffmpeg_path": encoder()}, after_reset=True):
        figure, show = figure_of(frames, color, forces)
        writer = FFMpegWriter(
            max(2.0, count / SECONDS), FILMS[suffix], extra_args=["-f", suffix[1:]]
        )
        with atomic(path) as part:
            FuncAnimation(figure, show, count).save(
                part, writer, progress_callback=lambda frame, _: progress((frame + 1) / count)
            )
    return path
