"""The page of results: it opens anywhere, without a network, and can be read."""

import io
import re
from functools import cache
from importlib import import_module

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from pictures import assert_alone, assert_not_blank, places_shown, text_of
from sweeps import make_sweep

from dem.analysis.drag import summarise
from dem.analysis.tables import TextTable
from dem.base.errors import InputError
from dem.figures.catalogue import draw, drawable_from
from dem.figures.sweep import is_logarithmic
from dem.io.lazily import open_lazily
from dem.report.build import build
from dem.report.info import drag_table, summary

BOXES = {"wide": {"box_width": 10e-3, "shapes.c1.granules": 75}, "same": {"box_width": 8e-3}}
SWEEPS = {
    "grid": {
        "shape": ["c1", "d1"],
        "friction.granule": [0.1, 0.2, 0.3],
        "box": BOXES,
        "seed": "1 to 2",
    },
    "names": {"shape": ["c1", "d1"], "box": BOXES},
    "many": {
        "shape": ["c1"],
        "material.restitution": [0.2, 0.4, 0.6, 0.8],
        "box": BOXES,
        "friction.granule": [0.1, 0.2, 0.3],
        "friction.wall": [0.1, 0.3],
    },
    "point": {"shape": ["c1"], "friction.granule": [0.3], "seed": "1 to 2"},
    "design": {
        "shape": ["c1", "d1"],
        "point": {
            "design": "latin_hypercube",
            "points": 6,
            "first_seed": 11,
            "over": {
                "friction.granule": {"low": 0.1, "high": 0.5},
                "ellipse.curvature": {"choices": ["volume", "local"]},
                "material.young_modulus": {"low": 1e10, "high": 1e11, "scale": "log"},
            },
        },
    },
}


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The report of two cases and two seeds of the smoke sweep."""
    folder = tmp_path_factory.mktemp("report")
    make_sweep(folder, beds=True, sweep={"case": ["c1", "e3"], "seed": [1, 2]})
    folder = folder / "results"
    (folder / "stability.nc").touch()
    (folder / "stability.txt").write_text("a table of <b>stability</b>")
    build(folder / "drag.nc", folder / "report.html")
    return folder / "report.html"


@pytest.fixture(scope="module", params=SWEEPS)
def swept(request, tmp_path_factory):
    """Name and results of sweeps over other values than cases."""
    folder = tmp_path_factory.mktemp(request.param)
    make_sweep(folder, sweep=SWEEPS[request.param], record={"observables": ["drag"]})
    return request.param, folder / "results"


def test_nothing_is_fetched_and_all_is_there(page):
    """No tag asks for another file; figures have words; tables and sections are there, text is text."""
    text = page.read_text()
    assert page.stat().st_size < 15e6
    assert not re.findall(
        r"""<(?:script|link|img|iframe)[^>]*(?:src|href)=["'](?!data:)[^"']+""", text
    )
    for picture in (page.parent / "figures").glob("*.png"):
        assert_not_blank(picture)
    pictures = re.findall(r"<img [^>]*>", text)
    assert len(pictures) >= 4 and all(re.search(r'alt="[^"]{10,}"', tag) for tag in pictures)
    assert "a table of &lt;b&gt;stability&lt;/b&gt;" in text


def means_of(folder):
    """Mean drag of each case, as it follows from drag.nc."""
    with open_lazily(folder / "drag.nc") as data:
        inside = data["drag"].sel(displacement=slice(data.window_start, data.window_stop))
        return inside.mean(("displacement", "seed")).to_series()


def test_the_table_of_the_report_holds_the_means(page):
    (table,) = pd.read_html(io.StringIO(page.read_text()), index_col=0)
    for case, mean in means_of(page.parent).items():
        assert table.loc[case, "mean (N)"] == pytest.approx(mean, rel=1e-4)


def test_info_prints_the_mean_and_the_runs_of_each_case(page):
    text = text_of(summary(page.parent / "drag.nc"))
    for case, mean in means_of(page.parent).items():
        (row,) = re.findall(rf"(?m)^{case} .*$", text)
        assert re.search(rf"\b{mean:.5g}\b", row) and re.search(r"\b2\b", row)


def panels(page, name):
    """Data (k, 2) that each panel of a figure of drag.nc shows, and the file itself."""
    with open_lazily(page.parent / "drag.nc") as dataset:
        figure = import_module(f"dem.figures.{name}").plot(dataset)
        return [places_shown(axes) for axes in figure.axes], dataset.load()


def test_bars_are_the_means_and_marks_the_runs(page):
    """Of figure 13: the top of each bar and each mark follow from drag.nc."""
    (axes,), data = panels(page, "figure13")
    inside = data["drag"].sel(displacement=slice(data.window_start, data.window_stop))
    runs = inside.mean("displacement")
    for expected in [*runs.values.ravel(), *runs.mean("seed").values]:
        assert np.isclose(axes[:, 1], expected, rtol=1e-9).any()


def test_curves_are_running_means_over_a_fifth_of_a_millimetre(page):
    """Of figure 7: at each displacement the mean over the bins about it, as many as that holds."""
    shown, data = panels(page, "figure07")
    assert len(shown) == data.sizes["case"]
    middle = data["displacement"].values
    width = middle[1] - middle[0]
    reach = (round(1e-4 / width) + 0.5) * width
    near = abs(middle[:, None] - middle) < reach
    for panel, case in zip(shown, data["case"].values, strict=True):
        drag = data["drag"].sel(case=case).mean("seed").values
        place = np.column_stack([1e3 * middle, near @ drag / near.sum(axis=1)])
        apart = np.abs(panel[:, None] - place).max(axis=2).min(axis=0)
        assert apart.max() < 1e-6 * drag.max()


@cache
def figure_of(data):
    """The figure of a sweep, its file and its means."""
    with open_lazily(data) as dataset:
        figure = import_module("dem.figures.sweep").plot(dataset)
        return figure, dataset.load(), summarise(dataset)


def drawable(folder):
    """Names of the figures that the files in a folder suffice for."""
    names = []
    for data in folder.glob("*.nc"):
        with open_lazily(data) as dataset:
            names += drawable_from(dataset)
    return names


def test_every_mean_of_a_sweep_is_drawn(swept):
    """Each within the panels; of two axes more than there is room for, their mean."""
    name, folder = swept
    assert drawable(folder) == ["sweep"]
    assert_not_blank(folder / "figures/sweep.png")
    figure, _, statistics = figure_of(folder / "drag.nc")
    values = np.concatenate([places_shown(axes)[:, 1] for axes in figure.axes])
    expected = statistics["mean"]
    if name == "many":  # 4 x 2 x 3 x 2: restitution along x, friction by lines, two by panels
        left_out = re.search(r"averaged over (\w+)", figure.get_suptitle())
        expected = expected.mean(left_out[1]) if left_out else expected
    for value in expected.values.ravel():
        assert np.isclose(values, value, rtol=1e-9).any()
    assert len(figure.axes) <= 12


def test_words_of_a_figure_stay_in_it_however_long_they_are(swept):
    """The title and the labels beside the panels, of a quantity in many words."""
    with open_lazily(swept[1] / "drag.nc") as dataset:
        dataset["drag"].attrs["long_name"] = " ".join(12 * ["force of many words"])
        figure = import_module("dem.figures.sweep").plot(dataset)
    figure.draw_without_rendering()
    for text in [figure._suptitle, *(axes.yaxis.label for axes in figure.axes)]:
        box = text.get_window_extent()
        assert box.y0 >= 0.0 and box.y1 <= figure.bbox.height and box.x1 <= figure.bbox.width, text


def test_axes_of_a_sweep_have_names_and_units(swept):
    """They are logarithmic where values are far apart, as those of a design over a decade."""
    name, folder = swept
    figure, _, _ = figure_of(folder / "drag.nc")
    assert "(N)" in figure.axes[0].get_ylabel() and "0.4 mm to 1 mm" in figure.axes[0].get_ylabel()
    labels = {" ".join(axes.get_xlabel().split()) for axes in figure.axes} - {""}
    expected = {
        "grid": {"Friction between granules (1)"},
        "names": {"Box"},
        "many": {"Coefficient of restitution (1)"},
        "point": {"Friction between granules (1)"},
        "design": {
            "Friction between granules (1)",
            "Radius of ellipses in Hertz's law",
            "Young's modulus (Pa)",
        },
    }
    assert labels == expected[name]
    scales = {
        axes.get_xlabel().partition(" (")[0] for axes in figure.axes if axes.get_xscale() == "log"
    }
    assert scales == ({"Young's modulus"} if name == "design" else set())
    if name not in ("point", "many"):
        assert [text.get_text() for text in figure.legends[0].get_texts()] == [
            "shape: c1",
            "shape: d1",
        ]


@pytest.mark.parametrize(
    ("values", "logarithmic"),
    [
        ([0.5, 1.0, 2.0], False),
        ([1.0, 2.0, 5.0, 10.0], True),
        ([0.6, 1.2, 2.4, 6.0], True),
        ([0.1, 0.3, 0.5], False),
        ([0.82, 0.84, 0.86], False),
        ([0.0, 0.1, 1.0], False),
        ([1.0, 10.0], True),
        ([1.0, 2.0, 3.0, 4.0], False),
        ([1.0, 100.0], True),
    ],
)
def test_a_list_over_more_than_the_fivefold_has_a_logarithmic_axis(values, logarithmic):
    assert is_logarithmic(np.array(values)) == logarithmic


def test_intervals_are_drawn_whole(swept):
    """Also those of two runs, which can be many times the mean, and end below zero."""
    figure, _, statistics = figure_of(swept[1] / "drag.nc")
    means, half = statistics["mean"].values, statistics["half_interval"].fillna(0.0).values
    if swept[0] != "many":  # others are averaged
        for axes in figure.axes:
            low, high = axes.get_ylim()
            assert low <= (means - half).min() and (means + half).max() <= high


def test_info_and_report_have_a_row_a_place(swept):
    """With its values, mean and runs; of a file of runs a row a run."""
    _, folder = swept
    _, _, statistics = figure_of(folder / "drag.nc")
    text = text_of(summary(folder / "drag.nc"))
    for mean in statistics["mean"].values.ravel():
        assert re.search(rf"\b{mean:.5g}\b", text)
    with open_lazily(folder / "drag.nc") as data:
        ids = {str(run)[:12] for run in data["run_id"].values.ravel()}
    for batch in (folder / "store/batches").glob("*.nc"):
        rows = re.findall(r"(?m)^([0-9a-f]{12}) ", text_of(summary(batch)))
        assert rows and set(rows) <= ids
    build(folder / "drag.nc", folder / "report.html")
    body = (folder / "report.html").read_text()
    assert 'id="sweep"' in body
    assert len(pd.read_html(io.StringIO(body))[0]) == statistics["mean"].size


def test_info_says_how_many_independent_samples_a_run_is_worth():
    """Of 200 bins that are alike by fives there are 40."""
    blocks = np.random.default_rng(1).normal(100.0, 10.0, (1, 400, 40))
    drag = xr.DataArray(np.repeat(blocks, 5, axis=-1), dims=("shape", "seed", "displacement"))
    coords = {"displacement": np.linspace(0.0, 1.0, 200), "seed": range(400), "shape": ["c1"]}
    dataset = xr.Dataset({"drag": drag}, coords, {"window_start": 0.0, "window_stop": 1.0})
    assert drag_table(dataset)["independent"].item() == pytest.approx(40.0, rel=0.15)


def test_a_long_table_says_how_much_is_left_out():
    assert "... and 3 rows more" in text_of(
        TextTable(pd.DataFrame({"a": range(63), "b": range(63)}))
    )


def test_a_figure_of_cases_is_not_drawn_of_other_sweeps(swept):
    with pytest.raises(InputError, match="figure13 shows runs that differ in case, or shape"):
        draw("figure13", swept[1] / "drag.nc", swept[1] / "figures")


def test_shapes_and_seeds_are_cases(tmp_path):
    """A sweep over shapes has the figures of the paper, of each shape as a case."""
    make_sweep(tmp_path, beds=True, sweep={"shape": ["c1", "e3"], "seed": [1, 2]})
    folder = tmp_path / "results"
    assert {"figure07", "figure13", "figure09", "figure12"} <= set(drawable(folder))
    for name in drawable(folder):
        assert_not_blank(folder / f"figures/{name}.png")
    build(folder / "drag.nc", folder / "report.html")


@pytest.mark.parametrize("width", [1280, 400])
def test_the_report_works_in_a_browser(page, browser, width):
    """No request leaves, no script fails, nothing is cut."""
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False},
    )
    browser.get(page.as_uri())
    assert_alone(browser)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
