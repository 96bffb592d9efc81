"""Pictures and films of one replicate: its snapshots, coloured by speed, force, layer or cluster."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.base.files import Place, atomic, check_paths
from dem.experiment.flow_measures import LAYERS
from dem.experiment.motion import Motion
from dem.figures import bed, style

COLORS = ("speed", "force", "layer", "cluster")
SIZE, DPI = (12.8, 7.2), 100  # 720p
MAP = "viridis"
SECONDS = 10.0  # of a film


class Scene:
    """A figure with the bed on the left and the drag on the right, that can show any snapshot."""

    def __init__(self, motion: Motion, color: str, forces: bool):
        if color not in COLORS:
            raise InputError(f"color is {color!r}; it must be one of {', '.join(COLORS)}.")
        self.motion, self.color, self.forces = motion, color, forces
        own = motion.replicate.configuration
        self.width, self.size = own.box_width, own.cylinder.diameter
        self.contacts = _contacts(motion) if forces or color == "force" else None
        self.figure = Figure(figsize=SIZE, dpi=DPI)
        left, right = self.figure.subplots(1, 2, width_ratios=(1.15, 1.0))
        self.bed = bed.Bed(left, motion.outlines, self.width, motion.height, self.size)
        self.map = self._scale(left)
        self._drag(right)
        self.figure.suptitle(self._title(), fontsize=15)
        self.show(0)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")  # laid out once: that takes as long as drawing

    def _title(self):
        run = self.motion.replicate
        words = {"speed": "speed", "force": "sum of normal forces", "layer": "layers",
                 "cluster": "granules ahead of the cylinder"}[self.color]  # fmt: skip
        return f"{run.label}, {run.density:g} kg/m³, seed {run.seed}: {words}"

    def _scale(self, axes):
        """Colour scale of speeds or forces, None for layers and cluster."""
        if self.color == "speed":
            velocity = self.motion.replicate.configuration.cylinder.velocity
            scale, words = Normalize(0.0, velocity), "Speed (m/s)"
        elif self.color == "force":
            largest = max(forces.max(initial=0.0) for _, forces, _ in self.contacts) or 1.0
            scale, words = LogNorm(1e-3 * largest, 2.0 * largest), "Sum of normal forces (N)"
        else:
            return None
        mapped = ScalarMappable(scale, MAP)
        self.figure.colorbar(mapped, ax=axes, label=words, shrink=0.8)
        return mapped

    def _drag(self, axes):
        """The drag along the stroke, with a mark that moves."""
        motion = self.motion
        x = style.millimetres(motion.drag_displacement)
        if motion.drag is not None:
            axes.plot(x, motion.drag, color=style.CURVE, linewidth=0.8)
            axes.set_ylim(bottom=min(0.0, motion.drag.min()))
        axes.set(xlabel="Displacement of the cylinder (mm)", ylabel="Drag (N)",
                 xlim=(0.0, style.millimetres(motion.displacement[-1])))  # fmt: skip
        self.mark = axes.axvline(0.0, color="black", linewidth=1.6)
        self.caption = axes.set_title(" ", loc="left", fontsize=13)

    def show(self, snapshot: int) -> None:
        """Draw one snapshot."""
        motion, moved = self.motion, style.millimetres(self.motion.displacement[snapshot])
        self.bed.move(
            motion.position[snapshot], motion.angle[snapshot], motion.cylinder_y[snapshot]
        )
        self.bed.paint(self._paint(snapshot))
        if self.forces:
            segments, forces, _ = self.contacts[snapshot]
            largest = max(each[1].max(initial=0.0) for each in self.contacts) or 1.0
            self.bed.push(segments, forces, largest)
        self.mark.set_xdata([moved, moved])
        self.caption.set_text(f"{float(moved):.2f} mm")

    def _paint(self, snapshot):
        motion, start = self.motion, self.motion.position[0]
        if self.color == "layer":
            return bed.layer_colors(start, motion.height, LAYERS)
        if self.color == "cluster":
            axis = 0.5 * self.width, motion.cylinder_y[0]
            return bed.cluster_colors(start, axis, self.size)
        values = _speeds(motion, snapshot) if self.color == "speed" else self.contacts[snapshot][2]
        return self.map.to_rgba(values)


def _speeds(motion: Motion, snapshot: int):
    """Mean speed (n,) in m/s since the last snapshot, or until the next for the first."""
    first = max(snapshot - 1, 0)
    moved = np.linalg.norm(motion.position[first + 1] - motion.position[first], axis=1)
    drawn = motion.displacement[first + 1] - motion.displacement[first]
    return moved / drawn * motion.replicate.configuration.cylinder.velocity


def _contacts(motion: Motion):
    """Of every snapshot: segments (m, 2, 2) in m across contacts, forces (m,) and, by granule, their
    sums (n,) in N."""
    found = []
    for snapshot, place in enumerate(motion.position):
        touching = motion.contacts(snapshot)
        start = place[touching.granule]
        between = touching.partner >= 0
        end = np.where(
            between[:, None], place[np.where(between, touching.partner, 0)], touching.point
        )
        total = np.bincount(touching.granule, touching.force, len(place))
        total += np.bincount(touching.partner[between], touching.force[between], len(place))
        found.append((np.stack([start, end], axis=1), touching.force, total))
    return found


def _rc():
    return matplotlib.rc_context(style.RC | {"font.size": 13.0})


def picture(
    motion: Motion, path: Path, displacement: float | None, color: str, forces: bool
) -> None:
    """One snapshot, the nearest to a displacement (m), as PNG, SVG or PDF by the name of the file.

    displacement: None for half the stroke. Raises InputError for one beyond the stroke, or for
    another kind of file.
    """
    kind = Path(path).suffix[1:].lower()
    if kind not in ("png", "svg", "pdf"):
        raise InputError(f"{path}: a picture is a .png, .svg or .pdf file.")
    stroke = float(motion.displacement[-1])
    displacement = 0.5 * stroke if displacement is None else displacement
    if not 0.0 <= displacement <= stroke:
        raise InputError(
            f"displacement is {displacement:g} m; it must lie between 0 and the stroke, {stroke:g} m."
        )
    with _rc(), atomic(path) as part:
        scene = Scene(motion, color, forces)
        scene.show(motion.nearest(displacement))
        scene.figure.savefig(part, format=kind)


def encoder():
    """Path of an ffmpeg, on this computer or of the package imageio-ffmpeg; None without one."""
    import shutil

    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return get_ffmpeg_exe()
    except (ImportError, RuntimeError):  # not installed, or without a program for this computer
        return None


def film(motion: Motion, path: Path, color: str, forces: bool, progress=lambda done: None) -> Path:
    """All snapshots as MP4, or as GIF where there is no encoder; returns the file written.

    Raises InputError for a replicate with fewer than two snapshots, or for another kind of file.
    """
    path, frames = Path(path), len(motion.displacement)
    if path.suffix.lower() not in (".mp4", ".gif"):
        raise InputError(f"{path}: a film is an .mp4 or .gif file.")
    if frames < 2:
        raise InputError(f"record.snapshots is {frames}; a film needs more: simulate again.")
    tool = encoder()
    if path.suffix.lower() == ".mp4" and tool is None:
        path = path.with_suffix(".gif")
        check_paths([Place("the .gif instead", path)])
    rate = max(2.0, frames / SECONDS)
    with _rc(), atomic(path) as part:
        scene = Scene(motion, color, forces)
        if path.suffix.lower() == ".mp4":
            matplotlib.rcParams["animation.ffmpeg_path"] = tool
            options = ["-pix_fmt", "yuv420p", "-f", "mp4", "-preset", "veryfast"]
            writer = FFMpegWriter(fps=rate, codec="libx264", extra_args=options)
        else:
            writer = PillowWriter(fps=min(rate, 50.0))
        target = part if path.suffix.lower() == ".mp4" else part.with_suffix(".gif")
        with writer.saving(scene.figure, str(target), DPI):
            for snapshot in range(frames):
                scene.show(snapshot)
                writer.grab_frame()
                progress((snapshot + 1) / frames)
        if target != part:
            target.replace(part)
    return path
