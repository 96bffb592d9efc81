"""A scene in motion as it is at a time: what a simulation can be asked for, and what does not change
it."""

import numpy as np

from dem.base.errors import InputError
from dem.base.types import checked
from dem.dynamics.assembly import state_of
from dem.dynamics.checkpoint import fingerprint, written
from dem.dynamics.contact_output import ContactList, list_contacts
from dem.dynamics.energy import Ledger, energies
from dem.dynamics.engine import TOO_DEEP, Diagnostics, Engine, failure
from dem.dynamics.stress import Edges, Stress, stress
from dem.dynamics.world import World
from dem.scene import Scene, State


class MovingScene:
    """A scene in motion at the present time, to look at.

    Attributes
    ----------
    scene : Scene
        The scene, with the motions of solids at the start.
    engine : Engine
        Its arrays, and the calls of the kernel: for the package itself.
    """

    scene: Scene
    engine: Engine
    _at_start: tuple[float, float] | None  # what a ledger counts from

    @property
    def time(self) -> float:
        """Time since the start (s)."""
        return self.engine.progress.seen

    @property
    def steps(self) -> int:
        """Number of time steps taken, without unit."""
        return int(self.engine.progress.steps)

    @property
    def world(self) -> World:
        """The arrays of the kernels, in SI units.

        Their granules may be in another order than in the scene (dem.dynamics.assembly). Do
        not write to them, because the neighbour list and the time step rely on them;
        dem.dynamics.checkpoint.copied copies them.

        Examples
        --------
        >>> import dem
        >>> run = dem.Simulation(dem.Scene(dem.Disc([1e-3, 1e-3])), dem.State([[0, 0], [1, 0]]))
        >>> run.world.bodies.shape
        (2, 8)
        """
        return self.engine.observe()[0].world

    @property
    def state(self) -> State:
        """Copy of positions (m) and angles (rad) of granules with their rates (1/s), NaN of those that
        are not there. Another run that starts from it has its boundaries at their start;
        `checkpoint` keeps them."""
        return state_of(self.world, self.engine.order, self.scene.granules)

    def diagnose(self) -> Diagnostics:
        """Energy, contacts, largest overlap and critical time step at the present time.

        Returns
        -------
        Diagnostics
            Kinetic energy (J), coordination number, overlap and critical time step (s).

        Raises
        ------
        OverlapError
            If the largest overlap exceeds `max_overlap`.

        Examples
        --------
        Two discs of 24.5 mg approach each other at 1 m/s each:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> print(f"{1e6 * run.diagnose().kinetic_energy:.1f} uJ")
        24.5 uJ
        """
        engine, diagnostics = self.engine, self.engine.observe()[1]
        value, granule = diagnostics.max_overlap, diagnostics.deepest
        if not value <= engine.rules.max_overlap:
            raise failure(engine, TOO_DEEP, value, granule)
        return diagnostics._replace(deepest=int(engine.order[granule]))

    def contacts(self) -> ContactList:
        """All contacts at the present time.

        Returns
        -------
        ContactList
            Granules, points (m), normals, branch vectors (m), overlaps (m) and forces (N). A
            simulation starts without tangential springs.

        Examples
        --------
        Two discs of 1 mm radius overlap by 1 um; Hertz's law gives the force:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]))
        >>> run = dem.Simulation(scene, dem.State([[0.0, 0.0], [1.999e-3, 0.0]]))
        >>> contacts = run.contacts()
        >>> print(contacts.granule, contacts.partner)
        [0] [1]
        >>> modulus = 70e9 / (1.0 - 0.22**2) / 2.0
        >>> hertz = 4.0 / 3.0 * modulus * 0.5e-3**0.5 * 1e-6**1.5
        >>> print(f"{contacts.force[0]:.3f} N, {hertz:.3f} N")
        1.097 N, 1.097 N
        """
        return list_contacts(self.engine.observe()[0], self.engine.order)

    @checked
    def stress(self, x: Edges | None = None, y: Edges | None = None) -> Stress:
        """Stress and fabric of the bed at the present time, or of bins along x or y.

        Parameters
        ----------
        x : array_like of shape (b + 1,), optional
            Edges of bins along x (m), which rise. None for the whole bed.
        y : array_like of shape (b + 1,), optional
            Edges of bins along y (m); not together with x.

        Returns
        -------
        Stress
            Stress of contacts and motion (Pa), fabric and coordination number (without unit).
            Compression is positive.

        Raises
        ------
        InputError
            If edges do not rise, are given along both axes, or leave a container that is not
            closed.

        Notes
        -----
        The stress of the contacts is the sum of ``f l`` over the volume: force f on the partner,
        branch vector l of `ContactList`. The volume is the thickness times the area between walls,
        edges and periodic sides, without the solids. In bins a contact counts for the share of
        its branch vector that is in the bin. The fabric counts contacts by their points, the other
        measures granules by their centres.

        Examples
        --------
        A disc of 1 mm radius is pressed between floor and lid, 1 um on either side:

        >>> import dem
        >>> scene = dem.Scene(
        ...     dem.Disc([1e-3]),
        ...     friction=dem.Friction(),
        ...     walls=dem.box(4e-3, 1.998e-3),
        ...     gravity=(0.0, -9.81),
        ...     thickness=1e-3,
        ... )
        >>> run = dem.Simulation(scene, dem.State([[2e-3, 0.999e-3]]))
        >>> print(f"{1e-3 * run.stress().contact[1, 1]:.0f} kPa")
        776 kPa
        """
        if x is not None and y is not None:
            raise InputError("x and y are both given; give edges along one of them.")
        bins = next(((k, np.asarray(e)) for k, e in enumerate((x, y)) if e is not None), None)
        return stress(self.contacts(), self.state, self.scene, self.world, bins)

    def ledger(self) -> Ledger:
        """Energies held, gained and lost since the start.

        Returns
        -------
        Ledger
            Energies (J).

        Raises
        ------
        InputError
            Without ``ledger=True``.

        Examples
        --------
        Two discs collide head-on, and their dashpot takes three quarters of their energy:

        >>> import dem
        >>> material = dem.Material(restitution=0.5)
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), material, dem.Friction())
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state, step_fraction=0.05, ledger=True)
        >>> shortest = run.advance(2e-4)
        >>> print(f"{run.ledger().damped / run.ledger().before:.2f}")
        0.75
        """
        if self._at_start is None:
            raise InputError("ledger is False; make the Simulation with ledger=True.")
        report = self.engine.progress
        later = report.pending_kick + report.seen - report.time
        return energies(self.engine.observe()[0], *self._at_start, later)

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Save the simulation as arrays, from which `restore` continues it exactly.

        Returns
        -------
        dict of str to ndarray
            Arrays by name (SI units), as ``numpy.savez`` takes them.

        Examples
        --------
        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> saved = run.checkpoint()
        >>> shortest = run.advance(1e-4)
        >>> run.restore(saved)
        >>> run.time
        0.0
        """
        engine = self.engine
        scene, order = self._fingerprint(), engine.order
        return written(world=engine.world, progress=engine.progress, scene=scene, order=order)

    def _fingerprint(self) -> np.ndarray:
        """Hash that differs between scenes and options."""
        return fingerprint(self.scene, self.engine.rules, self._at_start is not None)
