"""Which files of the package a module is made of: itself and all that it imports, directly or not."""

import ast
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent
ROOT = PACKAGE.parent


@cache
def closure(module: str) -> list[str]:
    """Files that a module of this package depends on, relative to the folder of the package.

    Imports are read from the source, those inside functions too; nothing is imported. Packages that
    lie above a module count, because Python runs their __init__.py first. Raises ValueError for a
    module that the package does not have, OSError and SyntaxError for one that cannot be read.
    """
    if _file(module) is None:
        raise ValueError(f"module is {module!r}; it must be one of {PACKAGE.name}")
    found, left = {}, [module]
    while left:
        name = left.pop()
        if name not in found:
            found[name] = _file(name)
            left += [each for each in _imported(found[name]) if _file(each)]
            left += [name.rpartition(".")[0]] if "." in name else []
    return sorted(str(path.relative_to(ROOT)) for path in found.values())


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
def _imported(path: Path) -> tuple[str, ...]:
    """Names that a source file imports, as written; some are no modules but what a module holds."""
    names = []
    for node in ast.walk(ast.parse(path.read_bytes(), str(path))):
        if isinstance(node, ast.Import):
            names += [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"{path}, line {node.lineno}: write imports in full, not relative")
            names += [node.module, *(f"{node.module}.{each.name}" for each in node.names)]
    return tuple(names)
