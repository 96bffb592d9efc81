"""The constants, classes and functions at the top of a file, read without running it.

A folder is then the list of what is in it: figures, kinds of experiment, studies.
"""

import ast
from contextlib import suppress
from functools import cache
from pathlib import Path


@cache
def constants(path: Path) -> dict:
    """The constants of a file by name: capitals that are set to plain values."""
    table = {}

    class Filled(ast.NodeTransformer):
        """A syntax tree with the values of constants in place of their names."""

        def visit_Name(self, node):
            return ast.Constant(table[node.id]) if node.id in table else node

    for node in ast.parse(path.read_bytes(), str(path)).body:
        if isinstance(node, ast.Assign) and isinstance(name := node.targets[0], ast.Name):
            with suppress(ValueError):  # computed
                table[name.id] = ast.literal_eval(Filled().visit(node.value))
    return table


@cache
def definitions(path: Path) -> dict[str, list[str]]:
    """Classes and functions at the top of a file by name, each class with its functions."""
    return {
        node.name: [inner.name for inner in node.body if isinstance(inner, ast.FunctionDef)]
        for node in ast.parse(path.read_bytes(), str(path)).body
        if isinstance(node, ast.ClassDef | ast.FunctionDef)
    }


@cache
def described(folder: Path, sign: str) -> dict[str, dict]:
    """Constants of those files of a folder that set `sign`, by name without .py."""
    tables = {path.stem: constants(path) for path in sorted(Path(folder).glob("*.py"))}
    return {name: table for name, table in tables.items() if sign in table}
