"""Checkpoints: a run as named arrays, from which it continues later with the same bits."""

import hashlib
from dataclasses import is_dataclass

import numpy as np

# of a World: what the scene holds
LEFT_OUT = "world.shape.", "world.outlines."


def mapped(tree, change, path=""):
    """The tree of named tuples with change(part, path) in place of each part that is none."""
    if not hasattr(tree, "_fields"):
        return change(tree, path)
    parts = zip(tree._fields, tree, strict=True)
    return tree._make(mapped(part, change, f"{path}.{name}") for name, part in parts)


def copied(tree):
    """The tree with copies of its arrays; two that were one stay one."""
    copies = {}

    def copied(part, path):
        if isinstance(part, np.ndarray):
            key = part.ctypes.data, part.shape, part.dtype
            return copies.setdefault(key, part.copy())
        return part

    return mapped(tree, copied)


def spelled(tree):
    """Nested tuple whose repr identifies the numbers and arrays of a tree of tuples and data
    classes."""
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
        if isinstance(part, np.ndarray | int | float) and not path.startswith(LEFT_OUT):
            arrays[path] = np.array(part)

    for name, tree in trees.items():
        mapped(tree, keep, name)
    return arrays


def replaced(tree, arrays, path):
    """The tree with copies of what a checkpoint has for it."""

    def taken(part, path):
        saved = arrays.get(path)
        if saved is None:
            return part
        return np.array(saved) if isinstance(part, np.ndarray) else type(part)(saved)

    return mapped(tree, taken, path)


def restored(system, saved):
    """The arrays of a checkpoint; one array for granules and constituents where they are alone."""
    world = replaced(system.world, saved, "world")
    if not system.alone:
        return world
    granules = world.granules._replace(
        motion=world.constituents.motion, force=world.constituents.force
    )
    return world._replace(granules=granules)
