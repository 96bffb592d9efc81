"""Where the project is, and what a test needs of the system."""

import re
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
CONFIG = ROOT / "config"

# The part of the suite to work with. A file of tests without this word is not read for it (conftest.py).
quick = pytest.mark.quick

# The workflow runs on Linux and macOS, the library and the command line also on Windows.
posix = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX pipes, signals or bash")


def needs_study(*names):
    """Marks tests that are about studies, any of which may be removed."""
    present = [(ROOT / "studies" / name).is_dir() for name in names]
    return pytest.mark.skipif(not all(present), reason=f"needs the studies {', '.join(names)}")


def code(document):
    """Pieces of Python in a document, by the heading above them."""
    pieces, heading = {}, ""
    for title, block in re.findall(
        r"^##? (.*?)$|^```(?:python|\{code-cell\} python)\n(.*?)^```",
        (ROOT / document).read_text(),
        re.S | re.M,
    ):
        heading = title or heading
        pieces[heading] = pieces.get(heading, "") + block
    return pieces


PAGE = (ROOT / "docs/howto/shape.md").read_text()


SHAPE, LIBRARY, SHORT_LINE = re.findall(r"```python\n(.*?)```", PAGE, re.S)

(LAW,) = re.findall(
    r"```python\n# cones.py\n(.*?)```", (ROOT / "docs/howto/law.md").read_text(), re.S
)


# rotation.py, rotation.yaml, rest.py and rest.yaml
EXPERIMENT = (ROOT / "docs/howto/experiment.md").read_text()
FILES = dict(re.findall(r"```(?:python|yaml)\n# (\S+)\n(.*?)```", EXPERIMENT, re.S))


# An experiment that takes no time and reads no bed, and a sweep of it beside its file.
PRODUCT = """
SECTIONS = {"cylinder": False, "record": False}
VARIABLES = {"product": ((), "1", "seed times a factor")}
FACTOR = 2


def run(replicate, bed=None, progress=None):
    return {"product": FACTOR * replicate.seed}
"""
PRODUCTS = f"""
extends: {CONFIG}/smoke.yaml
results: results/product
experiment: product.py
failures: 0.5
batch: 1
sweep: {{shape: c1, density: 3900, seed: [1, 2, 3]}}
"""


def changed_file(file, changes):
    """Values of a file of YAML with others by path; a dot within a key is written as a slash."""
    values = yaml.safe_load(file.read_text(encoding="utf-8"))
    for path, value in changes.items():
        *groups, last = (key.replace("/", ".") for key in path.split("."))
        group = values
        for key in groups:
            group = group.setdefault(key, {})
        group[last] = value
    return values


def write(folder: Path, **files: str) -> Path:
    """Modules in a folder by their names, and a sweep beside them, whose file it returns."""
    for name, text in files.items():
        path = folder / ("sweep.yaml" if name == "sweep" else f"{name.replace('.', '/')}.py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder / "sweep.yaml"
