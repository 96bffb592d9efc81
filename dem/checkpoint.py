"""A run as named arrays, to go on from later with the same bits."""

import hashlib

import numpy as np

from dem.errors import InputError

FIXED = ("shape",)  # of a World: what the scene holds, and no run changes


def named_arrays(tree, path="world") -> dict:
    """All arrays of a tree of named tuples, by their path in it; no copies."""
    if isinstance(tree, np.ndarray):
        return {path: tree}
    found = {}
    for name in getattr(tree, "_fields", ()):
        found |= named_arrays(getattr(tree, name), f"{path}.{name}")
    return found


def moving(world) -> dict:
    """The arrays of a World that a run changes, by their path in it."""
    arrays = named_arrays(world)
    return {
        k: v for k, v in arrays.items() if not k.startswith(tuple(f"world.{f}." for f in FIXED))
    }


def fingerprint(*held) -> np.ndarray:
    """SHA-256 (32,) of numbers and arrays in trees of named tuples: tells scenes apart."""
    digest = hashlib.sha256()
    for tree in held:
        digest.update(repr(_numbers(tree)).encode())
        for name, array in named_arrays(tree).items():
            digest.update(name.encode() + np.ascontiguousarray(array).tobytes())
    return np.frombuffer(digest.digest(), np.uint8)


def _numbers(tree):
    """The tree without its arrays."""
    if isinstance(tree, np.ndarray):
        return "array"
    if hasattr(tree, "_fields"):
        return [_numbers(getattr(tree, name)) for name in tree._fields]
    return tree


def replaced(world, arrays: dict):
    """The World with these arrays; raises InputError, with nothing changed, where they do not fit.

    An array of the same shape is overwritten in place: a bed of discs has one for bodies and parts.
    """
    for path, own in moving(world).items():
        other = arrays.get(path)
        if other is None or (other.dtype, other.ndim) != (own.dtype, own.ndim):
            raise InputError(
                f"{path} is not in the checkpoint as it must be; is it of another scene?"
            )
    return _replaced(world, arrays, "world")


def _replaced(tree, arrays, path):
    if isinstance(tree, np.ndarray):
        if path not in arrays:
            return tree
        if arrays[path].shape != tree.shape:
            return arrays[path].copy()
        tree[...] = arrays[path]
        return tree
    if not hasattr(tree, "_fields"):
        return tree
    return tree._replace(
        **{name: _replaced(getattr(tree, name), arrays, f"{path}.{name}") for name in tree._fields}
    )
