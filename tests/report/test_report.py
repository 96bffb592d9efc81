"""The page of results and the tables of `dem info`: each column is that of the file."""

import io
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from pictures import assert_alone, text_of
from project import ROOT, quick
from sweeps import dataset_of, make_sweep

import dem
from dem.analysis.tables import TextTable
from dem.base.statistics import mean_interval
from dem.figures.catalogue import draw
from dem.figures.sweep import plot
from dem.report.build import build
from dem.report.info import drag_table, runs_table, summary

TITLE = "a page of <b>one run</b>"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The report of the paper's file; of its runs one failed, one was never asked for."""
    folder = tmp_path_factory.mktemp("report")
    data = xr.load_dataset(ROOT / "docs/data/drag.nc")
    data["drag"] *= xr.DataArray(np.linspace(0.5, 2.0, 55).reshape(11, 5), dims=("case", "seed"))
    data["max_overlap"] *= xr.DataArray(np.linspace(1.0, 3.0, 600), dims="displacement")
    for name in ("drag", "max_overlap"):
        data[name][-1, 2:] = np.nan
    data["failure"] = (("case", "seed"), np.zeros((11, 5), int), {"comment": "1: too deep"})
    data["failure"][-1, 2] = 1
    data["run_id"][-1, 3:] = ""
    data.attrs["title"] = TITLE
    data.drop_encoding().to_netcdf(folder / "drag.nc")
    draw("figure13", folder / "drag.nc", folder / "figures")
    (folder / "claims.nc").touch()
    (folder / "claims.txt").write_text("a table of <b>claims</b>")
    build(folder / "drag.nc", folder / "report.html")
    return folder / "report.html"


@quick
def test_every_column_of_a_table_is_that_of_the_file(page):
    """In the report and in the terminal: means are means, and the greatest overlap is the greatest."""
    (table,) = pd.read_html(io.StringIO(page.read_text()), index_col=0)
    lines = text_of(summary(page.parent / "drag.nc")).splitlines()
    data = xr.load_dataset(page.parent / "drag.nc")
    window = data["drag"].sel(displacement=slice(1e-3, 5e-3))
    for case in data["case"].values:
        runs = window.sel(case=case).dropna("seed").values
        means = runs.mean(axis=1)
        mean, over, between = means.mean(), runs.var(axis=1).mean() ** 0.5, means.std(ddof=1)
        columns = {
            "runs": len(runs),
            "mean (N)": mean,
            "± (N)": mean_interval(means).half,
            "over run (%)": 100.0 * over / mean,
            "between runs (%)": 100.0 * between / mean,
            "independent": (over / between) ** 2,
            "overlap": float(data["max_overlap"].sel(case=case).max()),
        }
        (shown,) = (line.split()[1:8] for line in lines if re.match(rf"\s*{case} .*\d$", line))
        for words, (name, value) in zip(shown, columns.items(), strict=True):
            assert table.loc[case, name] == pytest.approx(value, rel=1e-3), (case, name)
            assert float(words) == pytest.approx(value, rel=1e-3), (case, name)


@quick
def test_a_page_says_how_many_runs_there_are_and_needs_no_other_file(page):
    """Neither those that failed nor those that were never asked for count as runs. Figures have words; text is
    text."""
    text = page.read_text()
    assert re.search(r"\b52\b[^.]{0,30}runs", re.sub(r"<[^>]+>|\s+", " ", text))
    fetched = r"""<(?:script|link|img|iframe)[^>]*(?:src|href)=["'](?!data:)[^"']+"""
    assert page.stat().st_size < 15e6 and not re.findall(fetched, text)
    (picture,) = re.findall(r"<img [^>]*>", text)
    assert 'alt="Mean drag by shape"' in picture
    assert "a table of &lt;b&gt;claims&lt;/b&gt;" in text and "<b>one run" not in text
    assert "figure09 is left out: there is no snapshots.nc" in text


@quick
def test_info_says_which_runs_are_missing(page):
    text = text_of(summary(page.parent / "drag.nc"))
    assert "1 of 53 runs failed (1: too deep)" in text and TITLE in text
    assert "5, from 1 to 5" in text and "1 mm to 5 mm of displacement, cylinder at 2 m/s" in text


@quick
def test_info_says_how_many_independent_samples_a_run_is_worth():
    """Of 200 bins that are alike by fives there are 40."""
    blocks = np.random.default_rng(1).normal(100.0, 10.0, (1, 400, 40))
    drag = ("shape", "seed", "displacement"), np.repeat(blocks, 5, axis=-1)
    coords = {"displacement": np.linspace(0.0, 1.0, 200), "seed": range(400), "shape": ["c1"]}
    dataset = xr.Dataset({"drag": drag}, coords, {"window_start": 0.0, "window_stop": 1.0})
    assert drag_table(dataset)["independent"].item() == pytest.approx(40.0, rel=0.15)


@quick
def test_a_table_has_a_row_a_place():
    """Of any axes, with its values; a long one says how much is left out."""
    drag = np.random.default_rng(1).uniform(50.0, 150.0, (2, 3, 4))
    axes = {"box": ["wide", "same"], "friction_granule": [0.1, 0.2, 0.3]}
    data = dataset_of(drag, axes)
    table = drag_table(data).set_index([*axes])["mean (N)"]
    expected = data["drag"].mean(["seed", "displacement"]).to_series()
    assert table.to_dict() == pytest.approx(expected.to_dict())
    assert "... and 3 rows more" in text_of(TextTable(pd.DataFrame({"a": range(63)})))


def test_a_sweep_is_shown_with_names_and_units(tmp_path):
    """Of a design over several values too: its figure, its report, and a table of each file of runs."""
    over = {
        "friction.granule": {"low": 0.1, "high": 0.5},
        "ellipse.curvature": {"choices": ["volume", "local"]},
        "material.young_modulus": {"low": 1e10, "high": 1e11, "scale": "log"},
    }
    point = {"design": "latin_hypercube", "points": 6, "over": over}
    make_sweep(tmp_path, sweep={"shape": ["c1", "d1"], "point": point})
    folder = tmp_path / "results"
    build(folder / "drag.nc", folder / "report.html")
    assert 'id="sweep"' in (folder / "report.html").read_text()
    with dem.open_results(folder / "drag.nc") as data:
        panels, runs = plot(data).axes, {run[:12] for run in data["run_id"].values.flat}
    assert {" ".join(axes.get_xlabel().split()): axes.get_xscale() for axes in panels} == {
        "Friction between granules (1)": "linear",
        "Radius of ellipses in Hertz's law": "linear",
        "Young's modulus (Pa)": "log",
    }
    shown = set()
    for batch in (folder / "store/batches").glob("*.nc"):
        with dem.open_results(batch) as dataset:
            table = runs_table(batch, dataset)
            shown |= {*table["run"]}
            assert_allclose(table["steps"], dataset["steps"])
            assert_allclose(table["packing_pressure (Pa)"], dataset["packing_pressure"])
    assert shown == runs
    with pytest.raises(dem.InputError, match="figure13 shows runs that differ in case, or shape"):
        draw("figure13", folder / "drag.nc", tmp_path)


@pytest.mark.parametrize("width", [1280, 400])
def test_the_report_works_in_a_browser(page, browser, width):
    """No request leaves, no script fails, nothing is cut."""
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get(page.as_uri())
    assert_alone(browser)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
