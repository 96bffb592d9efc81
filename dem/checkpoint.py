"""A run as named arrays, to go on from later with the same bits."""

import numpy as np

from dem.errors import InputError


def named_arrays(tree, path="world") -> dict:
    """All arrays of a tree of named tuples, by their path in it; copies."""
    if isinstance(tree, np.ndarray):
        return {path: tree.copy()}
    found = {}
    for name in getattr(tree, "_fields", ()):
        found |= named_arrays(getattr(tree, name), f"{path}.{name}")
    return found


def replaced(tree, arrays: dict, path="world"):
    """The tree with these arrays; raises InputError where one is missing or of another type.

    An array of the same shape is overwritten in place: a bed of discs has one for bodies and parts.
    """
    if isinstance(tree, np.ndarray):
        if path not in arrays or arrays[path].dtype != tree.dtype or arrays[path].ndim != tree.ndim:
            raise InputError(f"{path} is not in the checkpoint; is it of another scene?")
        if arrays[path].shape != tree.shape:
            return arrays[path].copy()
        tree[...] = arrays[path]
        return tree
    if not hasattr(tree, "_fields"):
        return tree
    return tree._replace(
        **{name: replaced(getattr(tree, name), arrays, f"{path}.{name}") for name in tree._fields}
    )
