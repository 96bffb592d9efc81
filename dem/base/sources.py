"""What a result depends on is found, not typed: the syntax trees of the modules that make it.

The closure of a module is itself and all that it imports, directly or not, inside functions too.
Its hash leaves out what cannot change a result: comments, docstrings, annotations of types, line
numbers, and the sentences of raised errors. It is the same on every supported version of Python.
"""

import ast
import hashlib
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent.parent
ROOT = PACKAGE.parent

# Fields of syntax nodes that hold no code, or differ between versions of Python.
_NO_CODE = {"annotation", "returns", "type_comment", "type_params", "kind", "ctx"}


@cache
def closure(*modules: str) -> tuple[str, ...]:
    """Names of the modules of this package that the given ones depend on, sorted, themselves among
    them.

    Imports are read from the source; nothing is imported. Packages that lie above a module count,
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
            left += [each for each in _imported(_file(name)) if _file(each)]
            left += [name.rpartition(".")[0]] if "." in name else []
    return tuple(sorted(found))


@cache
def code_hash(*modules: str) -> str:
    """SHA-256 of the code of the closure of modules, as hexadecimal digits; raises as closure."""
    digest = hashlib.sha256()
    for name in closure(*modules):
        digest.update(f"{name} {_tree_hash(_file(name))}\n".encode())
    return digest.hexdigest()


@cache
def _file(module: str) -> Path | None:
    """Source of a module, or None where it is no module of this package."""
    name, *rest = module.split(".")
    if name != PACKAGE.name:
        return None
    stem = PACKAGE.joinpath(*rest)
    choices = stem / "__init__.py", stem.with_suffix(".py")
    return next((path for path in choices if path.is_file()), None)


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_bytes(), str(path))


@cache
def _imported(path: Path) -> tuple[str, ...]:
    """Names that a source file imports, as written; some are no modules but what a module holds."""
    names = []
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Import):
            names += [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"{path}, line {node.lineno}: write imports in full, not relative")
            names += [node.module, *(f"{node.module}.{each.name}" for each in node.names)]
    return tuple(names)


@cache
def _tree_hash(path: Path) -> str:
    return hashlib.sha256(_code(_tree(path)).encode()).hexdigest()


def _code(node) -> str:
    """A syntax tree as text, without what is no code.

    Written here and not by ast.dump, whose text differs between versions of Python.
    """
    if isinstance(node, list):
        return f"[{','.join(map(_code, node))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = [(name, getattr(node, name, None)) for name in node._fields if name not in _NO_CODE]
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        fields = [("exc", node.exc.func)]  # which error, not what it says
    inner = ",".join(
        f"{name}={_code(_without_docstring(name, value))}"
        for name, value in fields
        if value is not None and value != []
    )
    return f"{type(node).__name__}({inner})"


def _without_docstring(name: str, value):
    """The statements of a body that do something: strings alone are docstrings."""
    if name != "body" or not isinstance(value, list):
        return value
    return [each for each in value if not _is_text(each)]


def _is_text(node) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
