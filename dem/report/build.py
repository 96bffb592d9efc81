"""results/report.html: figures, tables and the curves of the drag on one page, which needs no
network."""

import base64
from datetime import UTC, datetime
from pathlib import Path

import plotly.graph_objects as go
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from PIL import Image
from plotly.io import to_html

from dem.analysis.drag import by_case, running_mean
from dem.analysis.tables import ROWS, number
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.figures import style
from dem.io.lazily import open_lazily, require
from dem.report.info import LEGEND, drag_table, means_table

ORIGIN = ("title", "versions", "git_revision", "references")
BEGINS = ("c1", "d1", "e3")  # cases of which a run is shown at first
EVERY = 2  # bins between two points of a curve
CURVES = 20  # at most, of a case: a page with thousands would open in no browser


def build(drag: Path, output: Path) -> None:
    """Write the report of a folder of results, atomically; raises InputError for other files.

    It shows the means of a combined file, the pictures in the folder figures beside it, and the
    tables of studies, STUDY.txt beside STUDY.nc.
    """
    folder = Path(drag).parent
    with open_lazily(drag) as dataset:
        require(dataset, drag, {}, ("run_id",), ORIGIN)
        has_drag, cases = "drag" in dataset.variables, by_case(dataset)
        table = drag_table(dataset) if has_drag else means_table(drag, dataset)
        parts = {name: dataset.attrs[name] for name in ORIGIN}
        there = dataset["run_id"] != ""
        if "failure" in dataset:
            there &= dataset["failure"] == 0
        parts["runs"] = int(there.sum())
        parts["chart"] = Markup(drag_curves(cases)) if has_drag and cases is not None else ""
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
        studies=[(file.stem, file.read_text(encoding="utf-8")) for file in texts],
        provenance="provenance.html" if (folder / "provenance.html").is_file() else "",
        now=f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
    )
    with atomic(output) as part:
        part.write_text(html, encoding="utf-8")


def embedded(file: Path) -> tuple[str, str, str]:
    """Name, caption and data of a picture."""
    with Image.open(file) as picture:
        caption = picture.info.get("Title", file.stem)
    return file.stem, caption, base64.b64encode(file.read_bytes()).decode()


def drag_curves(dataset: xr.Dataset) -> str:
    """Drag against displacement as HTML: a curve a run, whose legend shows and hides it."""
    figure, x = go.Figure(), style.millimetres(dataset["displacement"])[::EVERY]
    smooth = running_mean(dataset.isel(seed=slice(CURVES)), style.SMOOTHING)
    for k, case in enumerate(smooth["case"].values):
        for place, curve in enumerate(smooth.sel(case=case).dropna("seed").transpose("seed", ...)):
            figure.add_scatter(
                x=x.round(4),
                y=curve.values[::EVERY].round(1),
                name=f"{case}, seed {curve['seed'].item()}",
                legendgroup=case,
                line={"color": style.CASES[k % len(style.CASES)], "width": 1.6},
                visible=True if case in BEGINS and place == 0 else "legendonly",
                hovertemplate="%{x:.2f} mm: %{y:.0f} N",
            )
    window = style.millimetres([dataset.attrs[f"window_{end}"] for end in ("start", "stop")])
    figure.add_vrect(*window, fillcolor="lightgrey", line_width=0, layer="below")
    figure.update_layout(
        xaxis_title="Displacement of the cylinder (mm)",
        yaxis_title="Drag (N)",
        template="simple_white",
        hovermode="closest",
        legend_groupclick="toggleitem",
    )
    return to_html(figure, include_plotlyjs=True, full_html=False, config={"responsive": True})
