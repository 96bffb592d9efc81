"""What a result depends on: the syntax trees of the modules that make it, found from their imports.

The closure of a module is itself and all that it imports, directly or not, inside functions too.
Its hash leaves out what cannot change a result: comments, docstrings, annotations of types, line
numbers, and the sentences of raised errors. It is the same on every supported version of Python.
"""

import ast
import hashlib
import json
import os
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

from platformdirs import user_cache_path

from dem.base.files import atomic

PACKAGE = Path(__file__).parent.parent
ROOT = PACKAGE.parent

# Fields of syntax nodes that hold no code, or differ between versions of Python.
_NO_CODE = {"annotation", "returns", "type_comment", "type_params", "kind", "ctx"}


@cache
def closure(*modules: str) -> tuple[str, ...]:
    """Sorted names of the modules of this package that the given ones depend on, and their own.

    Imports are read from the source; nothing is imported. The packages that contain a module count,
    because Python runs their __init__.py first. Raises ValueError for a module that the package
    does not have, OSError and SyntaxError for one that cannot be read.
    """
    for module in modules:
        if _file(module) is None:
            raise ValueError(f"module is {module!r}; it must be one of {PACKAGE.name}")
    found, left = set(), list(modules)
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += [each for each in _read(_file(name)).imports if _file(each)]
            left += [name.rpartition(".")[0]] if "." in name else []
    return tuple(sorted(found))


@cache
def code_hash(*modules: str) -> str:
    """SHA-256 of the code of the closure of modules, as hexadecimal digits; raises as closure."""
    digest = hashlib.sha256()
    for name in closure(*modules):
        digest.update(f"{name} {_read(_file(name)).code}\n".encode())
    return digest.hexdigest()


@cache
def _file(module: str) -> Path | None:
    """Source of a module, or None if this package has no such module."""
    name, *rest = module.split(".")
    if name != PACKAGE.name:
        return None
    stem = PACKAGE.joinpath(*rest)
    choices = stem / "__init__.py", stem.with_suffix(".py")
    return next((path for path in choices if path.is_file()), None)


def is_ours(module: str) -> bool:
    """Whether a module is one of this package, so that all code that it depends on is known."""
    return _file(module) is not None


def cache_folder() -> Path:
    """Folder of the caches: $NUMBA_CACHE_DIR or the user's cache folder."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or user_cache_path("dem", appauthor=False))


class Source(NamedTuple):
    """Names that a file imports, as written, and the SHA-256 of its code.

    Some names are not modules but members of one.
    """

    imports: tuple[str, ...]
    code: str


@cache
def _read(path: Path) -> Source:
    """Source of a file, from a cache on disk, because parsing takes time.

    The key is the content of the file and of this module. A digest reveals damage.
    """
    content = path.read_bytes()
    kept = cache_folder() / "sources" / f"{_digest(content + Path(__file__).read_bytes())}.json"
    with suppress(OSError, ValueError):  # absent, or damaged
        seal, _, text = kept.read_text().partition("\n")
        if seal == _digest(text.encode()):
            imports, code = json.loads(text)
            return Source(tuple(imports), code)
    source = _parse(content, path)
    text = json.dumps(source)
    with suppress(OSError), atomic(kept) as part:  # nothing is lost where it cannot be kept
        part.write_text(f"{_digest(text.encode())}\n{text}")
    return source


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _parse(content: bytes, path: Path) -> Source:
    tree = ast.parse(content, str(path))
    return Source(_imported(tree, path), _digest(_code(tree).encode()))


def _imported(tree: ast.Module, path: Path) -> tuple[str, ...]:
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"{path}, line {node.lineno}: write imports in full, not relative")
            names += [node.module, *(f"{node.module}.{each.name}" for each in node.names)]
    return tuple(dict.fromkeys(names))


def _code(node) -> str:
    """A syntax tree as text, without fields that are not code.

    Written here and not by ast.dump, whose text differs between versions of Python.
    """
    if isinstance(node, list):
        return f"[{','.join(map(_code, node))}]"
    if not isinstance(node, ast.AST):
        return ascii(node)  # which characters repr shows differs between versions
    fields = [(name, getattr(node, name, None)) for name in node._fields if name not in _NO_CODE]
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        fields = [("exc", node.exc.func)]  # which error, not what it says
    inner = ",".join(
        f"{name}={_code(_parts(node, name, value))}"
        for name, value in fields
        if value is not None and value != []
    )
    return f"{type(node).__name__}({inner})"


def _parts(node, name: str, value):
    """A field without docstrings and without empty pieces of f-strings.

    Some versions of Python leave the latter out.
    """
    if name == "body" and isinstance(value, list):
        return [each for each in value if not (isinstance(each, ast.Expr) and _is_text(each.value))]
    if isinstance(node, ast.JoinedStr):
        return [each for each in value if not (_is_text(each) and not each.value)]
    return value


def _is_text(node) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
