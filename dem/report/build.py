"""results/report.html: figures and tables on one page, which needs no network."""

import base64
from datetime import UTC, datetime
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from PIL import Image

from dem.analysis.tables import ROWS, number
from dem.base.errors import InputError
from dem.base.files import write_bytes
from dem.figures.catalogue import FIGURES, of_file
from dem.io.lazily import open_lazily
from dem.report.info import LEGEND, drag_table, means_table

ORIGIN = ("title", "versions", "git_revision", "references")


def build(drag: Path, output: Path) -> None:
    """Write the report of a folder of results, atomically; raises InputError for other files.

    It shows the means of a combined file, the pictures in the folder figures beside it, and the
    tables of studies, STUDY.txt beside STUDY.nc. It says what the figures that are not there lack.
    """
    folder = Path(drag).parent
    with open_lazily(drag) as dataset:
        has_drag = "drag" in dataset.variables
        table = drag_table(dataset) if has_drag else means_table(dataset)
        parts = {name: dataset.attrs[name] for name in ORIGIN}
        exists = dataset["run_id"] != ""
        if "failure" in dataset:
            exists &= dataset["failure"] == 0
        parts["runs"] = int(exists.sum())
    pictures = sorted((folder / "figures").glob("*.png"))
    if not pictures:
        raise InputError(f"{folder}: there are no figures; draw them first: dem figure all {drag}.")
    texts = [file for file in sorted(folder.glob("*.txt")) if file.with_suffix(".nc").is_file()]
    page = Environment(
        loader=PackageLoader("dem", "report"), autoescape=True, undefined=StrictUndefined
    ).get_template("page.html")
    html = page.render(
        parts,
        legend=LEGEND if has_drag else "Means over the runs, with half the 95 % interval.",
        table=Markup(
            table.head(ROWS).to_html(index=False, border=0, na_rep="-", float_format=number)
        ),
        more=len(table) - ROWS,
        figures=map(embedded, pictures),
        left=left_out(Path(drag), {file.stem for file in pictures}),
        studies=[(file.stem, file.read_text(encoding="utf-8")) for file in texts],
        provenance="provenance.html" if (folder / "provenance.html").is_file() else "",
        now=f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
    )
    write_bytes(output, html.encode())


def embedded(file: Path) -> tuple[str, str, str]:
    """Name, caption and data of a picture."""
    with Image.open(file) as picture:
        caption = picture.info.get("Title", file.stem)
    return file.stem, caption, base64.b64encode(file.read_bytes()).decode()


def left_out(drag: Path, drawn: set[str]) -> list[str]:
    """Why figures are not drawn, of a file and of those beside it; one sentence each."""
    sentences, others = [], {figure.file for figure in FIGURES.values()} - {"drag"}
    for name, figure in FIGURES.items():
        if drag.stem in others and figure.file != drag.stem:
            continue  # of another experiment
        data = drag if figure.file in ("drag", drag.stem) else drag.with_name(f"{figure.file}.nc")
        lack = f"there is no {data.name}"
        if data.is_file():
            with open_lazily(data) as dataset:
                lack = figure.lack(*of_file(dataset)) or f"draw it first: dem figure {name} {data}"
        sentences += [f"{name} is left out: {lack}."] * (name not in drawn)
    return sentences
