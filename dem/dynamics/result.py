"""A run from its start to its end, and its frames as arrays and as files."""

import math
import os
from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self, cast

import numpy as np
from pydantic import InstanceOf

from dem.base.files import atomic, check_output
from dem.base.types import Time, checked
from dem.dynamics.contact_output import ContactList
from dem.dynamics.numerics import OneOrMore
from dem.dynamics.paths import shown
from dem.dynamics.record import shares
from dem.dynamics.simulation import Simulation
from dem.scene import ARRAYS, Scene, State

if TYPE_CHECKING:
    import xarray


# of a Result as a dataset: name: (dimensions, units, long name)
RESULT = {
    "time": ("time", "s", "time since the start"),
    "position": ("time granule axis", "m", "position of the centre of the granule"),
    "angle": ("time granule", "rad", "angle of the granule, anticlockwise"),
    "velocity": ("time granule axis", "m s-1", "velocity of the granule"),
    "angular_velocity": ("time granule", "rad s-1", "angular velocity, anticlockwise"),
    "solid_force": ("time solid axis", "N", "mean force on the solid since the frame before"),
    "solid_position": (
        "time solid axis",
        "m",
        "position of the solid; not a number once it is removed",
    ),
    "solid_angle": (
        "time solid",
        "rad",
        "angle of the solid, anticlockwise; not a number once it is removed",
    ),
    "solid_torque": (
        "time solid",
        "N m",
        "mean torque on the solid since the frame before, anticlockwise",
    ),
    "solid_radius": ("solid", "m", "radius of the circle that holds the solid"),
    "solid_outline": (
        "solid point axis",
        "m",
        "closed outline of the solid about its position at angle zero",
    ),
    "wall_force": ("time wall", "N", "mean normal force on the wall since the frame before"),
    "wall_tangential_force": (
        "time wall",
        "N",
        "mean tangential force on the wall since the frame before, along its normal turned "
        "anticlockwise by a right angle",
    ),
    "wall_normal": ("wall axis", "1", "unit normal of the wall, into the solid"),
    "wall_offset": ("time wall", "m", "distance of the wall from the origin along its normal"),
    "held_force": (
        "time group axis",
        "N",
        "mean force of the contacts on the held group since the frame before",
    ),
    "period": ("axis", "m", "period of the scene; not a number where it has none"),
    "mass": ("granule", "kg", "mass of the granule"),
    "bounding_radius": ("granule", "m", "radius of the circle that holds the granule"),
    "time_step": ("", "s", "shortest time step taken"),
}


def rings(scene: Scene) -> np.ndarray:
    """Closed outlines (k, points, 2) in m of the solids about their positions, at angle zero; of
    those with fewer points the last is repeated."""
    listed = [solid.ring() for solid in scene.solids]
    points = max(map(len, listed))
    return np.stack([np.vstack([ring, *[ring[-1:]] * (points - len(ring))]) for ring in listed])


def contacts_of(
    scene: Scene, state: State, position: np.ndarray, angle: np.ndarray, planes: np.ndarray
) -> ContactList:
    """Contacts of granules in a state, where solids and walls are elsewhere than in the scene.

    position (k, 2) in m, angle (k,) in rad: of the solids, NaN of those that were removed; planes
    (w, 3): of the walls.
    """
    run = Simulation(scene.moved(position, angle, planes), state)
    contacts, unknown = run.contacts(), ["rolling_moment"] if scene.rolling else []
    present = np.flatnonzero(~np.isnan(angle))
    numbers = np.append(present, len(angle) + np.arange(len(planes)))  # also of those removed
    edge = contacts.partner < 0
    contacts.partner[edge] = -1 - numbers[-1 - contacts.partner[edge]]
    if run.engine.system.kernels.flags["FRICTION"]:
        unknown += ["tangential_force", "total_force"]
    return contacts._replace(
        **{name: np.full_like(getattr(contacts, name), np.nan) for name in unknown}
    )


class Result(NamedTuple):
    """What simulate returns: f frames of n granules, w walls, k solids and g held groups.

    The first frame is the start; frame -1 is the last one.

    Attributes
    ----------
    time : (f,) array
        Time since the start (s).
    position : (f, n, 2) array
        Centres of the granules (m).
    angle : (f, n) array
        Angles of the granules (rad).
    velocity : (f, n, 2) array
        Velocities (m/s).
    angular_velocity : (f, n) array
        Angular velocities (rad/s).
    solid_force : (f, k, 2) array
        Mean force on each solid since the frame before (N); NaN in the first frame.
    wall_force : (f, w) array
        Mean normal force on each wall since the frame before (N); NaN in the first frame.
    state : State
        The last state of the granules. Another run that starts from it begins without the tangential
        springs of contacts, and with walls, solids and their paths as at the start of the scene:
        `continuation` goes on with all of these.
    time_step : float
        Shortest time step taken (s).
    scene : Scene
        What was simulated.
    solid_position : (f, k, 2) array
        Position of each solid (m); NaN once it is removed.
    solid_angle : (f, k) array
        Angle of each solid (rad), anticlockwise; NaN once it is removed.
    solid_torque : (f, k) array
        Mean torque on each solid about its position since the frame before (N m), anticlockwise;
        NaN in the first frame.
    wall_tangential_force : (f, w) array
        Mean tangential force on each wall since the frame before (N), along (-ny, nx) where (nx,
        ny) is its normal; NaN in the first frame.
    wall_offset : (f, w) array
        Offsets of the walls (m).
    held_force : (f, g, 2) array
        Mean force of the contacts on each group of held granules since the frame before (N); NaN in
        the first frame.
    simulation : Simulation
        The simulation at its end.

    Examples
    --------
    A disc flies for a millisecond in empty space:

    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3]))
    >>> state = dem.State([[0.0, 0.0]], velocity=[[2.0, 0.0]])
    >>> result = dem.simulate(scene, state, duration=1e-3, frames=4)
    >>> result.position[:, 0, 0].round(4)
    array([0.    , 0.0005, 0.001 , 0.0015, 0.002 ])
    """

    time: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    solid_force: np.ndarray
    wall_force: np.ndarray
    state: State
    time_step: float
    scene: Scene
    solid_position: np.ndarray
    solid_angle: np.ndarray
    solid_torque: np.ndarray
    wall_tangential_force: np.ndarray
    wall_offset: np.ndarray
    held_force: np.ndarray
    simulation: Simulation

    @checked
    def continuation(self, duration: Time, frames: OneOrMore = 1) -> Self:
        """Go on from the last frame, as if there had been no end.

        Parameters
        ----------
        duration : float
            Further time to simulate (s).
        frames : int
            Number of equal intervals after each of which the state is kept (without unit).

        Returns
        -------
        Result
            The last frame and one per interval, frames + 1 in all; time goes on.

        Raises
        ------
        InputError, RunError
            As for `simulate`.

        Examples
        --------
        A disc flies for two milliseconds, then for a third:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3]))
        >>> state = dem.State([[0.0, 0.0]], velocity=[[2.0, 0.0]])
        >>> result = dem.simulate(scene, state, duration=2e-3).continuation(1e-3)
        >>> result.time.round(4), result.position[:, 0, 0].round(4)
        (array([0.002, 0.003]), array([0.004, 0.006]))
        """
        return cast(Self, result_of(deepcopy(self.simulation), duration, frames))

    def __repr__(self) -> str:
        granules, names = len(self.scene.mass), ", ".join(self._fields)
        return f"Result of {granules} granules until {self.time[-1]:g} s, {len(self.time)} frames:\n{names}"

    @property
    def walls(self) -> np.ndarray:
        """Walls of all frames, (f, w, 3): rows (nx, ny, offset), offset in m."""
        walls = np.zeros((*self.wall_offset.shape, 3))
        walls[..., :2], walls[..., 2] = self.scene.planes[:, :2], self.wall_offset
        return walls

    def contacts(self, frame: int = -1) -> ContactList:
        """Find all contacts of one frame.

        Parameters
        ----------
        frame : int
            Number of the frame (without unit); -1 is the last one.

        Returns
        -------
        ContactList
            Granule, partner, point (m), normal, branch vector (m), overlap (m) and elastic normal
            force (N) of each contact. With friction the tangential and the total forces are NaN:
            frames do not hold the tangential springs. `Simulation.contacts` has them.

        Raises
        ------
        IndexError
            If there is no such frame.

        Examples
        --------
        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]))
        >>> state = dem.State([[0, 0], [2.1e-3, 0]], velocity=[[1, 0], [-1, 0]])
        >>> result = dem.simulate(scene, state, duration=1e-4, frames=2)
        >>> [len(result.contacts(frame).force) for frame in range(3)]
        [0, 1, 0]
        """
        state = State(*(getattr(self, name)[frame] for name in ARRAYS))
        places = self.solid_position[frame], self.solid_angle[frame]
        return contacts_of(self.scene, state, *places, self.walls[frame])

    def to_dataset(self) -> "xarray.Dataset":
        """Return the frames, granules, walls and solids as a dataset.

        Returns
        -------
        xarray.Dataset
            Dimensions are time, granule, axis, wall, solid, point (of its outline) and group (of
            held granules). Every variable has units and a long name (CF). Walls and solids are
            numbered in the order of the scene. Without walls, solids or held groups there is none
            of their variables.
        """
        import xarray

        scene = self.scene
        values = self._asdict() | {
            "mass": scene.mass,
            "bounding_radius": scene.shape.bounding_radius,
            "wall_normal": scene.planes[:, :2],
            "solid_radius": np.array([solid.radius for solid in scene.solids]),
        }
        if scene.solids:
            values["solid_outline"] = rings(scene)
        if scene.periodic is not None:
            values["period"] = np.array(scene.periodic, float)  # None becomes NaN
        variables = {
            name: (dimensions.split(), values[name], {"units": units, "long_name": words})
            for name, (dimensions, units, words) in RESULT.items()
            if values.get(name) is not None
        }
        attrs = {"Conventions": "CF-1.11", "title": "Motion of granules and forces on walls"}
        axis = {"axis": ("axis", ["x", "y"], {"long_name": "direction"})}
        dataset = xarray.Dataset(variables, axis, attrs)
        # a netCDF dimension of size zero would be one without end
        return dataset.drop_dims([name for name, size in dataset.sizes.items() if not size])

    def to_netcdf(self, path: str | os.PathLike[str]) -> Path:
        """Write to_dataset() to one netCDF file, whole or not at all.

        Parameters
        ----------
        path : str or path
            File to write; it ends in .nc.

        Returns
        -------
        Path
            The file written.

        Raises
        ------
        InputError
            If the path is of another kind, or a folder; nothing is written.
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
        ...     result.to_netcdf(folder + "/collision.nc").name
        'collision.nc'
        """
        path = check_output("path", path, (".nc",))
        with atomic(path) as part:
            self.to_dataset().to_netcdf(part, engine="netcdf4", format="NETCDF4_CLASSIC")
        return path


@checked
def simulate(
    scene: InstanceOf[Scene],
    state: InstanceOf[State],
    duration: Time,
    time_step: Time | None = None,
    frames: OneOrMore = 1,
    **options: Any,
) -> Result:
    """Simulate a scene from a state and return arrays.

    Parameters
    ----------
    scene : Scene
        What is simulated: n granules, walls, solids.
    state : State
        Where the granules start, and how they move.
    duration : float
        Time to simulate (s).
    time_step : float, optional
        Time step (s); None, which is recommended, chooses it from the stiffness of the contacts.
    frames : int
        Number of equal intervals after each of which the state is kept (without unit).
    **options
        As of Simulation: step_fraction, max_overlap, skin, threads, allow_unstable.

    Returns
    -------
    Result
        The start and a frame per interval, frames + 1 in all.

    Raises
    ------
    InputError
        If a value cannot be used.
    RunError
        If the run fails: StateError or OverlapError.

    Examples
    --------
    Two discs collide in empty space and part at half their speed:

    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
    >>> state = dem.State([[0, 0], [2.1e-3, 0]], velocity=[[1, 0], [-1, 0]])
    >>> result = dem.simulate(scene, state, duration=1e-4)
    >>> result.velocity[-1, :, 0].round(1)
    array([-0.5,  0.5])
    """
    return result_of(Simulation(scene, state, time_step, **options), duration, frames)


def result_of(run: Simulation, duration: float, frames: int) -> Result:
    """Frames of a further duration (s) of a simulation."""
    run.check_duration(duration)
    interval, shortest, rows = duration / frames, math.inf, [frame_of(run, math.nan)]
    begin = run.time
    for frame in range(1, frames + 1):
        # the last one ends at the duration itself, however many there are
        shortest = min(shortest, run.engine.run([begin + duration * (frame / frames)]))
        rows.append(frame_of(run, interval))
    series = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    return Result(**series, state=run.state, time_step=shortest, scene=run.scene, simulation=run)


def frame_of(run: Simulation, interval: float) -> dict[str, Any]:
    """The simulation as it is, and the mean forces (N) since the frame before, an interval (s)
    ago."""
    world, state, scene = run.world, run.state, run.scene
    walls, solids, held = shares(scene, run.engine.take_impulses())
    place = shares(scene, shown(world.boundaries))[1]
    return {name: getattr(state, name) for name in ARRAYS} | {
        "time": run.time,
        "solid_force": (solids[:, :2] + solids[:, 2:4]) / interval,
        "solid_torque": solids[:, 4] / interval,
        "solid_position": place[:, :2],
        "solid_angle": place[:, 2],
        "wall_force": walls[:, 0] / interval,
        "wall_tangential_force": walls[:, 3] / interval,
        "wall_offset": world.boundaries.planes[:, 2],
        "held_force": held[:, :2] / interval,
    }
