"""Shapes in files of a user's own: `kind: stones.Stone` is the class Stone of stones.py in the folder of
the sweep file.

What a configuration needs of such a file is read without running it. Only `loaded` runs it, for who
makes runs, or asks to draw them as they are.
"""

import importlib
import math
import re
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from dem.base.constants import constants
from dem.base.errors import InputError
from dem.base.sources import (
    UNREADABLE,
    address,
    classes_of,
    code_hash,
    from_elsewhere,
    is_current,
    own_files,
)
from dem.shapes import KINDS, Kind

NO_BITS = "finds the file of a shape"
HOW = "docs/howto/shape.md"


def is_outside(kind) -> bool:
    """Whether a kind names a class of a file, such as stones.Stone."""
    return isinstance(kind, str) and bool(
        re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+", kind, re.ASCII)
    )


def placed(data, folder: Path):
    """Values of a file; `beside`, the folder of shapes, is that of the file if it names such shapes."""
    kinds = [each.get("kind") for each in _sections(data).values() if isinstance(each, dict)]
    if isinstance(data, dict) and isinstance(own := data.get("beside"), str):
        return data | {"beside": str((folder / own).resolve())}
    if any(map(is_outside, kinds)) and data.get("beside") is None:
        return data | {"beside": str(folder.resolve())}
    return data


def resolved(data, source: str):
    """Values whose shapes were looked up: those of a fixed aspect ratio have it. Raises InputError.

    What is wrong with the rest of the values is left to their schema.
    """
    shapes = _sections(data)
    for label, section in shapes.items():
        kind = section.get("kind") if isinstance(section, dict) else None
        if not isinstance(kind, str) or kind in KINDS or not re.search(r"[./\\]", kind):
            continue
        try:
            natural = found(kind, data.get("beside")).aspect_ratio
            if natural and section.get("aspect_ratio") not in (None, natural):
                raise InputError(
                    f"aspect_ratio is {section['aspect_ratio']}; a {kind} always has {natural:g}, leave "
                    "it out."
                )
        except InputError as error:
            raise InputError(f"{source}: shapes.{label}.{error}") from None
        if natural:
            shapes = shapes | {label: section | {"aspect_ratio": natural}}
    return data | {"shapes": shapes} if shapes else data


def _sections(data) -> dict:
    found = data.get("shapes") if isinstance(data, dict) else None
    return found if isinstance(found, dict) else {}


@cache
def found(kind: str, beside: str | None) -> Kind:
    """A kind as its file describes it, which is read and not run; raises InputError."""
    said = f"kind is {kind!r}; "
    if not is_outside(kind):
        raise InputError(
            f"{said}it must be one of {', '.join(KINDS)}, or file and class of your own, such as "
            "stones.Stone."
        )
    if beside is None:
        raise InputError(
            f"{said}the folder of its file is not known here; name it (beside in a configuration, "
            "--shapes on the command line)."
        )
    module, _, name = kind.rpartition(".")
    where = f"{beside}:{module}"
    path = Path(beside, *module.split(".")).with_suffix(".py")
    if not path.is_file():
        raise InputError(f"{said}there is no file {path}.")
    try:
        code_hash(where, bits=True)
        classes, natural = classes_of(where), constants(path).get("ASPECT_RATIO")
        elsewhere = from_elsewhere(where)
    except UNREADABLE as error:
        raise InputError(f"{said}{path} cannot be read ({' '.join(str(error).split())}).") from None
    if name not in classes:
        raise InputError(
            f"{said}{path} has no class {name}; it has {', '.join(classes) or 'none'}."
        )
    if "of_size" not in classes[name]:
        raise InputError(
            f"{said}its class has no of_size; give it a class method of_size(diameter, aspect_ratio), "
            f"see {HOW}."
        )
    for other, origin in elsewhere.items():
        raise InputError(
            f"{said}{path} imports {other} from {origin}, where edits are not noticed; put it beside "
            f"{path.name}, or install it."
        )
    number = isinstance(natural, int | float) and not isinstance(natural, bool)
    if natural is not None and not (number and 1.0 <= natural < math.inf):
        raise InputError(f"{said}ASPECT_RATIO of {path} is {natural!r}; it must be at least 1.")
    return Kind(where, name, None if natural is None else float(natural))


@cache
def loaded(where: str, name: str) -> type:
    """The class of a shape, whose file is run; raises InputError."""
    folder, _, module = where.rpartition(":")
    path = own_files(where)[module]
    if folder not in sys.path:
        sys.path.append(folder)  # last, so that it hides nothing
    importlib.invalidate_caches()
    writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # nothing beside a sweep file
    try:
        for own, file in own_files(where).items():
            _check_place(own.partition(".")[0], folder, file)
        made = getattr(importlib.import_module(module), name)
    except InputError:
        raise
    except Exception as error:
        words = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(f"{path}: it cannot be imported ({words}).") from error
    finally:
        sys.dont_write_bytecode = writes
    if not is_current(where):
        raise InputError(f"{path}: it has changed while it was used; start again.")
    if not hasattr(made, "lists_sizes"):  # which dem.shapes.protocol gives to each shape
        raise InputError(f"{path}: {name} is no shape; decorate it with smooth, see {HOW}.")
    return made


def _check_place(name: str, folder: str, file: Path) -> None:
    """Raise InputError where Python takes another module of this name than that in a folder."""
    there = sys.modules.get(name)
    taken = there.__file__ if there else getattr(find_spec(name), "origin", None)
    if taken is None or Path(taken).resolve().is_relative_to(Path(folder).resolve()):
        return
    at = address(name, taken) if there else None
    if at and code_hash(at, bits=True) == code_hash(f"{folder}:{name}", bits=True):
        return  # a copy of the same code
    raise InputError(f"{file}: Python takes {taken} for {name}; give your file another name.")
