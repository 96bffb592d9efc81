"""Draw everything that can be drawn, and write the page that shows it.

Figures come from docs/data; films and pictures from runs that the build simulates. The page shows
the command lines that drew them.
"""

import shlex
import subprocess
import sys
from pathlib import Path

from findings import FILES, ROOT

from dem.figures.catalogue import draw, drawable_from
from dem.io.lazily import open_lazily
from studies import catalogue

FOLDER = Path("_generated/gallery")  # in docs
# run: the command line that simulates it
RUNS = {
    f"{shape}.nc": f"dem simulate --shape {shape} --density 3900 --seed 1 -o {shape}.nc"
    for shape in ("c1", "d1", "e3")
}
# file: (what it shows, the command line that draws it)
PICTURES = {
    "film.mp4": (
        "Ellipses of aspect ratio 1.375: speed and contact forces",
        "dem draw e3.nc --color speed --forces -o film.mp4",
    ),
    "forces.png": (
        "Discs: the sum of the normal forces on each granule, and the forces between them",
        "dem draw c1.nc --color force --forces -o forces.png",
    ),
    "layers.png": (
        "Dumbbells, coloured in layers before the cylinder moved",
        "dem draw d1.nc --color layer -o layers.png",
    ),
    "cluster.png": (
        "Ellipses, those that began ahead of the cylinder shaded",
        "dem draw e3.nc --color cluster -o cluster.png",
    ),
}


def write(docs: Path) -> None:
    """Draw what is older than the code or its data, and write docs/_generated/gallery.md."""
    folder = docs / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    code = max(path.stat().st_mtime for path in (ROOT / "dem").rglob("*.py"))
    figures, drawn = catalogue.figures(), {}
    for file in FILES:
        of = Path(file.source).stem
        own = {name: each for name, each in figures.items() if each.file == of}
        if of == "drag" != file.name:
            own = {name: each for name, each in own.items() if name == file.name}
        with open_lazily(file.path) as dataset:
            drawn |= {name: file for name in drawable_from(file.path, dataset, own)}
    for name, file in drawn.items():
        if _older(folder / f"{name}.png", max(code, file.path.stat().st_mtime)):
            draw(name, file.path, folder, figures)
    for file, command in (RUNS | {each: shown[1] for each, shown in PICTURES.items()}).items():
        if _older(folder / file, code):
            _run(command, folder)
    (folder.parent / "gallery.md").write_text(_page(drawn), encoding="utf-8")


def _older(file: Path, time: float) -> bool:
    return not file.exists() or file.stat().st_mtime < time


def _run(command: str, folder: Path) -> None:
    """Run a command line on the files of the folder."""
    files = {*RUNS, *PICTURES}
    words = [str(folder / word) if word in files else word for word in shlex.split(command)]
    subprocess.run([sys.executable, "-m", *words], cwd=ROOT, check=True, stderr=subprocess.DEVNULL)


def _page(drawn: dict) -> str:
    """Every figure with its command, in the order of the paper."""
    own = catalogue.figures()
    figures = [
        (own[name].caption, f"{_by(own[name])} figure {name} results/{file.source}", f"{name}.png")
        for name, file in drawn.items()
    ]
    runs = [(about, command, file) for file, (about, command) in PICTURES.items()]
    parts = ["# What can be drawn?\n"]
    for heading, group in (("Films and pictures of one run", runs), ("Figures", figures)):
        parts.append(f"## {heading}\n")
        parts += [_entry(*each) for each in group]
    return "\n".join(parts)


def _by(figure) -> str:
    return "dem" if figure.package == "dem" else "python -m studies"


def _entry(about: str, command: str, file: str) -> str:
    source = f"gallery/{file}"
    shown = f"![{about}]({source})"
    if file.endswith(".mp4"):
        shown = f"```{{video}} {source}\n:width: 100%\n:autoplay:\n:loop:\n:muted:\n```"
    return f"### {about}\n\n{shown}\n\n```console\n$ {command}\n```\n"
