"""Pictures and films of one replicate or one result, coloured by speed, force, layer or cluster."""

import os
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
from imageio_ffmpeg import get_ffmpeg_exe
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.base.files import atomic, check_output
from dem.dynamics.result import Result
from dem.experiment.snapshots import Snapshots
from dem.figures import bed, style
from dem.figures.frames import Frames, frames_of

FILMS, PICTURES = (".mp4", ".gif"), (".png", ".svg", ".pdf")
WORDS = {
    "speed": "speed",
    "force": "sum of normal forces",
    "layer": "layers",
    "cluster": "granules ahead of the cylinder",
}
SIZE, DPI = (12.8, 7.2), 100  # 720p
SECONDS = 10.0  # of a film
RC = style.RC | {"font.size": 13.0}


class Scene:
    """A figure with the bed on the left and its record on the right, that can show any frame.

    shown: frames whose forces set the scale, None for all. beside: whether there is a record.
    """

    def __init__(
        self, frames: Frames, color: str, forces: bool, shown=None, beside=True, size=SIZE
    ):
        known = "speed", "force", *frames.paints
        if color not in known:
            raise InputError(f"color is {color!r}; it must be one of {', '.join(known)}.")
        self.frames, self.color, self.forces = frames, color, forces
        shown = range(len(frames.position)) if shown is None else shown
        felt = shown if forces or color == "force" else ()
        self.contacts = {each: _contacts(frames, each) for each in felt}
        pushing = (each.max(initial=0.0) for _, each, _ in self.contacts.values())
        self.largest = max(pushing, default=0.0) or 1.0  # force at a contact (N)
        self.figure = Figure(figsize=size, dpi=DPI)
        beside = beside and frames.record is not None
        left, *right = self.figure.subplots(
            1, 1 + beside, width_ratios=(1.15, 1.0)[: 1 + beside], squeeze=False
        )[0]
        self.bed = bed.Drawing(left, frames)
        if color not in frames.paints:
            self._scale()
        self.mark = None
        if beside:
            frames.record(right[0])
            self.mark = right[0].axvline(0.0, color="black", linewidth=1.6)
        captioned = right[0] if frames.boxed else left
        self.caption = captioned.set_title(" ", loc="left", fontsize=13)
        if frames.title:
            self.figure.suptitle(f"{frames.title}: {WORDS[color]}", fontsize=15)
        self.show(shown[0])
        self.figure.get_layout_engine().set(w_pad=0.12, h_pad=0.12)  # inches
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # laid out once: that takes as long as drawing

    def _scale(self):
        """Colour scale of speeds or forces; none for layers and cluster."""
        granules, scale = self.bed.granules, Normalize(0.0, self.frames.fastest)
        words = "Speed (m/s)"
        if self.color == "force":
            scale = LogNorm(1e-3 * self.largest, 2.0 * self.largest)
            words = "Sum of normal forces (N)" + ("" if self.frames.boxed else "; white: none")
        granules.set(norm=scale, cmap="viridis")
        self.figure.colorbar(granules, ax=granules.axes, label=words, shrink=0.8)

    def show(self, frame: int) -> None:
        """Draw one frame."""
        frames = self.frames
        self.bed.move(frame)
        if self.color in frames.paints:
            self.bed.paint(frames.paints[self.color])
        else:
            speed = np.linalg.norm(frames.velocity(frame), axis=-1)
            self.bed.shade(speed if self.color == "speed" else self.contacts[frame][2])
        if self.forces:
            segments, forces, _ = self.contacts[frame]
            self.bed.push(segments, forces, self.largest)
        if self.mark is not None:
            self.mark.set_xdata([frames.marks[frame]] * 2)
        self.caption.set_text(frames.captions[frame])


def _contacts(frames: Frames, frame: int):
    """Segments (m, 2, 2) in m across contacts, forces (m,) and, by granule, their sums (n,) in
    N."""
    touching, count = frames.contacts(frame), len(frames.position[frame])
    start, between = frames.position[frame][touching.granule], touching.partner >= 0
    total = np.bincount(touching.granule, touching.force, count)
    total += np.bincount(touching.partner[between], touching.force[between], count)
    return np.stack([start, start + touching.branch], axis=1), touching.force, total


def picture(
    motion: Snapshots, path: Path, displacement: float | None, color: str, forces: bool
) -> None:
    """One snapshot, the nearest to a displacement (m), in a file of PICTURES.

    displacement: None for half the stroke. Raises InputError for one beyond the stroke.
    """
    stroke = float(motion.displacement[-1])
    displacement = 0.5 * stroke if displacement is None else displacement
    if not 0.0 <= displacement <= stroke:
        raise InputError(
            f"displacement is {displacement:g} m; it must lie between 0 and the stroke, {stroke:g} m."
        )
    with matplotlib.rc_context(RC):
        scene = Scene(frames_of(motion), color, forces)
        scene.show(motion.nearest(displacement))
        with atomic(path) as part:
            scene.figure.savefig(part, format=path.suffix[1:].lower())


def encoder() -> str:
    """Path of an ffmpeg; raises InputError on a computer without one."""
    try:
        return get_ffmpeg_exe()
    except RuntimeError:
        raise InputError(
            "there is no encoder for MP4 on this computer; install ffmpeg, or name a .gif file."
        ) from None


def film(
    result: Result | Snapshots,
    path: str | os.PathLike[str],
    color: str = "speed",
    forces: bool = False,
    progress: Callable[[float], object] = lambda done: None,
) -> Path:
    """Film all frames of a result, with the forces on cylinder or walls beside the granules.

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
    path, frames = check_output("path", path, tuple(FILMS)), frames_of(result)
    count, encoded = len(frames.position), path.suffix.lower() == ".mp4"
    if count < 2:
        raise InputError(f"result has {count} frame; a film needs two: simulate with more frames.")
    rate = max(2.0, count / SECONDS)
    with matplotlib.rc_context(RC):
        scene = Scene(frames, color, forces)
        if encoded:
            matplotlib.rcParams["animation.ffmpeg_path"] = encoder()
            options = ["-pix_fmt", "yuv420p", "-f", "mp4", "-preset", "veryfast"]
            writer = FFMpegWriter(fps=rate, codec="libx264", extra_args=options)
        else:
            writer = PillowWriter(fps=min(rate, 50.0))
        with atomic(path) as part:
            target = part if encoded else part.with_suffix(".gif")
            with writer.saving(scene.figure, str(target), DPI):
                for frame in range(count):
                    scene.show(frame)
                    writer.grab_frame()
                    progress((frame + 1) / count)
            if target != part:
                target.replace(part)
    return path
