"""Paths that a user gives to write to, as a kind of dem.base.validate."""

import os
from pathlib import Path
from typing import Any

from dem.base.files import Place, check_paths
from dem.base.validate import Kind, refuse


def file_of(*suffixes: str) -> Kind:
    """Kind: a path with one of these suffixes at which a file can be written; returned as a Path."""

    def take(name: str, value: Any) -> Path:
        given = os.fspath(value) if isinstance(value, str | os.PathLike) else None
        if not isinstance(given, str) or Path(given).suffix.lower() not in suffixes:
            refuse(name, value, f"be the path of a file that ends in {' or '.join(suffixes)}")
        check_paths([Place(name, Path(given))])
        return Path(given)

    return take
