"""Checkpoints: a run as named arrays, from which it continues later with the same bits.

A checkpoint holds a hash of all its arrays, so that arrays that no simulation has written are
refused.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import is_dataclass

import numpy as np

from dem.base.errors import InputError
from dem.base.types import refuse

# of a World: what the scene holds, and what part step writes before it reads
LEFT_OUT = "world.shape.", "world.lanes.motion", "world.lanes.values"
SEAL = "seal"


def named_arrays(tree, path="world") -> dict:
    """All arrays of a tree of named tuples, by their path in it; no copies."""
    if isinstance(tree, np.ndarray):
        return {path: tree}
    arrays = {}
    for name in getattr(tree, "_fields", ()):
        arrays |= named_arrays(getattr(tree, name), f"{path}.{name}")
    return arrays


def read_only(tree):
    """The tree with views of its arrays that cannot be written."""
    if isinstance(tree, np.ndarray):
        view = tree.view()
        view.flags.writeable = False
        return view
    return tree._make(map(read_only, tree)) if hasattr(tree, "_fields") else tree


def writable(tree):
    """The tree with copies of its arrays, which can be written; two that were one stay one."""
    copies = {}

    def copied(part):
        if isinstance(part, np.ndarray):
            key = part.ctypes.data, part.shape, part.dtype
            return copies.setdefault(key, part.copy())
        return part._make(map(copied, part)) if hasattr(part, "_fields") else part

    return copied(tree)


def spelled(tree):
    """Numbers and arrays of a tree of tuples and data classes, as what prints alike only if it is
    alike."""
    if isinstance(tree, np.ndarray):
        return tree.dtype.str, tree.shape, tree.tobytes()
    if isinstance(tree, tuple | list):
        return type(tree).__name__, *map(spelled, tree)
    if is_dataclass(tree):
        return type(tree).__name__, *map(spelled, vars(tree).values())
    return tree


def fingerprint(*values) -> np.ndarray:
    """SHA-256 (32,) of numbers and arrays in trees of tuples: tells scenes apart."""
    return np.frombuffer(hashlib.sha256(repr(spelled(values)).encode()).digest(), np.uint8)


def numbers_of(tree) -> list[float]:
    """All numbers of a tree of named tuples, in order."""
    nested = [numbers_of(part) if hasattr(part, "_fields") else [float(part)] for part in tree]
    return [number for part in nested for number in part]


def with_numbers(tree, numbers):
    """The tree with these numbers in place of its own."""
    left = iter(numbers)

    def filled(part):
        return part._make(map(filled, part)) if hasattr(part, "_fields") else type(part)(next(left))

    return filled(tree)


def written(world, **more) -> dict:
    """A checkpoint: copies of the arrays of a World that a run changes, by their path in it, and
    more."""
    arrays = {k: v.copy() for k, v in named_arrays(world).items() if not k.startswith(LEFT_OUT)}
    arrays |= {name: np.array(value) for name, value in more.items()}
    return arrays | {SEAL: fingerprint(*sorted(arrays.items()))}


def read(saved) -> dict:
    """The arrays of a checkpoint, also of one that numpy.load has opened; raises InputError."""
    if not isinstance(saved, Mapping):
        refuse("saved", saved, "be what Simulation.checkpoint has returned, or numpy.load of it")
    try:
        arrays = {str(name): saved[name] for name in saved}
        seal = arrays.pop(SEAL).tobytes() if SEAL in arrays else b""
        intact = seal == fingerprint(*sorted(arrays.items())).tobytes()
    except Exception as error:  # of zip, zlib or NumPy, as the file is damaged
        raise InputError(f"saved cannot be read as a checkpoint: {error}.") from None
    if not intact:
        raise InputError("saved is not as a simulation wrote it: the checkpoint is damaged.")
    return arrays


def replaced(tree, arrays: dict, path="world"):
    """The tree with the arrays of a checkpoint. One of the same shape is overwritten in place, so
    that two that are one stay one."""
    if isinstance(tree, np.ndarray):
        saved = arrays.get(path, tree)
        if saved.shape != tree.shape:
            return saved.copy()
        tree[...] = saved
        return tree
    if not hasattr(tree, "_fields"):
        return tree
    return tree._make(replaced(getattr(tree, k), arrays, f"{path}.{k}") for k in tree._fields)
