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
NUMBERS = np.ndarray, int, float
SEAL = "sha256"


def mapped(tree, change, path=""):
    """The tree of named tuples with change(part, path) in place of each part that is none."""
    if not hasattr(tree, "_fields"):
        return change(tree, path)
    parts = zip(tree._fields, tree, strict=True)
    return tree._make(mapped(part, change, f"{path}.{name}") for name, part in parts)


def read_only(tree):
    """The tree with views of its arrays that cannot be written."""

    def viewed(part, path):
        if isinstance(part, np.ndarray):
            part = part.view()
            part.flags.writeable = False
        return part

    return mapped(tree, viewed)


def writable(tree):
    """The tree with copies of its arrays, which can be written; two that were one stay one."""
    copies = {}

    def copied(part, path):
        if isinstance(part, np.ndarray):
            key = part.ctypes.data, part.shape, part.dtype
            return copies.setdefault(key, part.copy())
        return part

    return mapped(tree, copied)


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


def written(**trees) -> dict:
    """A checkpoint: copies of the arrays and numbers that a run changes, by their path in trees."""
    arrays = {}

    def keep(part, path):
        if isinstance(part, NUMBERS) and not path.startswith(LEFT_OUT):
            arrays[path] = np.array(part)

    for name, tree in trees.items():
        mapped(tree, keep, name)
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


def replaced(tree, arrays: dict, path):
    """The tree with what a checkpoint has for it. An array of the same shape is overwritten in
    place, so that two that are one stay one."""

    def taken(part, path):
        saved = arrays.get(path)
        if saved is None:
            return part
        if not isinstance(part, np.ndarray):
            return type(part)(saved)
        if saved.shape != part.shape:
            return saved.copy()
        part[...] = saved
        return part

    return mapped(tree, taken, path)
