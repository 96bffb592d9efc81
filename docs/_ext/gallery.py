"""Draw everything that can be drawn, and write the page that shows it.

Figures come from the released files; films and pictures from runs that the build simulates. The
page shows the command lines that drew them.
"""

import shlex
import subprocess
import sys
from pathlib import Path

from findings import FILES

from dem.base.source_hash import ROOT
from dem.figures.catalogue import draw, drawable_from
from dem.io.lazily import open_lazily
from studies import catalogue

FOLDER = Path("_generated/gallery")  # in docs
# run: the command line that simulates it
RUNS = {
    f"{shape}.nc": f"dem simulate --shape {shape} --density 3900 --seed 1 -o {shape}.nc"
    for shape in ("c1", "d1", "e3")
} | {
    f"{scene}.nc": f"dem simulate --config config/scenes/{scene}.yaml --shape disc --density 2500 --seed 1 -o {scene}.nc"
    for scene in ("drum", "hopper", "column")
}
RUNS["base.nc"] = (
    "dem simulate --config studies/base/smoke.yaml --shape disc --density 1000 --seed 1 packing.fraction=0.7 -o base.nc"
)
# file: the command line that draws it, what it shows
PICTURES = {
    "film.mp4": (
        "dem draw e3.nc --color speed --forces -o film.mp4",
        "Ellipses of aspect ratio 1.375: speed and contact forces",
    ),
    "forces.png": (
        "dem draw c1.nc --color force --forces -o forces.png",
        "Discs: the sum of the normal forces on each granule, and the forces between them",
    ),
    "layers.png": (
        "dem draw d1.nc --color layer -o layers.png",
        "Dumbbells, coloured in layers before the cylinder moved",
    ),
    "drum.mp4": ("dem draw drum.nc -o drum.mp4", "A drum with a blade turns a bed of discs: speed"),
    "hopper.mp4": ("dem draw hopper.nc -o hopper.mp4", "A hopper empties: speed of the discs"),
    "collapse.mp4": ("dem draw column.nc -o collapse.mp4", "A column of discs collapses: speed"),
    "base.mp4": (
        "dem draw base.nc -o base.mp4",
        "A disc is drawn through discs on a plate that rubs: speed",
    ),
    "cluster.png": (
        "dem draw e3.nc --color cluster -o cluster.png",
        "Ellipses, those that began ahead of the cylinder shaded",
    ),
}
OF_MEANS = {"figure13", "figure14"}  # are drawn from precise.nc, which has more beds than drag.nc
CARD = """\
:::{{grid-item-card}}
:img-top: gallery/{file}
:link: {label}
:link-type: ref

{about}
:::"""
FILM = "```{{video}} {}\n:width: 100%\n:autoplay:\n:loop:\n:muted:\n```"


def write(docs: Path) -> None:
    """Draw what is older than the code or its data, and write docs/_generated/gallery.md."""
    folder = docs / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    code = max(path.stat().st_mtime for path in (ROOT / "dem").rglob("*.py"))
    for file, command in (RUNS | {name: shown[0] for name, shown in PICTURES.items()}).items():
        if _older(folder / file, code):
            _run(command, folder)
    figures = _figures(folder, code)
    cards = [
        CARD.format(file=file, label=label(file), about=about)
        for file, (_, about) in (PICTURES | figures).items()
        if not file.endswith(".mp4")
    ]
    parts = ["# What can be drawn?", "::::{grid} 2 3 4 4", *cards, "::::"]
    for heading, group in ("Films and pictures of one run", PICTURES), ("Figures", figures):
        parts.append(f"## {heading}")
        for file, (command, about) in group.items():
            place = f"gallery/{file}"
            shown = FILM.format(place) if file.endswith(".mp4") else f"![{about}]({place})"
            parts += [f"({label(file)})=\n### {about}", shown, f"```console\n$ {command}\n```"]
    (folder.parent / "gallery.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _figures(folder: Path, code: float) -> dict[str, tuple[str, str]]:
    """Draw every figure of a released file; command line and caption by file, in the order of
    the paper."""
    figures, found = catalogue.figures(), {}
    for file in FILES:
        of = Path(file.source).stem
        own = {name: each for name, each in figures.items() if each.file == of}
        if of == "drag":
            shown = OF_MEANS if file.name == "precise" else own if file.name == of else {file.name}
            left = OF_MEANS if file.name == of else {}
            own = {name: each for name, each in own.items() if name in shown and name not in left}
        with open_lazily(file.path) as dataset:
            names = drawable_from(dataset, own)
        for name in names:
            if _older(folder / f"{name}.png", max(code, file.path.stat().st_mtime)):
                draw(name, file.path, folder, figures)
            program = "dem" if figures[name].module.startswith("dem.") else "python -m studies"
            command = f"{program} figure {name} results/{file.source}"
            found[f"{name}.png"] = command, figures[name].caption
    return found


def label(file: str) -> str:
    """Where the gallery shows a file."""
    return "gallery-" + file.replace(".", "-")  # of a figure and a film of one name


def _older(file: Path, time: float) -> bool:
    return not file.exists() or file.stat().st_mtime < time


def _run(command: str, folder: Path) -> None:
    """Run a command line on the files of the folder."""
    files = {*RUNS, *PICTURES}
    words = [str(folder / word) if word in files else word for word in shlex.split(command)]
    subprocess.run([sys.executable, "-m", *words], cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
