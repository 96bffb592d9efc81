"""In large beds, granules near each other are near each other in memory.

The order is Morton's (1966): the bits of the two cell numbers interleaved, so that a patch
(dem.dynamics.world) is compact, and has few neighbours in others.
"""

from dataclasses import replace

import numpy as np

from dem.dynamics.world import PATCH
from dem.periodic import wrapped
from dem.scene import ARRAYS, Scene, State


def _spread(number):
    """A zero between any two bits of numbers below 2^32."""
    bit, one, two = np.arange(32, dtype=np.uint64), np.uint64(1), np.uint64(2)
    bits = number.astype(np.uint64)[:, None] >> bit & one
    return (bits << two * bit).sum(axis=1)


def order_of(scene: Scene, state: State) -> np.ndarray:
    """Granules (n,) in the order of memory: that of the user for a bed of one patch."""
    if scene.granules <= PATCH:
        return np.arange(scene.granules)
    cell = 2.0 * scene.shape.bounding_radius.mean()
    position = wrapped(state.position, scene.periodic)
    cells = np.minimum((position - position.min(axis=0)) / cell, 2.0**31)
    return np.argsort(_spread(cells[:, 0]) | _spread(cells[:, 1]) << np.uint64(1), kind="stable")


def ordered(scene: Scene, state: State, order) -> tuple[Scene, State]:
    """The same scene and state with granules in another order."""
    state = State(*(getattr(state, name)[order] for name in ARRAYS))
    places = np.argsort(order)
    held = tuple(replace(group, granules=places[group.granules]) for group in scene.held)
    return replace(
        scene, shape=scene.shape.take(order), held=held, species=scene.species[order]
    ), state
