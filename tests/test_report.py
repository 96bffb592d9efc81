"""The page of results: it opens anywhere, without a network, and can be read."""

import io
import re
import shutil
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from conftest import assert_alone, assert_not_blank, places_shown
from rich.console import Console

from dem.analysis.flow.collect import collect, write_flow
from dem.base.errors import InputError
from dem.experiment import drag
from dem.figures import FLOW, draw, possible
from dem.report.build import build, section
from dem.report.info import summary
from dem.studies.config import load
from dem.sweep.combine import combine, open_combined

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The report of two cases and two seeds of the smoke sweep."""
    folder, sweep = tmp_path_factory.mktemp("report"), load(ROOT / "config/smoke.yaml")
    sweep = sweep.model_copy(update={"cases": {name: sweep.cases[name] for name in ("c1", "e3")}})
    files = []
    for case in sweep.cases.values():
        for seed in sweep.seeds:
            replicate = sweep.replicate(case.shape, case.density, seed)
            files.append(folder / f"{case.shape}{seed}.nc")
            drag.write_replicate(
                files[-1], replicate, drag.run(replicate, drag.make_bed(replicate))
            )
    combine(files, sweep, folder / "drag.nc")
    write_flow(folder / "flow.nc", sweep, collect(files, sweep))
    for name in ("figure13", *possible(sweep, FLOW)):
        draw(name, folder / ("drag.nc" if name == "figure13" else "flow.nc"), folder / "figures")
    (folder / "stability.txt").write_text("a table of <b>stability</b>")
    build(folder / "drag.nc", folder / "flow.nc", ROOT / "README.md", folder / "report.html")
    return folder / "report.html"


def test_nothing_is_fetched_and_all_is_there(page):
    """No tag asks for another file; figures have words; tables and sections are there, text is text."""
    text = page.read_text()
    assert page.stat().st_size < 15e6
    body = re.sub(r"(<script[^>]*>).*?</script>", r"\1", text, flags=re.S)
    assert not re.findall(
        r"""<(?:script|link|img|iframe)[^>]*(?:src|href)=["'](?!data:)[^"']+""", body
    )
    for picture in (page.parent / "figures").glob("*.png"):
        assert_not_blank(picture)
    pictures = re.findall(r"<img [^>]*>", body)
    assert len(pictures) >= 4 and all(re.search(r'alt="[^"]{10,}"', tag) for tag in pictures)
    assert "a table of &lt;b&gt;stability&lt;/b&gt;" in body
    told = section(ROOT / "README.md", "## What the paper leaves open")
    assert "Slips in the paper" in told and "<table>" in told and told in body


def test_the_table_of_the_report_holds_the_means(page):
    """The mean drag of each case, as it follows from drag.nc."""
    import xarray as xr

    with xr.open_dataset(page.parent / "drag.nc") as data:
        window = data["drag"].sel(displacement=slice(data.window_start, data.window_stop))
        means = window.mean(("displacement", "seed")).to_series()
    body = page.read_text().partition("<tbody>")[2].partition("</tbody>")[0]
    rows = dict(re.findall(r"<tr><th[^>]*>(\w+)</th>.*?<b>(\d+)</b>", body, flags=re.S))
    assert {case: round(mean) for case, mean in means.items()} == {
        k: int(v) for k, v in rows.items()
    }


def test_info_prints_the_mean_and_the_runs_of_each_case(page):
    console = Console(width=160, file=io.StringIO())
    console.print(summary(page.parent / "drag.nc"))
    with open_combined(page.parent / "drag.nc") as data:
        inside = data["drag"].sel(displacement=slice(data.window_start, data.window_stop))
        means = inside.mean(("displacement", "seed")).to_series()
    for case, mean in means.items():
        (row,) = re.findall(rf"(?m)^ *{case} .*$", console.file.getvalue())
        assert re.search(rf"\b{mean:.0f}\b", row) and re.search(r"\b2\b", row)


def panels(page, name):
    """Data (k, 2) that each panel of a figure of drag.nc shows, and the file itself."""
    with open_combined(page.parent / "drag.nc") as dataset:
        figure = import_module(f"dem.figures.{name}").plot(dataset)
        return [places_shown(axes) for axes in figure.axes], dataset.load()


def test_bars_are_the_means_and_marks_the_runs(page):
    """Of figure 13: the top of each bar and each mark follow from drag.nc."""
    (shown,), data = panels(page, "figure13")
    inside = data["drag"].sel(displacement=slice(data.window_start, data.window_stop))
    runs = inside.mean("displacement")
    for wanted in [*runs.values.ravel(), *runs.mean("seed").values]:
        assert np.isclose(shown[:, 1], wanted, rtol=1e-9).any()


def test_curves_go_through_the_bins(page):
    """Of figure 7: the mean over the seeds at every displacement is in the panel of its case."""
    shown, data = panels(page, "figure07")
    assert len(shown) == data.sizes["case"]
    for panel, case in zip(shown, data["case"].values, strict=True):
        wanted = data["drag"].sel(case=case).mean("seed").values
        place = np.column_stack([1e3 * data["displacement"], wanted])
        apart = np.abs(panel[:, None] - place).max(axis=2).min(axis=0)
        assert apart.max() < 1e-6 * wanted.max()


def test_a_readme_without_the_section_is_refused(page, tmp_path):
    """The section is named."""
    (tmp_path / "README.md").write_text("# nothing\n")
    with pytest.raises(InputError, match="What the paper leaves open"):
        build(
            page.parent / "drag.nc",
            page.parent / "flow.nc",
            tmp_path / "README.md",
            tmp_path / "r.html",
        )
    assert not (tmp_path / "r.html").exists()


@pytest.mark.parametrize("width", [1280, 400])
def test_the_report_works_in_a_browser(page, browser, width):
    """No request leaves, no script fails, nothing is cut; boxes and pointer do what they say."""
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False},
    )
    browser.get(page.as_uri())
    assert_alone(browser)
    inside = "return document.documentElement.scrollWidth"
    assert browser.execute_script(inside) <= width
    shown = "return chart.data.filter((run) => run.visible).length"
    before = browser.execute_script(shown)
    browser.execute_script("document.querySelectorAll('#choice-seed input')[1].click()")
    assert browser.execute_script(shown) == 2 * before
    browser.execute_script("slider.value = slider.max; slider.dispatchEvent(new Event('input'))")
    assert "1.20 mm" in browser.execute_script(
        "return document.getElementById('where').textContent"
    )
    painted = """
        const bed = document.getElementById("bed");
        const data = bed.getContext("2d").getImageData(0, 0, bed.width, bed.height).data;
        return new Set(new Uint32Array(data.buffer)).size"""
    assert browser.execute_script(painted) > 10


def test_the_notebook_runs_on_a_drag_nc(page, tmp_path):
    """Every cell of the example, from results/drag.nc alone."""
    import nbformat
    from nbclient import NotebookClient

    (tmp_path / "results").mkdir()
    shutil.copy(page.parent / "drag.nc", tmp_path / "results/drag.nc")
    notebook = nbformat.read(ROOT / "examples/drag.ipynb", as_version=4)
    NotebookClient(notebook, resources={"metadata": {"path": str(tmp_path)}}, timeout=120).execute()
    tables = [cell.outputs[-1].data for cell in notebook.cells if cell.cell_type == "code"]
    assert "c1" in tables[1]["text/plain"] and any("image/png" in data for data in tables)
