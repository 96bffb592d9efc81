"""Granules that come into a bed and leave it during a run."""

from copy import deepcopy

import numpy as np

from dem.base.errors import InputError
from dem.dynamics.assembly import assemble, state_of
from dem.dynamics.contact_output import list_contacts, partner_words
from dem.dynamics.engine import Engine
from dem.dynamics.system import System
from dem.scene import ARRAYS, TOUCHING, Scene, State


def with_granules(
    scene: Scene, engine: Engine, granules: np.ndarray, new: State | None = None
) -> Engine:
    """A copy of the engine of a scene, without some granules, or with some more in a new state.

    Raises InputError where they cannot go or come.
    """
    order = engine.order
    known, wrong = np.unique(granules), np.isin(granules, order, invert=new is None)
    if known[-1] >= scene.granules:
        raise InputError(
            f"granules has {known[-1]}; the scene has {scene.granules}, numbered from 0."
        )
    if len(known) < len(granules):
        raise InputError("granules has a number twice; each granule is there once.")
    if wrong.any():
        words = "is not there" if new is None else "is there already"
        raise InputError(f"granules has {granules[wrong][0]}, which {words}; leave it out.")
    order = np.append(order, granules) if new else np.setdiff1d(order, granules, True)
    check_free(scene, order, "granules")
    engine = deepcopy(engine)  # an interrupt changes nothing
    engine.end_step()
    state = state_of(engine.world, engine.order, scene.granules)
    if new:
        frame = np.array(engine.rules.frame)
        new.position -= frame * engine.progress.seen
        new.velocity -= frame
        for name in ARRAYS:
            getattr(state, name)[granules] = getattr(new, name)
    engine.replace_granules(system_of(scene, engine, state, order), order)
    if new:
        check_room(scene, engine, granules)
    return engine


def system_of(scene: Scene, engine: Engine, state: State, order: np.ndarray) -> System:
    """The arrays of an engine for granules of a scene that are there, and its boundaries as they are
    now."""
    table, flags = engine.system.table, engine.system.kernels.flags
    moving = engine.world.boundaries
    return assemble(scene, state, order, table.fraction, flags["LEDGER"], moving=moving)


def check_room(scene: Scene, engine: Engine, granules: np.ndarray) -> None:
    """Raise InputError where granules overlap others, solids or walls."""
    contacts = list_contacts(engine.system, engine.order)
    met = np.isin(contacts.granule, granules) | np.isin(contacts.partner, granules)
    overlap = np.where(met, contacts.overlap, 0.0)
    if overlap.max(initial=0.0) > TOUCHING * scene.shape.bounding_radius.min():
        granule = contacts.granule[overlap.argmax()]
        raise InputError(
            f"granule {granule} would be {overlap.max():.3g} m inside "
            f"{partner_words(engine.world, contacts, granule)}; insert granules where there is room."
        )


def check_free(scene: Scene, present: np.ndarray, name: str) -> None:
    """Raise InputError where no granule is there that is free."""
    if scene.is_held[present].all():
        raise InputError(f"{name} must leave at least one granule there that is not held.")
