"""Files of a user's own beside a sweep file: shapes, observables and kinds of experiment.

`kind: stones.Stone` is the class Stone of stones.py in the folder of the sweep file; `experiment: rest.py`
and `observables: [drag, rotation.py]` are files there. What a configuration needs of a file is read without
running it. Only `loaded` runs one, for who makes runs, or asks to draw shapes as they are.
"""

import importlib
import os
import sys
from functools import cache
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType

from dem.base import sources
from dem.base.constants import constants
from dem.base.errors import InputError

NO_BITS = "finds files of a user's own"
KEYS = "kind", "observables", "experiment"  # of configurations, that may name a file


def is_outside(word) -> bool:
    """Whether a word names something in a file of a user's own, such as stones.Stone or rest.py."""
    parts = word.split(".") if isinstance(word, str) and word.isascii() else []
    return len(parts) > 1 and all(map(str.isidentifier, parts))


def placed(data, folder: Path):
    """Values of a file; `beside`, where files of a user's own are, is its folder if it names some."""
    if not isinstance(data, dict):
        return data
    if isinstance(own := data.get("beside"), str):
        return data | {"beside": str((folder / own).resolve())}
    if data.get("beside") is None and any(map(is_outside, _words(data))):
        return data | {"beside": str(folder.resolve())}
    return data


def _words(data, key: str = ""):
    """All values of the keys that may name a file."""
    if isinstance(data, dict):
        for path, value in data.items():
            yield from _words(value, str(path).rpartition(".")[2])
    elif isinstance(data, list | tuple):
        for value in data:
            yield from _words(value, key)
    elif key in KEYS:
        yield data


@cache
def found(key: str, word: str, module: str, beside: str | None, known: tuple[str, ...]) -> str:
    """How dem.base.sources names the module that the word of a key means; its file is read and not run.

    known: names of what this package has. Raises InputError where the file cannot be used.
    """
    said = f"{key} is {word!r}; "
    if not is_outside(word):
        raise InputError(f"{said}it must be one of {', '.join(known)}, or of a file of your own.")
    if beside is None:
        raise InputError(
            f"{said}the folder of its file is not known here; name it (beside in a configuration, "
            "--shapes on the command line)."
        )
    where = f"{beside}:{module}"
    path = Path(beside, *module.split(".")).with_suffix(".py")
    if module in known:
        raise InputError(f"{said}{module} is a name of this package; give your file another name.")
    if not path.is_file():
        raise InputError(f"{said}there is no file {path}.")
    try:
        sources.code_hash(where, bits=True)
        elsewhere = sources.from_elsewhere(where)
    except sources.UNREADABLE as error:
        raise InputError(f"{said}{path} cannot be read ({' '.join(str(error).split())}).") from None
    for other, origin in elsewhere.items():
        raise InputError(
            f"{said}{path} imports {other} from {origin}, where edits are not noticed; put it beside "
            f"{path.name}, or install it."
        )
    return where


def file_found(
    key: str, word: str, beside: str | None, known: tuple[str, ...], *functions: str
) -> str:
    """The same for a file of VARIABLES and at least one of some functions, such as rest.py."""
    stem, _, suffix = word.rpartition(".")
    said = f"{key} is {word!r}; "
    if suffix != "py" or "." in stem:
        raise InputError(
            f"{said}it must be one of {', '.join(known)}, or a file of your own, such as rest.py."
        )
    where = found(key, word, stem, beside, known)
    table = said_in(where).get("VARIABLES")
    if not isinstance(table, dict) or not all(map(_is_entry, table.values())):
        raise InputError(
            f"{said}{sources.file_of(where)} must give VARIABLES as plain values, name: (dimensions, "
            "units, words)."
        )
    if not sources.defined_in(where).keys() & set(functions):
        names = " or ".join(functions)
        raise InputError(f"{said}{sources.file_of(where)} has no function {names}.")
    return where


def _is_entry(entry) -> bool:
    match entry:
        case (tuple(), str() | None, str() | None):
            return True
    return False


def said_in(where: str) -> dict:
    """The constants at the top of a module."""
    return constants(sources.file_of(where))


def reread() -> None:
    """Read files of a user's own again where they have changed; raises InputError where this package has."""
    if sources.reread():
        found.cache_clear()
        constants.cache_clear()
        for name in sources.IMPORTED.keys() & sys.modules.keys():
            if not Path(sys.modules[name].__file__).exists():  # Python would take it all the same
                del sys.modules[name]


def loaded(where: str) -> ModuleType:
    """A module, of this package or a file of a user's own, which is run; raises InputError.

    Modules of a user's own that Python has by other code, or by code that is unknown, are imported again.
    """
    folder, _, module = where.rpartition(":")
    if not folder:
        return importlib.import_module(module)
    files = sources.own_files(where)
    codes = {name: sources.code_hash(f"{folder}:{name}", bits=True) for name in files}
    changed = {
        name.partition(".")[0]: files[name]
        for name, code in codes.items()
        if sources.IMPORTED.get(name) != code
    }
    if module in sys.modules and not changed:
        return sys.modules[module]
    for name, file in changed.items():
        _check_name(name, file)
    before = {
        name: sys.modules.pop(name)
        for name in list(sys.modules)
        if name.partition(".")[0] in changed
    }
    path = sources.file_of(where)
    elsewhere = [each for each in sys.path if each != folder]
    sys.path[:] = folder, *elsewhere
    importlib.invalidate_caches()
    # no compiled files beside a sweep file: none is written, nor read, because their times are of seconds
    writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    prefix, sys.pycache_prefix = sys.pycache_prefix, os.devnull
    try:
        imported = importlib.import_module(module)
        if not sources.is_current(where):
            raise InputError("it has changed while it was used; start again.")
    except Exception as error:
        sys.modules.update(before)
        words = " ".join(f"{type(error).__name__}: {error}".split())
        said = error if isinstance(error, InputError) else f"it cannot be imported ({words})."
        raise InputError(f"{path}: {said}") from error
    finally:
        sys.dont_write_bytecode, sys.pycache_prefix = writes, prefix
        sys.path[:] = *elsewhere, folder  # last, so that it hides nothing
    sources.IMPORTED.update(codes)
    return imported


def _check_name(name: str, file: Path) -> None:
    """Raise InputError where a file has the name of a module of Python or of what is installed."""
    installed = [each for each in sys.path if sources.INSTALLED & set(Path(each).parts)]
    if name in sys.stdlib_module_names or PathFinder.find_spec(name, installed):
        raise InputError(f"{file}: {name} is installed, or of Python; give your file another name.")
