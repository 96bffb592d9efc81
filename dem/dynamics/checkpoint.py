"""A run as named arrays, from which it continues later with the same bits."""

import hashlib
import math
from collections.abc import Mapping

import numpy as np

from dem.base.errors import InputError
from dem.base.validate import refuse
from dem.dynamics.neighbor_list import listed_sizes
from dem.dynamics.world import CHUNK

# of a World: what the scene holds and no run changes, what follows from it and the lists, and what
# each step writes before it reads
FIXED = (
    "shape.", "inverse_mass", "inverse_inertia", "gravity", "lanes.motion", "lanes.values", "pairs.sizes",
    "walls.guide.orders", "cylinder.guide.orders", "held.guide.orders", "held.group", "held.member",
)  # fmt: skip
CYLINDER_PLACE = "world.cylinder.reference"
AT_REST = "walls.planes", "walls.motion"  # fixed where no wall moves
LISTS = "world.pairs", "world.walls.contacts", "world.cylinder.contacts"


def named_arrays(tree, path="world") -> dict:
    """All arrays of a tree of named tuples, by their path in it; no copies."""
    if isinstance(tree, np.ndarray):
        return {path: tree}
    found = {}
    for name in getattr(tree, "_fields", ()):
        found |= named_arrays(getattr(tree, name), f"{path}.{name}")
    return found


def read_only(tree):
    """The tree with views of its arrays that cannot be written."""
    if isinstance(tree, np.ndarray):
        view = tree.view()
        view.flags.writeable = False
        return view
    if not hasattr(tree, "_fields"):
        return tree
    return tree._make(map(read_only, tree))


def writable(tree):
    """The tree with copies of its arrays, which can be written; two that were one stay one."""
    copies = {}

    def copied(each):
        if isinstance(each, np.ndarray):
            key = each.ctypes.data, each.shape, each.dtype
            return copies.setdefault(key, each.copy())
        return each._make(map(copied, each)) if hasattr(each, "_fields") else each

    return copied(tree)


def moving(world) -> dict:
    """The arrays of a World that a run changes, by their path in it."""
    at_rest = world.walls is not None and world.walls.guide is None
    fixed = tuple(f"world.{name}" for name in (*FIXED, *(AT_REST if at_rest else ())))
    return {k: v for k, v in named_arrays(world).items() if not k.startswith(fixed)}


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
        numbers = [_numbers(getattr(tree, name)) for name in tree._fields]
        return type(tree).__qualname__, *numbers
    return tree


def read(saved) -> dict:
    """The arrays of a checkpoint, also of one that numpy.load has opened; raises InputError."""
    if not isinstance(saved, Mapping):
        refuse("saved", saved, "be what Simulation.checkpoint has returned, or numpy.load of it")
    try:
        arrays = {str(name): saved[name] for name in saved}
    except Exception as error:  # of zip, zlib or NumPy, as the file is damaged
        raise InputError(f"saved cannot be read as a checkpoint: {error}.") from None
    for name, array in arrays.items():
        if type(array) is not np.ndarray:
            _damaged(name)
    return arrays


def clock(saved: dict) -> tuple[float, int]:
    """Time (s) and number of steps of a checkpoint; raises InputError."""
    time, steps = saved.get("time"), saved.get("steps")
    for name, value, kind in (("time", time, np.float64), ("steps", steps, np.int64)):
        if value is None or value.shape != () or value.dtype != kind:
            _damaged(name)
        if not 0 <= value < math.inf:
            _damaged(name)
    return float(time), int(steps)


def replaced(world, arrays: dict, table):
    """The World with these arrays; raises InputError, with nothing changed, where they do not fit.

    An array of the same shape is overwritten in place: a bed of discs has one for bodies
    and constituents. table: dem.dynamics.assembly.GranuleTable.
    """
    for path, own in moving(world).items():
        other = arrays.get(path)
        if other is None or (other.dtype, other.ndim) != (own.dtype, own.ndim):
            _damaged(path)
        if other.dtype.kind == "f" and not np.isfinite(other).all():
            _damaged(path)
    for path in arrays:
        if path.startswith("world.") and path not in moving(world):
            _damaged(path)
    arrays = {path: arrays[path] for path in moving(world)}
    count = len(world.constituents)
    walls = 0 if world.walls is None else len(world.walls.planes)
    for path, partners in zip(LISTS, (count, walls, 1), strict=True):
        if f"{path}.constituent" in arrays:
            _check_list(path, arrays, count, partners)
    per = count // len(world.bodies)
    held = None if world.held is None else world.held.member
    least = count + _check_chunks(arrays, count, per, held)
    lists = (*(f"{name}." for name in LISTS), "world.chunks.")
    # of a bed in chunks there are rows to spare, and where a granule is a constituent both are one array
    forces = (
        ("world.constituent_force", "world.force") if per == 1 else ("world.constituent_force",)
    )
    for path, own in moving(world).items():
        shape = arrays[path].shape
        fits = shape == own.shape or path.startswith(lists)
        if world.chunks is not None and path in forces:
            fits = shape[1:] == own.shape[1:] and shape[0] >= least
        if not fits:
            _damaged(path)
    for boundary, path in zip((None, world.walls, world.cylinder), LISTS, strict=True):
        if f"{path}.constituent" in arrays:
            _check_constants(path, arrays, world, boundary, table)
    for axis, each in enumerate(table.period):
        if each is not None:
            _check_images(arrays, axis, each)
    return _sized(_replaced(world, arrays, "world"))


def _sized(world):
    """The World with the sizes of the pairs that it lists."""
    if world.pairs.sizes is None:
        return world
    sizes = listed_sizes(world.shape, world.frame, world.pairs)
    return world._replace(pairs=world.pairs._replace(sizes=sizes))


def _damaged(path):
    raise InputError(
        f"{path} of saved is not as it must be: the checkpoint is damaged, or of another scene."
    )


def _check_list(path, arrays, count, partners):
    """One row of each array per contact, by ascending constituent; no index out of range."""
    constituent, other = arrays[f"{path}.constituent"], arrays[f"{path}.partner"]
    for name, array in arrays.items():
        if (
            name.startswith(f"{path}.")
            and not name.endswith(".first")
            and len(array) != len(constituent)
        ):
            _damaged(name)
    if (constituent >= count).any() or (np.diff(constituent.astype(np.int64)) < 0).any():
        _damaged(f"{path}.constituent")
    if (other >= partners).any():
        _damaged(f"{path}.partner")
    if f"{path}.first" in arrays:
        rows = np.searchsorted(constituent, np.arange(count + 1))
        if not np.array_equal(arrays[f"{path}.first"], rows):
            _damaged(f"{path}.first")
    elif not np.array_equal(arrays[f"{path}.force_row"], other):
        _damaged(f"{path}.force_row")


def _check_constants(path, arrays, world, boundary, table):
    """Stiffness and damping of each contact follow from the sizes and masses of both partners.

    They are as dem.dynamics.neighbor_list.set_constants makes them. boundary: None for pairs.
    """
    contacts = world.pairs if boundary is None else boundary.contacts
    i, j = arrays[f"{path}.constituent"], arrays[f"{path}.partner"]
    radius, mass = table.radius[i], table.mass[i]
    if boundary is None:
        radius, mass = _reduced(radius, table.radius[j]), _reduced(mass, table.mass[j])
        if table.held is not None:
            for held, free in ((table.held[i], j), (table.held[j], i)):
                mass = np.where(held, table.mass[free], mass)
    elif boundary is world.cylinder:
        radius = _reduced(radius, boundary.radius)
    stiffness = contacts.modulus * np.sqrt(radius)
    for name, wanted in (
        ("stiffness", stiffness),
        ("damping", table.alpha * np.sqrt(mass * stiffness)),
    ):
        found = arrays.get(f"{path}.{name}")
        if found is not None and not np.allclose(found, wanted, 1e-9, 0.0):
            _damaged(f"{path}.{name}")


def _reduced(one, other):
    return one * other / (one + other)


def _check_chunks(arrays, count, per, held):
    """Check where the forces on partners go: as dem.dynamics.neighbor_list.share_out leads them.

    per: constituents of a granule; held: granules that are, or None. Without chunks a force goes
    straight to the partner. Returns the number of rows of forces after those of the constituents.
    """
    size = CHUNK * per
    constituent, other = arrays["world.pairs.constituent"], arrays["world.pairs.partner"]
    force_row, chunked = other, "world.chunks.target" in arrays
    leaving = other // size != constituent // size
    spare = int(leaving.sum()) if chunked else 0
    if chunked:
        force_row = np.where(leaving, count - 1 + np.cumsum(leaving), other)
        home = other[leaving] // size
        lowest = np.arange(-(-count // size))
        np.minimum.at(lowest, home, constituent[leaving] // size)
        reached = [
            arrays[f"{path}.constituent"] for path in LISTS[1:] if f"{path}.partner" in arrays
        ]
        for constituents in (*reached, *(() if held is None else (per * held,))):
            lowest[constituents // size] = -1
        wanted = {
            "target": other[leaving],
            "incoming": np.argsort(home, kind="stable"),
            "first": np.searchsorted(np.sort(home), np.arange(len(lowest) + 1)),
            "lowest": lowest,
        }
        for name, values in wanted.items():
            if not np.array_equal(arrays[f"world.chunks.{name}"], values):
                _damaged(f"world.chunks.{name}")
    if not np.array_equal(arrays["world.pairs.force_row"], force_row):
        _damaged("world.pairs.force_row")
    return spare


def _check_images(arrays, axis, period):
    """Each contact is with the image of its partner that was nearest when the lists were made."""
    place = arrays["world.reference"][:, axis]
    for path in LISTS:
        name = f"{path}.shift_{'xy'[axis]}"
        if name in arrays:
            pairs = path == LISTS[0]
            other = place[arrays[f"{path}.partner"]] if pairs else arrays[CYLINDER_PLACE][axis]
            away = other - place[arrays[f"{path}.constituent"]]
            if not np.allclose(arrays[name], -period * np.rint(away / period), 1e-12, 0.0):
                _damaged(name)


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
