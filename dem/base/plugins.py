"""Python files of a user beside a sweep file: shapes, laws, observables and kinds of experiment.

`kind: stones.Stone` is the class Stone of stones.py in the folder of the sweep file;
`experiment: rest.py` and `observables: [drag, rotation.py]` are files there. Each is a module named by
its code, so that an edited file, or one of that name in another folder, is another module. Only
`load` imports one, for who makes runs or draws shapes as they are; all others parse it.
"""

import builtins
import importlib
import os
import sys
from functools import partial
from importlib.machinery import FileFinder, SourceFileLoader
from pathlib import Path
from types import ModuleType

from dem.base import source_hash
from dem.base.declarations import constants, definitions
from dem.base.errors import InputError

OWN = "dem_own_"  # start of the names of such modules


def is_plugin(word) -> bool:
    """Whether a word names something in a file of a user, such as stones.Stone or rest.py."""
    parts = word.split(".") if isinstance(word, str) and word.isascii() else []
    return len(parts) == 2 and all(map(str.isidentifier, parts))


def with_folder(data: dict, folder: Path) -> dict:
    """Values of a file; `beside`, where files of a user are, is its folder if it names some."""
    other = data.get("beside")
    if isinstance(other, str) or (other is None and any(map(is_plugin, _words(data)))):
        return data | {"beside": str((folder / (other or "")).resolve())}
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
            f"{start}code that results name does not run; to allow code of a folder, name it "
            "(--shapes FOLDER on the command line, beside in a configuration)."
        )
    file = Path(beside, f"{word.partition('.')[0]}.py")
    if file.stem in (*known, "dem"):
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
    """Import a file, of this package or of a user as it was planned; raises InputError where it
    cannot be imported."""
    if file.is_relative_to(source_hash.PACKAGE):
        name = file.relative_to(source_hash.ROOT).with_suffix("").parts
        return importlib.import_module(".".join(name))
    try:
        package = _package(file, source_hash.planned_codes(file))
        return importlib.import_module(f"{package.__name__}.{file.stem}")
    except Exception as error:
        words = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(f"{file}: it cannot be imported ({words}).") from error


def _package(file: Path, codes: dict[str, str]) -> ModuleType:
    """The package of a user's file. Its path is the folder of the file; its name is a hash of the
    code of the file and of its imports from there. codes: hashes that the files must have."""
    name = f"{OWN}{source_hash.code_hash(source_hash.planned_codes(file))[:16]}"
    package = sys.modules.get(name)
    if package is None or package.__path__ != [str(file.parent)]:
        for module in [*sys.modules]:
            if module.startswith(name):  # of the same code in another folder
                del sys.modules[module]
        package = sys.modules[name] = ModuleType(name)
        package.__path__, package.codes = [str(file.parent)], codes
    return package


class _Loader(SourceFileLoader):
    """Runs the modules of such packages, without bytecode, whose times have a resolution of one
    second."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        if path and name.startswith(OWN):
            return FileFinder(path[0], (_Loader, [".py"])).find_spec(name)
        return None

    def exec_module(self, module):
        package = sys.modules[module.__name__.partition(".")[0]]
        now = source_hash.codes([Path(self.path)], Path(*package.__path__))
        if now | package.codes != package.codes | now:
            raise InputError(
                f"{self.path} has changed since its run was planned; run the same again."
            )
        vars(module)["__builtins__"] = vars(builtins) | {"__import__": partial(_import, package)}
        exec(self.source_to_code(self.get_data(self.path), self.path), vars(module))


sys.meta_path.insert(0, _Loader)  # for PathFinder would run these in its own way


def _import(package, name, globals=None, locals=None, fromlist=(), level=0):
    """Python's own, but what is in the folder of a package comes first: a file in its own package, so
    that it is one module for all importers, a folder in the importer's package."""
    head = name.partition(".")[0]
    file, folder = f"{head}.py", f"{head}/"
    if level == 0 and any(path.startswith((file, folder)) for path in package.codes):
        if file in package.codes:
            package = _package(Path(*package.__path__, file), package.codes)
        globals, level = {"__package__": package.__name__}, 1
    return __import__(name, globals, locals, fromlist, level)
