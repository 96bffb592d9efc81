"""What is drawn over time: the snapshots of a run of the paper, or the frames of a user's
result."""

from collections.abc import Callable
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from matplotlib.ticker import EngFormatter
from pydantic import Field, InstanceOf

from dem.base.refusals import parsed
from dem.base.types import Count, checked
from dem.dynamics.contact_output import ContactList
from dem.dynamics.result import Result
from dem.experiment.observables.flow import layers_of
from dem.experiment.snapshots import Snapshots
from dem.figures import style
from dem.figures.bed import joined
from dem.periodic import Periods, walled
from dem.solids import Solid, box

AHEAD = 1.5  # diameters of the cylinder: height of the cluster that is shaded
SIDES = {(-1, 0): " (left)", (1, 0): " (right)", (0, -1): " (bottom)", (0, 1): " (top)"}
SECONDS = style.styled(EngFormatter)("s")
# Unit and names of what is on solids
PANELS = {"force": ("N", ("horizontal", "vertical")), "torque": ("N m", ("anticlockwise",))}


class Frames(NamedTuple):
    """f frames of n granules and k solids, SI units.

    title:    None for none
    position, angle, velocity, rings: of granules (f, n, 2), (f, n), (f, n, 2) and outlines
              (n, points, 2) at angle zero
    walls:    planes (f, w, 3) as of dem.Scene
    solids:   k of them; their places (f, k, 2) and angles (f, k)
    contacts: function of a frame, called when it is drawn
    fastest:  top of the scale of speeds
    paints:   colours (n,) that stay, by what they show
    captions: of the frames
    record:   function that draws curves on axes beside the bed, None without any
    marks:    where on the horizontal axis of the record a frame is (f,)
    periodic: periods as of dem.Scene
    """

    title: str | None
    position: np.ndarray
    angle: np.ndarray
    velocity: np.ndarray
    rings: np.ndarray
    walls: np.ndarray
    solids: tuple[Solid, ...]
    place: np.ndarray
    turn: np.ndarray
    contacts: Callable[[int], ContactList]
    fastest: float
    paints: dict[str, np.ndarray]
    captions: list[str]
    record: Callable | None
    marks: np.ndarray
    periodic: Periods


def frames_of(source: Result | Snapshots, *panel) -> Frames:
    """Frames of a result, see of_result, or of a run of the paper; raises InputError for anything
    else."""
    return of_motion(source) if isinstance(source, Snapshots) else of_result(source, *panel)


def of_motion(motion: Snapshots, rings: np.ndarray | None = None) -> Frames:
    """Frames of a run of a sweep: the bed in its box, and the forces on its solids.

    rings: outlines in place of its own
    """
    run, values = motion.replicate, motion.replicate.configuration
    there = np.isfinite(motion.turn).any(axis=0)  # solids that were not removed before
    stand, drawn = walled(motion.periodic), motion.displacement
    start = first_places(motion.position)
    velocity, marks = mean_velocity(motion.position, motion.time, motion.age), motion.marks
    paints = {"layer": layer_colours(start, motion.height[0])}
    if drawn is not None:
        diameter, (aside, above) = values.cylinder.diameter, (start - motion.place[0, 0]).T
        ahead = (
            (above > 0.0) & (above < (0.5 + AHEAD) * diameter) & (np.abs(aside) < 0.5 * diameter)
        )
        paints["cluster"], marks = np.where(ahead, *style.LAYERS[1::-1]), 1e3 * marks

    def record(axes):
        bins = motion.force.shape[1]
        x = (np.arange(bins) + 0.5) / bins * marks[-1]
        for k, force in enumerate(motion.force):
            if not there[k]:
                continue
            look = {"color": style.CURVE}
            if drawn is None:
                look = {"color": style.CASES[k % len(style.CASES)]}
                look["linestyle"] = style.LINES[k % len(style.LINES)]
            axes.plot(x, force, label=values.solid_names[k], linewidth=0.8, **look)
        axes.set_ylim(bottom=min(0.0, motion.force.min()))
        words = "Displacement of the cylinder (mm)", "Drag (N)"
        if drawn is None:
            words = "Time", "Force on the solid (N)"
            axes.xaxis.set_major_formatter(SECONDS)
            axes.locator_params("x", nbins=4)  # as many words as have room
            axes.legend()
        axes.set(xlabel=words[0], ylabel=words[1], xlim=(0.0, marks[-1]))

    known = "case=", "shape=", "density=", "seed="  # which the title says anyway
    point = [word for word in run.point if not word.startswith(known)]
    return Frames(
        title=", ".join([run.label, f"{run.density:g} kg/m³", f"seed {run.seed}", *point]),
        position=motion.position,
        angle=motion.angle,
        velocity=velocity,
        rings=joined(motion.outlines if rings is None else rings),
        walls=np.array([box(values.box_width, height)[stand] for height in motion.height]),
        solids=motion.drawn,
        place=motion.place,
        turn=motion.turn,
        contacts=motion.contacts,
        fastest=np.nanmax(np.hypot(*velocity.T)) or 1.0
        if drawn is None
        else values.cylinder.velocity,
        paints=paints,
        captions=[SECONDS(mark) if drawn is None else f"{mark:.2f} mm" for mark in marks],
        record=record if motion.force is not None and there.any() else None,
        marks=marks,
        periodic=motion.periodic,
    )


def mean_velocity(
    position: np.ndarray, time: np.ndarray, age: np.ndarray | None = None
) -> np.ndarray:
    """Of bodies (s, n, 2) in m/s, since the snapshot before; until the next for the first, and for one
    that came since then from a source. age (s, m): time (s) since the first m of them came."""
    velocity, took = np.full_like(position, np.nan), np.diff(time)[:, None]
    velocity[1:] = np.diff(position, axis=0) / took[..., None]
    if age is not None:
        velocity[1:, : age.shape[1]][age[1:] < took] = np.nan
    velocity[:-1] = np.where(np.isnan(velocity[:-1]), velocity[1:], velocity[:-1])
    return velocity


def first_places(position: np.ndarray) -> np.ndarray:
    """Where each granule of positions (f, n, 2) is first there (n, 2) in m, NaN if never."""
    first = np.isfinite(position[..., 0]).argmax(axis=0)
    return position[first, np.arange(len(first))]


def sums_of_forces(contacts: ContactList, granules: int, solids: int = 0) -> np.ndarray:
    """Sums (n + k,) in N of the normal forces on granules, then on solids."""
    partner = np.where(contacts.partner < 0, granules - 1 - contacts.partner, contacts.partner)
    bodies = np.append(contacts.granule, partner)
    count = granules + solids
    return np.bincount(bodies, np.tile(contacts.force, 2), count)[:count]


def layer_colours(start, height: float) -> np.ndarray:
    """Colours (n,) of horizontal layers in turn, by where granules begin."""
    return np.array(style.LAYERS)[layers_of(np.nan_to_num(start), height) % len(style.LAYERS)]


@checked
def of_result(
    result: InstanceOf[Result], panel: Literal["force", "torque"] = "force", solid: Any = None
) -> Frames:
    """Frames of a result: its granules, walls and solids, and what is on these against time.

    solid: number of one, None for the sum over all
    """
    scene, start, groups = result.scene, first_places(result.position), forces_of(result)
    low = np.nanmin(start[:, 1])
    height = np.nanmax(start[:, 1]) - low or 1.0
    solids = [*range(len(scene.solids))]
    if solid is not None:
        solids = [parsed(Annotated[Count, Field(ge=0, lt=len(solids))], solid, "solid")]
    if solids:
        groups = [curves_of(result, panel, solids)]
    return Frames(
        title=None,
        position=result.position,
        angle=result.angle,
        velocity=result.velocity,
        rings=joined(scene.shape.polygons()),
        walls=result.walls,
        solids=scene.solids,
        place=result.solid_position,
        turn=result.solid_angle,
        contacts=result.contacts,
        fastest=float(np.nanmax(np.linalg.norm(result.velocity, axis=-1))) or 1.0,
        paints={"layer": layer_colours(start - [0.0, low], height)},
        captions=[f"t = {SECONDS(time)}" for time in result.time],
        record=(lambda axes: draw_forces(axes, result, *groups[0])) if groups else None,
        marks=result.time,
        periodic=scene.periodic,
    )


def forces_of(result: Result) -> list[tuple[str, dict[str, np.ndarray]]]:
    """Forces (f,) in N by what they are on and by name, of solids and walls that there are."""
    groups = [curves_of(result, "force", [k]) for k in range(len(result.scene.solids))]
    if result.scene.walls:
        walls = enumerate(zip(result.scene.planes, result.wall_force.T, strict=True))
        forces = {f"wall {at}{SIDES.get((x, y), '')}": force for at, ((x, y, _), force) in walls}
        groups.append(("Normal force on walls (N)", forces))
    return groups


def curves_of(result: Result, panel: str, solids: list[int]) -> tuple[str, dict[str, np.ndarray]]:
    """What is on some solids, summed: in words, and (f,) by name; panel: of PANELS."""
    on = f"solid {solids[0]}" if len(solids) == 1 else f"{len(solids)} solids, summed"
    unit, names = PANELS[panel]
    values = getattr(result, f"solid_{panel}")[:, solids].sum(axis=1)
    curves = dict(zip(names, np.atleast_2d(values.T), strict=True))
    return f"{panel.capitalize()} on {on} ({unit})", curves


def draw_forces(axes, result: Result, words: str, curves: dict[str, np.ndarray]) -> None:
    """Means over the time between frames, as steps."""
    for number, (name, force) in enumerate(curves.items()):
        axes.stairs(
            force[1:],
            result.time,
            baseline=None,
            label=name,
            color=style.CASES[number % len(style.CASES)],
            linestyle=style.LINES[number % len(style.LINES)],
            linewidth=1.6,
        )
    axes.xaxis.set_major_formatter(SECONDS)
    axes.locator_params("x", nbins=4)  # as many words as have room
    axes.set(xlabel="Time", ylabel=words, xlim=(0.0, result.time[-1]))
    axes.legend()
