"""What is drawn over time: the snapshots of a run of the paper, or the frames of a user's
result."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from pydantic import InstanceOf

from dem.base.types import checked
from dem.dynamics.contact_list import ContactList
from dem.dynamics.result import Result
from dem.experiment.snapshots import Snapshots
from dem.figures import bed, style
from dem.periodic import Periods

MARGIN = 0.05  # of the view of a result, around what it shows
CURVES = (
    (style.CURVE, "-"),
    ("#b34700", (0, (5, 1.5))),
    ("#5b4a8a", (0, (1, 1))),
    ("0.45", "-"),
    ("#6fae8a", (0, (3, 1, 1, 1))),
)
SIDES = {(-1, 0): " (left)", (1, 0): " (right)", (0, -1): " (bottom)", (0, 1): " (top)"}
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


class Frames(NamedTuple):
    """f frames of n granules, SI units.

    title:    None for none
    position, angle, rings: of granules (f, n, 2), (f, n) and outlines at angle zero
    walls:    planes (f, w, 3) as of dem.Scene
    view:     as of bed.Drawing
    solids:   outlines of k solids at angle zero; their places (f, k, 2) and angles (f, k)
    velocity, contacts: functions of a frame, called when it is drawn
    fastest:  top of the scale of speeds
    paints:   colours (n,) that stay, by what they show
    captions: of the frames
    boxed:    draw the box alone, without numbers
    record:   function that draws curves on axes beside the bed, None without any
    marks:    where on the horizontal axis of the record a frame is (f,)
    periodic: periods as of dem.Scene
    """

    title: str | None
    position: np.ndarray
    angle: np.ndarray
    rings: np.ndarray
    walls: np.ndarray
    view: np.ndarray
    solids: list[np.ndarray]
    place: np.ndarray
    turn: np.ndarray
    velocity: Callable[[int], np.ndarray]
    contacts: Callable[[int], ContactList]
    fastest: float
    paints: dict[str, np.ndarray]
    captions: list[str]
    boxed: bool
    record: Callable | None
    marks: np.ndarray
    periodic: Periods


def frames_of(source: Result | Snapshots) -> Frames:
    """Frames of a result or of a run of the paper; raises InputError for anything else."""
    return of_motion(source) if isinstance(source, Snapshots) else of_result(source)


def of_motion(motion: Snapshots, rings: np.ndarray | None = None) -> Frames:
    """Frames of a run of the paper: the bed in its box, and the drag along the stroke.

    rings: outlines in place of its own
    """
    run, values = motion.replicate, motion.replicate.configuration
    width, solids = values.box_width, [motion.solids(k) for k in range(len(motion.displacement))]
    place = np.array([[solid.position for solid in row] for row in solids])
    moved = 1e3 * motion.displacement

    def record(axes):
        if motion.drag is not None:
            x = 1e3 * motion.drag_displacement
            axes.plot(x, motion.drag, color=style.CURVE, linewidth=0.8)
            axes.set_ylim(bottom=min(0.0, motion.drag.min()))
        axes.set(
            xlabel="Displacement of the cylinder (mm)", ylabel="Drag (N)", xlim=(0.0, moved[-1])
        )

    return Frames(
        title=f"{run.label}, {run.density:g} kg/m³, seed {run.seed}",
        position=motion.position,
        angle=motion.angle,
        rings=motion.outlines if rings is None else rings,
        walls=np.array([bed.box_walls(width, each, motion.periodic) for each in motion.height]),
        view=bed.box_view(width, motion.height.max()),
        solids=[solid.ring() for solid in solids[0]],
        place=place,
        turn=np.array([[solid.angle for solid in row] for row in solids]),
        velocity=partial(mean_velocity, motion),
        contacts=motion.contacts,
        fastest=values.cylinder.velocity,
        paints={
            "layer": bed.layer_colors(motion.position[0], motion.height[0]),
            "cluster": bed.cluster_colors(
                motion.position[0], place[0, 0], values.cylinder.diameter
            ),
        },
        captions=[f"{float(each):.2f} mm" for each in moved],
        boxed=True,
        record=record,
        marks=moved,
        periodic=motion.periodic,
    )


def mean_velocity(motion: Snapshots, snapshot: int) -> np.ndarray:
    """Of granules (n, 2) in m/s, since the snapshot before, or until the next for the first."""
    first = max(snapshot - 1, 0)
    way = motion.position[first + 1] - motion.position[first]
    moved = motion.displacement[first + 1] - motion.displacement[first]
    return way / moved * motion.replicate.configuration.cylinder.velocity


@checked
def of_result(result: InstanceOf[Result]) -> Frames:
    """Frames of a result: its granules, walls and solids, and the forces on them against time."""
    scene = result.scene
    low, high = np.quantile(result.position[0, :, 1], [0.0, 1.0])
    time, unit = in_units(result.time)
    groups = forces_of(result)
    return Frames(
        title=None,
        position=result.position,
        angle=result.angle,
        rings=scene.shape.polygons(),
        walls=result.walls,
        view=_view(result),
        solids=[solid.ring() for solid in scene.solids],
        place=result.solid_position,
        turn=result.solid_angle,
        velocity=result.velocity.__getitem__,
        contacts=result.contacts,
        fastest=float(np.linalg.norm(result.velocity, axis=-1).max()) or 1.0,
        paints={"layer": bed.layer_colors(result.position[0] - [0.0, low], high - low or 1.0)},
        captions=[f"t = {each:.4g} {unit}" for each in time],
        boxed=False,
        record=(lambda axes: draw_forces(axes, result, groups[0])) if groups else None,
        marks=time,
        periodic=scene.periodic,
    )


def _view(result: Result) -> np.ndarray:
    """Corners (2, 2) in m of a view that holds all frames, and the corners of walls that are
    near."""
    reach = result.scene.shape.bounding_radius[:, None]
    ends = [result.position - reach, result.position + reach]
    for k, solid in enumerate(result.scene.solids):
        place = result.solid_position[:, k]
        ends += [place - solid.radius, place + solid.radius]
    periods = np.array(result.scene.periodic or (None, None), float)  # NaN: none
    once = [0.0 * periods, periods]  # a period is shown once
    low, high = np.where(np.isfinite(periods), once, _corners(ends))
    size = (high - low).max()
    near = np.array([low - size, high + size])
    corners = np.concatenate([bed.edges(each, near)[1] for each in result.walls])
    inside = ((corners > near[0] + 1e-6 * size) & (corners < near[1] - 1e-6 * size)).all(axis=1)
    low, high = _corners([low, high, corners[inside]])
    edge = MARGIN * (high - low).max()
    view = np.array([low - edge, high + edge])
    return np.where(np.isfinite(periods), once, view)


def _corners(places: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner of what holds some places (..., 2)."""
    every = np.concatenate([each.reshape(-1, 2) for each in places])
    return every.min(axis=0), every.max(axis=0)


def in_units(time) -> tuple[np.ndarray, str]:
    """Times (f,) from s to the unit in which the last is a number above one, and that unit."""
    size, unit = next((each for each in UNITS if time[-1] >= each[0]), UNITS[-1])
    return np.asarray(time) / size, unit


def forces_of(result: Result) -> list[tuple[str, dict[str, np.ndarray]]]:
    """Forces (f,) in N by what they are on and by name, of solids and walls that there are."""
    groups, several = [], len(result.scene.solids) > 1
    for k in range(len(result.scene.solids)):
        x, y = result.solid_force[:, k].T
        words = f"Force on solid {k} (N)" if several else "Force on the solid (N)"
        groups.append((words, {"horizontal": x, "vertical": y}))
    if result.scene.walls:
        walls = enumerate(zip(result.scene.planes, result.wall_force.T, strict=True))
        forces = {f"wall {at}{SIDES.get((x, y), '')}": force for at, ((x, y, _), force) in walls}
        groups.append(("Normal force on walls (N)", forces))
    return groups


def draw_forces(axes, result: Result, group) -> None:
    """Means over the time between frames, as steps."""
    words, curves = group
    time, unit = in_units(result.time)
    for number, (name, force) in enumerate(curves.items()):
        color, line = CURVES[number % len(CURVES)]
        axes.stairs(
            force[1:], time, baseline=None, label=name, color=color, linestyle=line, linewidth=1.6
        )
    axes.set(xlabel=f"Time ({unit})", ylabel=words, xlim=(0.0, time[-1]))
    axes.legend()
