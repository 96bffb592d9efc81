"""The constants, classes and functions at the top of a file, read without running it.

A folder is then the list of what is in it: figures, kinds of experiment, studies.
"""

import ast
import re
from contextlib import suppress
from functools import cache
from pathlib import Path


@cache
def constants(path: Path) -> dict:
    """The constants of a file by name: capitals that are set to plain values."""
    found = {}
    for node in ast.parse(Path(path).read_bytes(), str(path)).body:
        if isinstance(node, ast.Assign) and isinstance(name := node.targets[0], ast.Name):
            with suppress(ValueError):  # computed, so nothing that is said here
                found[name.id] = ast.literal_eval(_Filled(found).visit(node.value))
    return found


class _Filled(ast.NodeTransformer):
    """A syntax tree with the values of constants in place of their names."""

    def __init__(self, known: dict):
        self.known = known

    def visit_Name(self, node):
        known = node.id in self.known
        return ast.parse(repr(self.known[node.id]), mode="eval").body if known else node


@cache
def definitions(path: Path) -> dict[str, list[str]]:
    """Classes and functions at the top of a file by name, each class with its functions."""
    return {
        node.name: [inner.name for inner in node.body if isinstance(inner, ast.FunctionDef)]
        for node in ast.parse(Path(path).read_bytes(), str(path)).body
        if isinstance(node, ast.ClassDef | ast.FunctionDef)
    }


@cache
def described(folder: Path, sign: str) -> dict[str, dict]:
    """Constants of those files of a folder that set `sign`, by name without .py."""
    written = re.compile(rb"^%s\s*=" % sign.encode(), re.MULTILINE)
    files = sorted(Path(folder).glob("*.py"))
    some = [path for path in files if written.search(path.read_bytes())]  # parsing takes longer
    found = {path.stem: constants(path) for path in some}
    return {name: each for name, each in found.items() if sign in each}
