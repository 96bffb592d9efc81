"""results/report.html from the files of results and the page of assumptions."""

import base64
import io
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from jinja2.utils import htmlsafe_json_dumps
from markdown_it import MarkdownIt
from markupsafe import Markup
from PIL import Image
from rich.table import Table

from dem.analysis.statistics import by_case, change, summarise
from dem.analysis.statistics import densities as densities_of
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.figures.catalogue import drawable_from
from dem.figures.style import percent
from dem.io.lazily import open_lazily, require
from dem.report.info import drag_table, means_table
from dem.report.interactive import beds, chart
from dem.sweep.combine import open_combined

# What the report needs of drag.nc, beside what all readers need.
NEEDED = (
    "max_overlap", "time_step", "run_time", "steps", "aspect_ratio", "diameter", "granules",
)  # fmt: skip
ORIGIN = ("title", "versions", "git_revision", "references", "configuration")
PIXELS = 1200  # width of a picture
OPEN = "## What the paper leaves open"  # section of docs/explanation/open.md, shown as it is


def build(drag: Path, output: Path, notes: Path | None = None) -> None:
    """Write the report of a folder of results, atomically; raises InputError for other files.

    It shows the figures and studies beside drag.nc, and the beds of snapshots.nc if it is there. A sweep of values
    other than cases or shapes has a table over its axes instead, and a file without drag one of its first
    quantities. notes: a file that tells what the paper leaves open, for its runs.
    """
    folder = Path(drag).parent
    snapshots = folder / "snapshots.nc"
    with open_lazily(drag) as dataset:
        has_drag = "drag" in dataset.variables
    with (open_combined if has_drag else open_lazily)(drag) as dataset:
        require(dataset, drag, {}, NEEDED if has_drag else ("run_id",), ORIGIN)
        names = drawable_from(drag, dataset)
        parts = {"title": dataset.attrs["title"], "runs": runs(dataset), "has_drag": has_drag}
        parts |= of_drag(dataset) if has_drag else of_means(drag, dataset)
    parts |= {"beds": "", "studies": studies(folder)}
    if snapshots.is_file():
        with open_lazily(snapshots) as dataset:
            names += drawable_from(snapshots, dataset)
            parts |= of_snapshots(snapshots, by_case(dataset))
    loader = PackageLoader("dem.report", "page")
    pages = Environment(loader=loader, autoescape=True, undefined=StrictUndefined,
                        trim_blocks=True, lstrip_blocks=True)  # fmt: skip
    page = pages.get_template("page.html").render(
        figures=figures(folder / "figures", names, [name for name, _ in parts["studies"]], drag),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        open=Markup(section(notes, OPEN)) if notes else "",
        provenance="provenance.html" if (folder / "provenance.html").is_file() else "",
        **parts,
    )
    with atomic(output) as part:
        part.write_text(page, encoding="utf-8")


def of_drag(dataset: xr.Dataset) -> dict:
    """What the page says of drag.nc: its table and, of cases, what density does and the curves."""
    table, more = drag_table(dataset)
    found = by_case(dataset)
    return {
        "table": cells(table) | {"more": more},
        "densities": [] if found is None else densities(found),
        "chart": "" if found is None else Markup(chart(found)),
    }


def of_means(path: Path, dataset: xr.Dataset) -> dict:
    """The same of a file without drag: the table of its first quantities."""
    table, more = means_table(path, dataset)
    return {"table": cells(table) | {"more": more}, "densities": [], "chart": ""}


def cells(table: Table) -> dict:
    """Headings and rows of a table."""
    head = [str(column.header) for column in table.columns]
    return {"head": head, "rows": list(zip(*(column.cells for column in table.columns), strict=True))}


def of_snapshots(path: Path, dataset: xr.Dataset | None) -> dict:
    """What the page shows of snapshots.nc: the beds, where runs are by case."""
    if dataset is None:
        return {}
    require(dataset, path, {}, ("granule_x",), ("configuration",))
    return {"beds": htmlsafe_json_dumps(beds(dataset))}


def densities(dataset: xr.Dataset) -> list[str]:
    """What a higher density does, in words, one sentence per pair of cases of one shape."""
    run_mean, groups = summarise(dataset)["run_mean"], densities_of(dataset).values()
    pairs = [(first, other) for first, *others in groups for other in others]
    return [f"{one} to {other}: {percent(*change(run_mean, one, other))}" for one, other in pairs]


def studies(folder: Path) -> list[tuple[str, str]]:
    """Name and table of each study whose file of results is there, as text."""
    there = [file for file in sorted(folder.glob("*.txt")) if file.with_suffix(".nc").is_file()]
    return [(file.stem, _text(file)) for file in there]


def figures(folder: Path, names: list[str], studies: list[str], data: Path) -> list[dict]:
    """Those of the figures that are there, then those of studies, as embedded pictures."""
    files = [folder / f"{name}.png" for name in sorted(set(names))]
    files += [file for study in studies for file in sorted(folder.glob(f"{study}*.png"))]
    found = [_embedded(file) for file in files if file.is_file()]
    if not found:
        raise InputError(f"{folder}: there are no figures; draw them first: dem figure all {data}.")
    return found


def _embedded(file: Path) -> dict:
    """Name, caption and data of a picture: a PNG with a palette, no wider than needed on a screen."""
    with Image.open(file) as picture:
        size = PIXELS, round(picture.height * PIXELS / picture.width)
        small = picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(128).save(buffer := io.BytesIO(), "PNG", optimize=True)
        caption = picture.info.get("Title", file.stem)
    data = base64.b64encode(buffer.getvalue()).decode()
    return {"name": file.stem, "caption": caption, "data": data}


def section(file: Path, heading: str) -> str:
    """One section of a Markdown file, up to the next of its level, as HTML."""
    _, found, rest = _text(file).partition(heading + "\n")
    if not found:
        raise InputError(f"{file}: it has no section {heading!r}.")
    markdown = MarkdownIt("commonmark", {"html": False}).enable("table")
    return markdown.render(rest.partition("\n## ")[0])


def _text(file: Path) -> str:
    try:
        return Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeError) as error:
        raise InputError(f"{file}: it is not a readable text ({error}).") from None


def runs(dataset: xr.Dataset) -> dict:
    """Run times, if the file has them, versions and provenance."""
    spent = dataset["run_time"].values if "run_time" in dataset else np.zeros(dataset["run_id"].size)
    spent = spent[np.isfinite(spent)]
    return {
        "count": spent.size, "total": f"{spent.sum():.0f}", "median": f"{np.median(spent):.1f}",
        "steps": f"{int(dataset['steps'].sum()):,}" if "steps" in dataset else "",
        "versions": dataset.attrs["versions"], "revision": dataset.attrs["git_revision"],
        "references": dataset.attrs["references"],
    }  # fmt: skip
