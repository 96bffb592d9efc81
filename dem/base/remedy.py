"""What a user probably meant: the end of a sentence that refuses a value or a file.

Every function returns words such as "; write 0.02, in m", or "" where nothing can be guessed.
"""

import math
import re
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path

PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}
RESULT = b"\x89HDF", b"CDF"  # how netCDF files begin
NUMBER = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"


def of_value(value, units: str | None) -> str:
    """What to write where a number is wanted, in some units ("1": none; None: a text is wanted)."""
    if units is None:
        return ""
    if isinstance(value, bool):
        return "; YAML reads yes, no, on and off as true or false"
    if not isinstance(value, str):
        return ""
    several = rf"\s*{NUMBER}(?:\s*(?:,|;|to)\s*{NUMBER})+\s*"
    decimal = re.sub(r"^(\s*[-+]?\d+),(\d+)(?![\d.]*\s*[,;])", r"\1.\2", value)  # 0,84 is 0.84
    if re.fullmatch(several, decimal):
        values = ", ".join(re.findall(NUMBER, decimal))
        return f"; write several values as a list, [{values}], under `sweep:` in a file"
    found = re.fullmatch(rf"\s*({NUMBER})\s*(\S.*)?", decimal)
    where = "" if units == "1" else f", in {units}"
    factor = found and _factor((found[2] or "").strip(), units)
    if not found:
        return ""
    try:
        value = float(found[1]) * factor
    except (TypeError, ValueError):  # an unknown unit, or points that make no number
        return f"; write the number alone{where}"
    return f"; write {value:.10g}{where}" if math.isfinite(value) else ""


def _factor(unit: str, units: str) -> float | None:
    """How many of some units a unit is, or None: 1e-3 for mm/s in m s-1."""
    if unit == "%":
        return 1e-2 if units == "1" else None
    if not unit:
        return 1.0
    plain = unit.translate(str.maketrans({"µ": "u", "μ": "u", "²": "2", "³": "3", "^": None}))
    plain = re.sub(r"\s*/\s*([a-z]+)(\d?)$", lambda m: f" {m[1]}-{m[2] or 1}", plain)
    return PREFIXES.get(plain.removesuffix(units)) if plain.endswith(units) else None


def of_missing_file(path: Path) -> str:
    """The file of that folder whose name is nearest to one that is not there."""
    folder = Path(path).parent
    if not folder.is_dir():
        return f"; there is no folder {folder}"
    there = {}  # by name without suffix
    with suppress(OSError):
        there = {each.stem: each for each in folder.iterdir() if each.is_file()}
    close = get_close_matches(Path(path).stem, there, 1, 0.6)
    return f"; the nearest is {there[close[0]]}" if close else ""


def of_no_result(path: Path) -> str:
    """What to do with a file that cannot be read as a file of results."""
    path = Path(path)
    if path.suffix in (".yaml", ".yml"):
        return f"; it is a configuration: make its results with dem sweep {path}, and name those"
    if _is_result(path):
        return "; it is cut off or damaged: make it again, or copy it again"
    return ""


def of_no_configuration(path: Path) -> str:
    """What to do with a file that is no YAML file by its name."""
    if _is_result(path):
        return f"; it is a file of results: see it with dem info {path}, and name a YAML file"
    return ""


def _is_result(path: Path) -> bool:
    """Whether a file begins like netCDF."""
    with suppress(OSError), Path(path).open("rb") as file:
        return file.read(4).startswith(RESULT)
    return False
