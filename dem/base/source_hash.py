"""Hash of the source code that decides the numbers of a run.

A run is known by its values and by this code: the files of RUNS, its kind of experiment, its
observables, and files of a user. All else reads, checks, writes or shows: an edit there makes no
run again. Comments, docstrings and annotations do not count.
"""

import ast
import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

from platformdirs import user_cache_path

from dem.base.errors import InputError
from dem.base.files import write_bytes

ROOT = Path(__file__).parent.parent.parent
PACKAGE = ROOT / "dem"
# What decides how granules move, by which released numbers are known (docs/data/kernels.py).
KERNELS = (
    "contacts",
    "dynamics",
    "jit",
    "laws",
    "material.py",
    "motion.py",
    "outlines.py",
    "packing",
    "periodic.py",
    "scene.py",
    "shapes",
    "solids.py",
)
# What makes every run. base/types.py makes the arrays that the rooms compute with.
RUNS = (
    *KERNELS,
    "base/types.py",
    "experiment/bed.py",
    "experiment/bed_description.py",
    "experiment/box.py",
    "experiment/cylinder.py",
    "experiment/granule_table.py",
    "experiment/intruders.py",
    "experiment/phases.py",
    "experiment/replicate.py",
    "experiment/scene.py",
    "experiment/sinks_and_sources.py",
    "experiment/snapshots.py",
)
PLUGINS = "experiment/kinds", "experiment/observables"  # a run depends on the files that it uses
UNREADABLE = (OSError, SyntaxError, ValueError)  # errors of reading and parsing a file
# Fields of syntax trees that hold no code, or differ between versions of Python.
NO_CODE = {"annotation", "returns", "type_comment", "type_params", "kind", "ctx"}
EDITED = "{} has changed since this process read it; start Python, or the workers, again."

_first_read: dict[Path, bytes] = {}  # files of this package as this process knows them


def files_of(names: Iterable[str], folder: Path = PACKAGE) -> list[Path]:
    """The Python files with some names in a folder, and those below a folder of such a name."""
    paths = []
    for path in (folder / name for name in names):
        paths += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return paths


def codes(files: Iterable[Path], folder: Path = ROOT) -> dict[str, str]:
    """Hash of the code of each file, by its name below a folder or ROOT; raises UNREADABLE."""
    hashes = {}
    for file in files:
        start = ROOT if file.is_relative_to(PACKAGE) else folder
        hashes[file.relative_to(start).as_posix()] = code(_content(file))
    return hashes


def code_hash(codes: dict[str, str]) -> str:
    """One hash of the codes of several files."""
    return digest(*(f"{name} {code}" for name, code in sorted(codes.items())))


def digest(*texts: str) -> str:
    """SHA-256 of texts, 32 hexadecimal digits of it."""
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:32]


def run_codes(*plugins: Path) -> dict[str, str]:
    """Hash of each file that decides the numbers of a run.

    plugins: the files of its experiment, its observables and its shape.
    """
    hashes = _codes_of_all_runs()
    for plugin in plugins:
        hashes = hashes | planned_codes(plugin)
        if not plugin.is_relative_to(PACKAGE):
            hashes |= codes(files_of(PLUGINS))  # any of which it may use
    return hashes


@cache
def run_hash(*plugins: Path) -> str:
    """One hash of what `run_codes` gives."""
    return code_hash(run_codes(*plugins))


@cache
def planned_codes(file: Path) -> dict[str, str]:
    """Hash of the code of a file, and of its imports from its folder, as they were when runs
    were planned; the folder itself is in no hash. Raises UNREADABLE."""
    return codes(with_imports(file), file.parent)


def with_imports(file: Path, root: Path | None = None) -> list[Path]:
    """A file, and the files that it imports from a folder, directly or not; its own if none is
    given. Raises UNREADABLE."""
    files, queue = set(), [file]
    while queue:
        path = queue.pop()
        if path not in files and path.is_file():
            files.add(path)
            queue += _imports(path, root or file.parent)
    return sorted(files)


def _imports(file: Path, root: Path) -> Iterator[Path]:
    """Where the modules that a file imports would be in a folder."""
    for node in ast.walk(ast.parse(file.read_bytes(), str(file))):
        if isinstance(node, ast.Import | ast.ImportFrom):
            level, module = getattr(node, "level", 0), getattr(node, "module", None)
            start = file.parents[level - 1] if level else root
            for alias in node.names:
                path = start.joinpath(*f"{module or ''}.{alias.name}".split("."))
                for stem in (path, *path.parents):
                    if start in stem.parents and not stem.is_relative_to(start / PACKAGE.name):
                        package = stem / "__init__.py"
                        yield package if package.is_file() else stem.with_suffix(".py")


def refuse_edits() -> None:
    """Raise InputError where a file of this package has changed since this process read it."""
    for file, content in _first_read.items():
        now = file.read_bytes()
        if now != content and code(now) != code(content):
            raise InputError(EDITED.format(file))


@cache
def _codes_of_all_runs() -> dict[str, str]:
    """`codes` of RUNS, from a note on disk: parsing takes a third of a second."""
    files = files_of(RUNS)
    content = b"".join(map(_content, [Path(__file__), *files]))
    note = cache_folder() / "sources" / f"{hashlib.sha256(content).hexdigest()[:32]}.json"
    with suppress(OSError, ValueError):  # absent or damaged
        return json.loads(note.read_text())
    hashes = codes(files)
    with suppress(OSError):
        write_bytes(note, json.dumps(hashes).encode())
    return hashes


def cache_folder() -> Path:
    """Folder of the caches: $NUMBA_CACHE_DIR or the user's cache folder."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or user_cache_path("dem", appauthor=False))


def _content(file: Path) -> bytes:
    """A file; one of this package as it was when it was first read."""
    if not file.is_relative_to(PACKAGE):
        return file.read_bytes()
    if file not in _first_read:
        _first_read[file] = file.read_bytes()
    return _first_read[file]


@cache
def code(content: bytes) -> str:
    return digest(repr(_plain(ast.parse(content))))[:16]


def _plain(node):
    """A syntax tree as lists and texts, the same for all versions of Python."""
    if isinstance(node, list):
        return [_plain(item) for item in node if not _is_docstring(item)]
    if not isinstance(node, ast.AST):
        return ascii(node)
    if isinstance(node, ast.JoinedStr):  # Python 3.12.1 puts empty texts between its values
        node.values = [part for part in node.values if getattr(part, "value", None) != ""]
    fields = [(name, getattr(node, name, None)) for name in node._fields if name not in NO_CODE]
    return [
        type(node).__name__,
        *([name, _plain(value)] for name, value in fields if value not in (None, [])),
    ]


def _is_docstring(node) -> bool:
    text = node.value if isinstance(node, ast.Expr) else None
    return isinstance(text, ast.Constant) and isinstance(text.value, str)
