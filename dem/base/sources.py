"""What a result depends on: the syntax trees of the modules that make it, found from their imports.

The closure of a module is itself and all that it imports, directly or not, inside functions too.
Its hash leaves out what cannot change a result: comments, docstrings, annotations and imports for types,
names of local variables, line numbers, and the sentences of raised errors. It is the same on every
supported version of Python.

What a run is known by is narrower: its bits. A module that only reads, checks, writes or reports says
so by a constant at its top, `NO_BITS`, with the reason; it is neither counted nor followed for bits.

A module of a user's own is named by the folder where it is found and its name there, such as
/home/me/sweeps:stones. Of its imports those from that folder and from the packages of ROOTS count. The
folder is in no hash: a copy elsewhere is the same code.
"""

import ast
import hashlib
import json
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.util import find_spec, resolve_name
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from platformdirs import user_cache_path

from dem.base.errors import InputError
from dem.base.files import atomic

NO_BITS = "finds out what a run depends on"

ROOT = Path(__file__).parent.parent.parent
ROOTS = {"dem": ROOT / "dem"}  # packages whose code counts, by name; studies add themselves
INSTALLED = {"site-packages", "dist-packages"}  # folders of what was installed
UNREADABLE = OSError, SyntaxError, ValueError  # what reading sources raises

# Fields of syntax nodes that hold no code, or differ between versions of Python.
_NO_CODE = {"annotation", "returns", "type_comment", "type_params", "kind", "ctx"}


@cache
def closure(*modules: str, bits: bool = False) -> tuple[str, ...]:
    """Sorted names of the modules that the given ones depend on, and their own.

    bits: without what can change no bit of a run.

    Imports are read from the source; nothing is imported. The packages that contain a module count,
    because Python runs their __init__.py first. Raises ValueError for a module that they do
    not have, OSError and SyntaxError for one that cannot be read.
    """
    for module in modules:
        if file_of(module) is None:
            raise ValueError(f"module is {module!r}; it must be one of {', '.join(ROOTS)}")
    found, left = set(), list(modules)
    while left:
        name = left.pop()
        if name not in found and not (bits and _read(file_of(name)).no_bits and is_ours(name)):
            found.add(name)
            left += _needed(name)
    return tuple(sorted(found, key=plain))


def _needed(module: str) -> Iterator[str]:
    """The modules that a module imports, and the package that contains it, as far as they count."""
    folder = module.rpartition(":")[0]
    for name in (*_names(module), plain(module).rpartition(".")[0]):
        if file_of(name):
            yield name
        elif folder and name in _published():
            yield _published()[name]
        elif folder and _is_beside(module, name):
            yield f"{folder}:{name}"


def _names(module: str) -> Iterator[str]:
    """What a module imports, in full."""
    own, path = plain(module), file_of(module)
    package = own if path.name == "__init__.py" else own.rpartition(".")[0]
    for name in _read(path).imports:
        if not name.startswith("."):
            yield name
        elif is_ours(module):
            raise ValueError(f"{path}: write imports in full, not relative")
        else:
            with suppress(ImportError):  # Python refuses it too
                yield resolve_name(name, package)


def _is_beside(module: str, name: str) -> bool:
    """Whether a module of a user finds a name in its folder; among what is installed, in its package."""
    folder, _, own = module.rpartition(":")
    first = name.partition(".")[0]
    near = first == own.partition(".")[0] or not INSTALLED & set(Path(folder).parts)
    own_name = first not in sys.stdlib_module_names and first not in ROOTS
    return near and own_name and file_of(f"{folder}:{name}") is not None


@cache
def _published() -> dict[str, str]:
    """Modules of the public names of the library."""
    found = {}
    for node in ast.parse((ROOTS["dem"] / "__init__.pyi").read_bytes()).body:
        for each in node.names if isinstance(node, ast.ImportFrom) else ():
            inner = f"dem.{node.module}.{each.name}"
            found[f"dem.{each.name}"] = inner if file_of(inner) else f"dem.{node.module}"
    return found


def plain(module: str) -> str:
    """Name of a module without its folder."""
    return module.rpartition(":")[2]


def address(module: str, file) -> str | None:
    """How `closure` names a module that Python knows by this name and file; None where it has none."""
    if is_ours(module):
        return module
    if not file or module == "__main__":
        return None
    path = Path(file)
    stem = path.parent if path.name == "__init__.py" else path.with_suffix("")
    parts = module.split(".")
    if list(stem.parts[-len(parts) :]) != parts:
        return None
    found = f"{stem.parents[len(parts) - 1].resolve()}:{module}"
    return found if file_of(found) else None


def own_files(module: str) -> dict[str, Path]:
    """Files of those modules of a user that a module depends on, by their names."""
    found = closure(module, bits=True)
    return {plain(each): file_of(each) for each in found if not is_ours(each)}


def is_current(module: str) -> bool:
    """Whether the code of a user's module is what it was when it was read."""
    return all(map(_is_as_read, own_files(module).values()))


def reread() -> bool:
    """Forget the code of users where any of it has changed since it was read; returns whether it has.

    Raises InputError where code of ROOTS has, because this process goes on with what it was.
    """
    changed = [
        module
        for module, path in _FILES.items()
        if path != _file(module) or (path in _READ and not _is_as_read(path))
    ]
    for module in filter(is_ours, changed):
        raise InputError(
            f"{file_of(module)} has changed since this process read it; start Python, or the workers, again."
        )
    if changed:
        for module in [each for each in _FILES if ":" in each]:
            _READ.pop(_FILES.pop(module), None)
        closure.cache_clear()
        code_hash.cache_clear()
    return bool(changed)


def from_elsewhere(module: str) -> dict[str, str]:
    """Where the imports of a user's module lead that are neither in its folder, nor installed, nor of
    ROOTS, by their names: edits there are noticed by nobody."""
    found = {}
    for own in (each for each in closure(module, bits=True) if not is_ours(each)):
        for name in dict.fromkeys(each.partition(".")[0] for each in _names(own)):
            if name in sys.stdlib_module_names or name in ROOTS or _is_beside(own, name):
                continue
            with suppress(ImportError, ValueError):
                origin = getattr(find_spec(name), "origin", None)
                if origin and not INSTALLED & set(Path(origin).parts):
                    found[name] = origin
    return found


@cache
def code_hash(*modules: str, bits: bool = False) -> str:
    """SHA-256 of the code of the closure of modules, as hexadecimal digits; raises as closure."""
    text = "".join(f"{name} {code}\n" for name, code in codes(*modules, bits=bits).items())
    return _digest(text.encode())


def codes(*modules: str, bits: bool = False) -> dict[str, str]:
    """SHA-256 of the code of each module of a closure, by name."""
    return {plain(name): _read(file_of(name)).code for name in closure(*modules, bits=bits)}


def file_of(module: str) -> Path | None:
    """Source of a module, or None if neither a package of ROOTS nor the folder that it names has it."""
    if module not in _FILES:
        _FILES[module] = _file(module)
    return _FILES[module]


def _file(module: str) -> Path | None:
    folder, _, own = module.rpartition(":")
    name, *rest = own.split(".")
    if not name or not (folder or name in ROOTS):
        return None
    stem = (Path(folder) / name if folder else ROOTS[name]).joinpath(*rest)
    choices = stem / "__init__.py", stem.with_name(f"{stem.name}.py")
    return next((path for path in choices if path.is_file()), None)


def is_ours(module: str) -> bool:
    """Whether a module is of a package of ROOTS."""
    return ":" not in module and file_of(module) is not None


def cache_folder() -> Path:
    """Folder of the caches: $NUMBA_CACHE_DIR or the user's cache folder."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or user_cache_path("dem", appauthor=False))


class Source(NamedTuple):
    """Names that a file imports, as written, the SHA-256 of its code, whether it says NO_BITS, and what
    is defined at its top.

    Some names are not modules but members of one.
    """

    imports: list[str]
    code: str
    no_bits: bool
    defined: dict[str, list[str]]  # classes and functions by name: the functions in it


def defined_in(module: str) -> dict[str, list[str]]:
    """The classes and functions at the top of a module by name, each class with those of its functions."""
    return _read(file_of(module)).defined


IMPORTED: dict[
    str, str
] = {}  # hashes of the code of users that Python has, by the names of modules
_FILES: dict[str, Path | None] = {}  # what file_of has said
_READ: dict[Path, tuple[str, Source]] = {}  # files that were read: digest and source


def _read(path: Path) -> Source:
    """Source of a file, as it was when it was first read."""
    if path not in _READ:
        content = path.read_bytes()
        _READ[path] = _digest(content), _source(content, path)
    return _READ[path][1]


def _is_as_read(path: Path) -> bool:
    """Whether the code of a file is still what was read."""
    content, (digest, source) = path.read_bytes(), _READ[path]
    with suppress(*UNREADABLE):
        return _digest(content) == digest or _source(content, path).code == source.code
    return False


def _source(content: bytes, path: Path) -> Source:
    """Source of a file of some content, from a cache on disk, because parsing takes time.

    The key is the content of the file and of this module. A digest reveals damage.
    """
    kept = cache_folder() / "sources" / f"{_digest(content + Path(__file__).read_bytes())}.json"
    with suppress(OSError, ValueError):  # absent, or damaged
        seal, _, text = kept.read_text().partition("\n")
        if seal == _digest(text.encode()):
            return Source(*json.loads(text))
    source = _parse(content, path)
    text = json.dumps(source)
    with suppress(OSError), atomic(kept) as part:  # nothing is lost where it cannot be kept
        part.write_text(f"{_digest(text.encode())}\n{text}")
    return source


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _parse(content: bytes, path: Path) -> Source:
    tree = ast.parse(content, str(path))
    tree.body = [  # what is for types never runs
        each
        for each in tree.body
        if not (isinstance(each, ast.If) and ast.unparse(each.test) == "TYPE_CHECKING")
    ]
    defined = {
        each.name: [own.name for own in each.body if isinstance(own, ast.FunctionDef)]
        for each in tree.body
        if isinstance(each, ast.ClassDef | ast.FunctionDef)
    }
    code = _digest(_code(tree).encode())
    return Source(_imported(tree), code, b"\nNO_BITS = " in content, defined)


def _imported(tree: ast.Module) -> list[str]:
    names, packages = [], {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [each.name for each in node.names]
            whole = {each.name.partition(".")[0] for each in node.names if not each.asname}
            packages |= {name: name for name in whole}
            packages |= {each.asname: each.name for each in node.names if each.asname}
        elif isinstance(node, ast.ImportFrom):
            module = "." * node.level + (node.module or "")
            dot = "" if module.endswith(".") else "."
            names += [module, *(f"{module}{dot}{each.name}" for each in node.names)]
    for node in ast.walk(tree):  # dem.Disc after `import dem`
        if isinstance(node, ast.Attribute) and (name := _dotted(node, packages)):
            names.append(name)
    return list(dict.fromkeys(names))


def _dotted(node, packages: dict[str, str]) -> str | None:
    """A member of an imported package in full, None for a member of anything else."""
    if isinstance(node, ast.Name):
        return packages.get(node.id)
    if isinstance(node, ast.Attribute) and (inner := _dotted(node.value, packages)):
        return f"{inner}.{node.attr}"
    return None


def _code(node, names: dict = MappingProxyType({})) -> str:
    """A syntax tree as text, without fields that are not code.

    names: what local variables are called instead. Written here and not by ast.dump, whose text differs
    between versions of Python.
    """
    if isinstance(node, list):
        return f"[{','.join(_code(each, names) for each in node)}]"
    if not isinstance(node, ast.AST):
        return ascii(node)  # which characters repr shows differs between versions
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda | COMPREHENSIONS):
        names = _inside(node, names)
    elif isinstance(node, ast.ClassDef):
        names = {}  # what a class sets are attributes
    fields = [(name, getattr(node, name, None)) for name in node._fields if name not in _NO_CODE]
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        fields = [("exc", node.exc.func)]  # which error, not what it says
    if isinstance(node, ast.Name):
        fields = [("id", names.get(node.id, node.id))]
    if isinstance(node, ast.Nonlocal):
        fields = [("names", [names.get(each, each) for each in node.names])]
    inner = ",".join(
        f"{name}={_code(_parts(node, name, value), names)}"
        for name, value in fields
        if value is not None and value != []
    )
    return f"{type(node).__name__}({inner})"


COMPREHENSIONS = ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp
SCOPES = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda | ast.ClassDef | COMPREHENSIONS


def _inside(node, names: dict) -> dict:
    """What the variables of a function are called in its text: numbers, in the order in which they are
    set. Arguments keep their names, because callers may say them."""
    kept = {each.arg for each in ast.walk(getattr(node, "args", node)) if isinstance(each, ast.arg)}
    bound, left = [], list(ast.iter_child_nodes(node))
    while left:
        each = left.pop(0)
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store):
            bound.append(each.id)
        if isinstance(each, ast.Global | ast.Nonlocal):
            kept.update(each.names)
        if isinstance(each, ast.FunctionDef | ast.ClassDef):  # its name stays what it is
            kept.add(each.name)
        left[:0] = [] if isinstance(each, SCOPES) else ast.iter_child_nodes(each)
    if isinstance(node, COMPREHENSIONS):  # := binds outside
        kept.update(each.target.id for each in ast.walk(node) if isinstance(each, ast.NamedExpr))
    found = {name: called for name, called in names.items() if name not in kept}
    first = 1 + max(names.values(), default=-1)
    own = [name for name in dict.fromkeys(bound) if name not in kept]
    return found | {name: first + number for number, name in enumerate(own)}


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
