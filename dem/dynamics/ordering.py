"""In large beds, granules near each other are near each other in memory.

The order is Morton's (1966): the bits of the two cell numbers interleaved, so that a patch
(dem.dynamics.world) is compact, and has few neighbours in others.
"""

from dataclasses import replace

import numpy as np

from dem.dynamics.world import PATCH
from dem.periodic import wrapped
from dem.scene import Scene, State
from dem.shapes.protocol import resized


def _spread(number):
    """A zero between any two bits of numbers below 2^32."""
    number = number.astype(np.uint64)
    for shift, mask in (
        (16, 0x0000FFFF0000FFFF), (8, 0x00FF00FF00FF00FF), (4, 0x0F0F0F0F0F0F0F0F),
        (2, 0x3333333333333333), (1, 0x5555555555555555),
    ):  # fmt: skip
        number = (number | (number << np.uint64(shift))) & np.uint64(mask)
    return number


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
    shape = resized(scene.shape, lambda size: size[order])
    state = State(*(each[order] for each in vars(state).values()))
    places = np.argsort(order)
    held = tuple(replace(group, granules=places[group.granules]) for group in scene.held)
    return replace(scene, shape=shape, held=held), state
