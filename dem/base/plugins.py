"""Python files of a user beside a sweep file: shapes, laws, observables and kinds of experiment.

`kind: stones.Stone` is the class Stone of stones.py in the folder of the sweep file;
`experiment: rest.py` and `observables: [drag, rotation.py]` are files there. They are modules like
any other, found where Python has none of their name. Only `load` imports one, for who makes runs or
draws shapes as they are; all others parse it.
"""

import importlib
import os
import sys
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType

from dem.base import source_hash
from dem.base.constants import constants, definitions
from dem.base.errors import InputError

_beside: list[str] = []  # the folder of the last of such files that was imported
_imported: dict[Path, dict[str, str]] = {}  # code of the files of users as this process runs them


def is_plugin(word) -> bool:
    """Whether a word names something in a file of a user, such as stones.Stone or rest.py."""
    parts = word.split(".") if isinstance(word, str) and word.isascii() else []
    return len(parts) == 2 and all(map(str.isidentifier, parts))


def with_folder(data: dict, folder: Path) -> dict:
    """Values of a file; `beside`, where files of a user are, is its folder if it names some."""
    if isinstance(other := data.get("beside"), str):
        return data | {"beside": str((folder / other).resolve())}
    if data.get("beside") is None and any(map(is_plugin, _words(data))):
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
    elif key in ("kind", "law", "observables", "experiment"):  # these may name a file
        yield data


def find(key: str, word: str, beside: str | None, known: tuple[str, ...]) -> Path:
    """The file that the word of a key names, which is parsed and not run.

    known: names of what this package has. Raises InputError where the file cannot be used.
    """
    start = f"{key} is {word!r}; "
    if not is_plugin(word):
        raise InputError(f"{start}it must be one of {', '.join(known)}, or of a file of your own.")
    if beside is None:
        raise InputError(
            f"{start}code that results name does not run; to let that of a folder run, name the folder "
            "(--shapes FOLDER on the command line, beside in a configuration)."
        )
    file = Path(beside, f"{word.partition('.')[0]}.py")
    if file.stem in known:
        raise InputError(
            f"{start}{file.stem} is a name of this package; give your file another name."
        )
    if not os.path.isfile(file):  # noqa: PTH113 - of a name that is too long, Path raises
        raise InputError(f"{start}there is no file {file}.")
    try:
        source_hash.planned_codes(file)
    except source_hash.UNREADABLE as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{start}{file} cannot be read ({reason}).") from None
    return file


def find_module(
    key: str, word: str, beside: str | None, known: tuple[str, ...], *functions: str
) -> Path:
    """The same for a file with VARIABLES and at least one of some functions, such as rest.py."""
    start = f"{key} is {word!r}; "
    if not word.endswith(".py"):
        raise InputError(
            f"{start}it must be one of {', '.join(known)}, or a file of your own, such as rest.py."
        )
    file = find(key, word, beside, known)
    table = constants(file).get("VARIABLES")
    if not isinstance(table, dict) or not all(map(_is_entry, table.values())):
        raise InputError(
            f"{start}{file} must give VARIABLES as plain values, name: (dimensions, units, words)."
        )
    if not definitions(file).keys() & set(functions):
        raise InputError(f"{start}{file} has no function {' or '.join(functions)}.")
    return file


def _is_entry(entry) -> bool:
    match entry:
        case (tuple(), str() | None, str() | None):
            return True
    return False


def refresh() -> None:
    """Parse files of users again from now on; raises InputError where this package has changed."""
    source_hash.refuse_edits()
    for function in (source_hash.planned_codes, source_hash.run_hash, constants, definitions):
        function.cache_clear()


def load(file: Path) -> ModuleType:
    """Import a file, of this package or of a user.

    Raises InputError where it cannot be imported, or has changed since this process imported it:
    Python would go on with its old code.
    """
    if file.is_relative_to(source_hash.PACKAGE):
        return importlib.import_module(_name(file, source_hash.ROOT))
    if note(file) != source_hash.planned_codes(file):
        raise InputError(source_hash.EDITED.format(file))
    files = {
        _name(path, file.parent): path.resolve()
        for path in source_hash.with_imports(file)
        if path.is_relative_to(file.parent)
    }
    for name, path in files.items():
        imported = _file_of(name)  # perhaps from another folder of files of users
        if imported != path and any(imported.is_relative_to(other.parent) for other in _imported):
            sys.modules.pop(name)
    _beside[:] = [str(file.parent)]
    importlib.invalidate_caches()
    prefix, sys.pycache_prefix = sys.pycache_prefix, os.devnull  # whose times are of seconds
    try:
        module = importlib.import_module(file.stem)
    except Exception as error:
        del _imported[file]
        words = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(f"{file}: it cannot be imported ({words}).") from error
    finally:
        sys.pycache_prefix = prefix
    for name, path in files.items():
        if name in sys.modules and _file_of(name) != path:
            raise InputError(
                f"{path}: Python has another module named {name}, which is installed; give the "
                "file another name."
            )
    return module


class _Last:
    """Finds files beside the last one. On Python's path, processes that it starts would have their folder."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        return None if path else PathFinder.find_spec(name, _beside)


sys.meta_path.append(_Last)


def _file_of(name: str) -> Path:
    """The file of the module that Python has by a name; the root of the disk if it has none."""
    return Path(getattr(sys.modules.get(name), "__file__", None) or "/").resolve()


def note(file: Path) -> dict[str, str]:
    """Note the code of a file that is being imported, and of what it imports; returns it."""
    return _imported.setdefault(file, source_hash.plugin_codes(file))


def _name(file: Path, folder: Path) -> str:
    """Name of a file as a module."""
    stem = file.parent if file.name == "__init__.py" else file.with_suffix("")
    return ".".join(stem.relative_to(folder).parts)
