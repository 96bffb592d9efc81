"""What each figure of dem/figures shows is what its file holds: marks, intervals, words."""

import json
from importlib import import_module

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from pictures import bars_shown, intervals_shown, places_shown, words_shown
from project import ROOT
from scipy import stats
from sweeps import dataset_of

from dem.analysis.onset import limits
from dem.analysis.velocity import AXIS, rates
from dem.figures.catalogue import FIGURES
from dem.figures.sweep import is_logarithmic

pytestmark = pytest.mark.quick


def mean_of(runs):
    """Mean and half its interval by Student's t, of runs (seed, ...) that there are."""
    runs = np.asarray(runs, float)
    runs = runs[np.isfinite(runs.reshape(len(runs), -1)).all(axis=1)]
    n = len(runs)
    return runs.mean(axis=0), stats.t.ppf(0.975, n - 1) * runs.std(axis=0, ddof=1) / np.sqrt(n)


def newtons(runs):
    mean, half = mean_of(runs)
    return f"{mean:.0f} ± {half:.0f} N"


def change(before, after):
    """Of runs in pairs, over the mean of those before, in words."""
    pairs = np.isfinite(before + after)
    mean, half = mean_of((after - before)[pairs])
    base = before[pairs].mean()
    return f"{100.0 * mean / base:+.1f} ± {100.0 * half / base:.1f} %"


def cases():
    """The released file of the paper's sweep, with runs of other means; one run failed."""
    with xr.open_dataset(ROOT / "docs/data/drag.nc") as data:
        data = data[["drag", "run_id", "displacement_bounds", "time_step"]].load()
    level = np.random.default_rng(1).uniform(0.5, 2.0, (11, 5))
    level[-3, 1] = np.nan  # one of d12
    data["drag"] = data["drag"] * xr.DataArray(level, dims=("case", "seed"))
    return data.assign_attrs(window_start=1e-3, window_stop=5e-3)


def runs_of(data):
    """Means (seed,) within the window of each case."""
    x = data["displacement"].values
    inside = (x >= 1e-3) & (x <= 5e-3)
    return {
        str(case): data["drag"].sel(case=case).values[:, inside].mean(axis=1)
        for case in data["case"].values
    }


def running(data, case):
    """Mean and half its interval at each displacement, over a fifth of a millimetre."""
    x = data["displacement"].values
    near = np.abs(x[:, None] - x) < 1e-4 + 1e-6
    drag = data["drag"].sel(case=case).values
    return mean_of(drag @ near / near.sum(axis=0))


def assert_curve(axes, x, y):
    """Every place of a curve is on an axes."""
    apart = np.abs(places_shown(axes)[:, None] - np.column_stack([x, y])[::60])
    assert (apart < 1e-6 * np.array([1.0, np.abs(y).max()])).all(axis=2).any(axis=0).all()


def assert_intervals(axes, expected):
    """These error bars (k, 4) are on an axes, and no others; each x, value, low, high."""
    expected = np.array(sorted(map(list, expected)))
    assert_allclose(intervals_shown(axes), expected, rtol=1e-6, atol=1e-9)


def test_figure_07_shows_running_means_of_each_case():
    data = cases()
    runs, x = runs_of(data), 1e3 * data["displacement"].values
    figure = import_module("dem.figures.figure07").plot(data)
    first = running(data, "c1")[0]
    for axes, case in zip(figure.axes, ["c1", "d1", "c2", "e1", "e2", "e3"], strict=True):
        mean, half = running(data, case)
        for curve in (mean, mean - half, mean + half, first):
            assert_curve(axes, x, curve)
        assert axes.get_title().startswith(f"{case}: ")
        assert newtons(runs[case]) in [text.get_text() for text in axes.texts]
    assert "running mean over 0.2 mm, 5 runs" in words_shown(figure)
    assert "averaging window, 1 mm to 5 mm" in words_shown(figure)


def test_figure_08_compares_the_ellipse_code_with_the_disc_code():
    """Of pairs of runs, over the mean of the disc code; the paper gives means and standard deviations."""
    data = cases()
    runs, x = runs_of(data), 1e3 * data["displacement"].values
    figure = import_module("dem.figures.figure08").plot(data)
    left, right = figure.axes
    expected = []
    for place, (case, paper, share) in enumerate([("c1", 1295.0, 0.18), ("e0", 1405.0, 0.17)]):
        mean, half = running(data, case)
        for curve in (mean, mean - half, mean + half):
            assert_curve(left, x, curve)
        mean, half = mean_of(runs[case])
        expected.append([place - 0.18, mean, mean - half, mean + half])
        expected.append([place + 0.25, paper, paper * (1.0 - share), paper * (1.0 + share)])
        assert set(runs[case]) <= set(places_shown(right)[:, 1])
        tick = right.get_xticklabels()[place].get_text()
        assert newtons(runs[case]) in tick and f"paper: {paper:.0f} N" in tick
        assert f"code ({case}), mean of 5 runs" in words_shown(figure)
        assert tick.startswith("ellipse" if case == "e0" else "disc")
    assert_intervals(right, expected)
    words = right.get_xlabel().replace("\N{MINUS SIGN}", "-")
    assert words == f"e0 against c1: {change(runs['c1'], runs['e0'])}"


def test_figure_13_shows_the_mean_of_each_case_with_its_runs():
    data = cases()
    runs = runs_of(data)
    figure = import_module("dem.figures.figure13").plot(data)
    (axes,) = figure.axes
    shown = {case: runs[case] for case in ("c1", "d1", "c2", "e1", "e2", "e3")}
    means = [mean_of(sample) for sample in shown.values()]
    assert_allclose(bars_shown(axes), [[k, mean] for k, (mean, _) in enumerate(means)])
    assert_intervals(axes, [[k, m, m - h, m + h] for k, (m, h) in enumerate(means)])
    ticks = [text.get_text().partition("\n")[0] for text in axes.get_xticklabels()]
    assert ticks == list(shown)
    for place, (case, sample) in enumerate(shown.items()):
        (note,) = (text for text in axes.texts if text.get_text() == newtons(sample))
        assert note.xy == (place, pytest.approx(max(sample.max(), sum(mean_of(runs[case])))))
        assert set(sample) <= set(places_shown(axes)[:, 1])
    assert "mean of 5 runs" in words_shown(figure) and "paper, 1295 N" in words_shown(figure)


def test_figure_14_shows_the_change_with_density_over_the_lowest():
    """Of the runs that both densities have."""
    data = cases()
    runs = runs_of(data)
    figure = import_module("dem.figures.figure14").plot(data)
    (axes,) = figure.axes
    groups = [("c1", "c12"), ("d1", "d12"), ("c2", "c22"), ("e1", "e12")]
    bars, intervals = [], []
    for place, group in enumerate(groups):
        for side, case in zip((-0.2, 0.2), group, strict=True):
            mean, half = mean_of(runs[case])
            bars.append([place + side, mean])
            intervals.append([place + side, mean, mean - half, mean + half])
        (note,) = (text for text in axes.texts if round(text.xy[0]) == place)
        words = note.get_text().replace("\N{MINUS SIGN}", "-")
        assert words == change(*(runs[case] for case in group))
    assert_allclose(bars_shown(axes), sorted(bars))
    assert_intervals(axes, intervals)
    words = words_shown(figure)
    assert "mean of 5 runs at 3 900 kg/m³" in words
    assert "mean of 4 to 5 runs at 39 000 kg/m³" in words and "paper: at most 21.8 %" in words


# Figures 9 to 12: beds

BEDS = {
    "figure09": ("cluster", ["c1", "d1", "c2"]),
    "figure10": ("layer", ["c1", "d1", "c2"]),
    "figure11": ("cluster", ["e1", "e2", "e3"]),
    "figure12": ("layer", ["e1", "e2", "e3"]),
}


@pytest.mark.parametrize("name", BEDS)
def test_beds_are_drawn_where_the_file_has_them(name):
    """At the start, halfway and at the end; shaded are those ahead of the cylinder, or every second layer of
    eight, where granules began."""
    colors, names = BEDS[name]
    with xr.open_dataset(ROOT / "docs/data/snapshots.nc") as data:
        data = data.load()
    figure = import_module(f"dem.figures.{name}").plot(data)
    grid = np.reshape(figure.axes, (3, 3))
    for row, case in zip(grid, names, strict=True):
        one = data.isel(seed=0).sel(case=case).dropna("granule", subset=["granule_diameter"])
        start, size = one.isel(snapshot=0), one["granule_diameter"].values
        x, y = 1e3 * start["granule_x"].values, 1e3 * start["granule_y"].values
        if colors == "layer":
            dark = np.floor(8.0 * y / (1e3 * float(one["box_height"]))) % 2 == 1
        else:
            above, wide = y - 1e3 * float(start["cylinder_y"]), 3.175
            dark = (np.abs(x - 10.0) < 0.5 * wide) & (above > 0.0) & (above < 2.0 * wide)
        for axes, k in zip(row, (0, 30, 60), strict=True):
            paths = [path.vertices[:-1] for path in axes.collections[0].get_paths()]
            place = np.array([0.5 * (p.min(axis=0) + p.max(axis=0)) for p in paths])
            at = one.isel(snapshot=k)
            expected = 1e3 * np.column_stack([at["granule_x"], at["granule_y"]])
            assert_allclose(place, expected, atol=0.03)
            extent = np.array([np.ptp(p, axis=0).prod() for p in paths]) * 1e-6
            assert (extent > 0.9 * size**2).all() and (extent < 3.0 * size**2).all()
            shade = axes.collections[0].get_facecolor()[:, :3].mean(axis=1)
            assert_allclose(shade < 0.8, dark)
            (ring,) = (path.vertices for path in axes.collections[2].get_paths())
            middle = 0.5 * (ring.min(axis=0) + ring.max(axis=0))
            assert_allclose(middle, [10.0, 1e3 * float(at["cylinder_y"])], atol=1e-6)
        (label,) = (text.get_text() for text in row[0].texts if case in text.get_text())
        height = 1e3 * float(one["box_height"])
        assert (
            label.startswith(f"{case}: ")
            and "box 20 mm" in label
            and label.endswith(f"{height:.3g} mm")
        )
    titles = [axes.get_title() for axes in grid[0]]
    assert titles == ["at the start", "after 3.0 mm", "after 6.0 mm"]
    assert f"seed {int(data['seed'][0])}" in figure.get_suptitle()


@pytest.mark.parametrize(("kind", "note"), [("disc", False), ("pebbles.Pebble", True)])
def test_a_picture_says_where_outlines_are_not_those_of_the_granules(kind, note):
    """No reader of results runs the file of a shape of one's own, so that its granules are drawn as discs."""
    with xr.open_dataset(ROOT / "docs/data/snapshots.nc") as beds:
        beds = beds.sel(case=["c1"]).load()
    beds["kind"] = ("case", np.array([kind], object))
    words = words_shown(import_module("dem.figures.figure09").plot(beds))
    assert (", drawn as discs of equal area" in words) == note and f"c1: {kind}" in words


# Figures over what was varied


def varied(**axes):
    """Drag of a sweep over axes and four seeds, one of which failed once, with names and units."""
    shape = [*(len(values) for values in axes.values()), 4]
    drag = np.random.default_rng(3).uniform(50.0, 150.0, shape)
    drag[(0,) * len(axes) + (2,)] = np.nan
    data = dataset_of(drag, {name: np.array(values) for name, values in axes.items()})
    data["drag"].attrs |= {"units": "N", "long_name": "drag: force on the cylinder"}
    attrs = {
        "friction_granule": ("friction between granules", "1"),
        "gravity": ("gravity", "m s-2"),
    }
    for name, (words, units) in attrs.items():
        if name in data:
            data[name].attrs |= {"long_name": words, "units": units}
    return data, drag


@pytest.mark.parametrize("turned", [False, True])
def test_a_sweep_shows_every_mean_at_its_value(turned):
    """A line for each shape, a panel for each gravity, in the order of the axis, however they are written."""
    friction = [0.3, 0.1, 0.2] if turned else [0.1, 0.2, 0.3]
    data, drag = varied(shape=["c1", "d1"], friction_granule=friction, gravity=[10.0, 20.0])
    figure = import_module("dem.figures.sweep").plot(data)
    order = np.argsort(friction)
    for panel, axes in enumerate(figure.axes):
        expected = []
        for line in range(2):
            for place, value in zip(order, (0.1, 0.2, 0.3), strict=True):
                mean, half = mean_of(drag[line, place, panel])
                x = value + (line - 0.5) * 0.012 * 0.2
                expected.append([x, mean, mean - half, mean + half])
        assert_intervals(axes, expected)
        assert axes.get_title(loc="left") == f"gravity: {10 + 10 * panel} m s$^{{-2}}$".replace(
            " s", "\N{NO-BREAK SPACE}s"
        )
        low, high = axes.get_ylim()
        assert low <= np.min(expected) and np.max(np.array(expected)[:, 1:]) <= high
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["shape: c1", "shape: d1"]
    labels = {axes.get_xlabel() for axes in figure.axes} - {""}
    assert labels == {"Friction between granules (1)"}
    assert figure.axes[0].get_ylabel().endswith("from\n0.5 mm to 3.5 mm (N)")
    assert "(3 to 4 runs each; bars: 95 % intervals)" in figure.get_suptitle()


def test_a_sweep_over_more_than_there_is_room_for_shows_means_over_an_axis():
    """Which it names."""
    axes = {"friction_granule": [0.1, 0.2, 0.3], "gravity": [1.0, 2.0]}
    axes |= {name: [f"{name} {k}" for k in range(2)] for name in ("box", "wall", "lid")}
    data, drag = varied(**axes)
    figure = import_module("dem.figures.sweep").plot(data)
    shown = np.concatenate([intervals_shown(panel)[:, 1] for panel in figure.axes])
    left_out = figure.get_suptitle().partition("averaged over ")[2].rstrip(")")
    means = np.nanmean(drag, axis=-1).mean(axis=list(axes).index(left_out))
    assert len(figure.axes) <= 12
    assert_allclose(np.sort(shown), np.sort(means.ravel()))


@pytest.mark.parametrize("words", [12, 1])
def test_words_of_a_figure_stay_in_it_however_long_they_are(words):
    data, _ = varied(shape=["c1", "d1"], friction_granule=[0.1, 0.3], gravity=[10.0, 20.0])
    data["drag"].attrs["long_name"] = " ".join(words * ["force of many words"])
    figure = import_module("dem.figures.sweep").plot(data)
    figure.draw_without_rendering()
    for text in [*figure.texts, *(axes.yaxis.label for axes in figure.axes)]:
        box = text.get_window_extent()
        assert box.y0 >= 0.0 and box.y1 <= figure.bbox.height and box.x1 <= figure.bbox.width, text


@pytest.mark.parametrize(
    ("values", "logarithmic"),
    [
        ([0.5, 1.0, 2.0], False),
        ([1.0, 2.0, 5.0, 10.0], True),
        ([0.0, 0.1, 1.0], False),
        ([1.0, 5.0], False),
        ([1.0, 5.1], True),
    ],
)
def test_a_list_over_more_than_the_fivefold_has_a_logarithmic_axis(values, logarithmic):
    assert is_logarithmic(np.array(values)) == logarithmic
    data, _ = varied(friction_granule=values)
    (axes,) = import_module("dem.figures.sweep").plot(data).axes
    assert axes.get_xscale() == ("log" if logarithmic else "linear")


def test_figure_velocity_shows_means_limits_and_their_ratio():
    """The limit in the legend is where the dotted line is, and what the lower panel is over."""
    speed, rng = np.array([8.0, 0.1, 0.5, 1.0, 2.0]), np.random.default_rng(1)
    law = np.array([500.0, 900.0])[:, None, None] * (1.0 + 0.04 * speed[:, None])
    drag = law * rng.uniform(0.95, 1.05, (2, 5, 6))
    runs = dataset_of(drag, {"friction": ["0", "1"], AXIS: speed})
    runs = runs.assign(packing_pressure=(runs["run_id"].dims, np.full(drag.shape, 1e7)))
    values = {"cylinder": {"diameter": 3e-3, "velocity": 2.0}}
    runs = runs.assign_attrs(configuration=json.dumps(values))
    runs = runs.assign_coords(diameter=1e-3, density=4000.0)
    figure = import_module("dem.figures.velocity").plot(runs)
    above, below = figure.axes[:2]
    found, order = rates(runs), np.argsort(speed)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    expected = {above: [], below: []}
    for place, words in zip((0, 1), labels, strict=True):
        law = found.laws[(str(place),)]
        limit, low, high = found.interval(law.limit)
        assert words == f"friction {place}: limit {limit:.0f} N ({low:.0f} to {high:.0f})"
        assert limit == pytest.approx((500.0, 900.0)[place], rel=0.05)
        assert limit in [line.get_ydata()[0] for line in above.lines]
        for axes, over in ((above, 1.0), (below, limit)):
            means = drag[place, order].mean(axis=1) / over
            for column, (v, mean) in enumerate(zip(speed[order], means, strict=True)):
                interval = found.interval(found.means[(str(place),)][:, column] / over)
                expected[axes].append([v, mean, interval.low, interval.high])
    for axes in (above, below):
        assert_intervals(axes, expected[axes])
    assert "means of 6 beds" in figure.get_suptitle()
    assert "grey line: 2 m/s" in figure.get_suptitle()
    top = above.child_axes[0]
    number = 1e-3 / 3e-3 * np.sqrt(4000.0 / 1e7)  # at 1 m/s
    assert top.get_xlabel() == "Inertial number"
    figure.draw_without_rendering()
    assert_allclose(top.get_xlim(), number * np.array(above.get_xlim()), rtol=1e-6)


@pytest.mark.parametrize("sizes", [(200, 50, 100), tuple(50 * 2**k for k in range(9))])
def test_figure_onset_shows_the_means_of_each_size_and_the_limit(sizes):
    """Each size in a look of its own, larger ones to the right; the limit at its aspect ratio."""
    rng, n = np.random.default_rng(1), np.array(sizes)[:, None]
    dims, shape = ("ratio", "size", "seed"), (2, len(sizes), 4)
    fraction = 0.84 - 0.05 * n**-0.5 + 1e-3 * rng.standard_normal(shape)
    contacts, rattlers = 2.0 * n + rng.uniform(0.0, 1.0, shape), rng.integers(0, 4, shape)
    data = xr.Dataset(
        {
            "onset_fraction": (dims, fraction),
            "onset_contacts": (dims, contacts),
            "onset_rattlers": (dims, rattlers),
            "run_id": (dims, np.full(shape, "x")),
        },
        {
            "granules": ("size", list(sizes)),
            "aspect_ratio": ("ratio", [1.5, 1.0]),
            "seed": range(4),
        },
    )
    figure = import_module("dem.figures.onset").plot(data)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [*(f"{size} granules" for size in sorted(sizes)), "infinitely many"]
    found, each = limits(data), 2.0 * contacts / (n - rattlers)
    for axes, values, estimates in zip(
        figure.axes, (fraction, each), (found.fraction, found.coordination), strict=True
    ):
        lines = {line.get_label(): line for line in axes.lines if "granules" in line.get_label()}
        for k, size in enumerate(sizes):
            line = lines[f"{size} granules"]
            assert_allclose(line.get_ydata(), values[:, k].mean(axis=-1))
            assert (np.abs(line.get_xdata() - [1.5, 1.0]) < 0.25).all()
        looks = {(line.get_marker(), line.get_markerfacecolor()) for line in lines.values()}
        assert len(looks) == len(sizes)
        rows = [[x, *estimate] for x, estimate in zip([1.5, 1.0], estimates, strict=True)]
        assert_intervals(axes, rows)
    assert "means of 4 beds of each size" in figure.get_suptitle()


def test_figure_shear_shows_the_friction_of_the_lid_and_the_packing_fraction():
    """Against the inertial number in the middle, one curve a place, with intervals over runs."""
    rng, dims = np.random.default_rng(2), ("friction", "shear_inertial_number", "seed")
    shape, pressure = (2, 2, 4), 6e7
    number = np.array([0.1, 0.01])
    values = {
        "lid_shear_stress": pressure * rng.uniform(0.2, 0.4, shape),
        "lid_normal_stress": pressure * rng.uniform(0.9, 1.1, shape),
        "shear_stress": pressure * rng.uniform(0.5, 0.6, shape),
        "normal_stress": pressure * rng.uniform(0.9, 1.1, shape),
        "shear_rate": 1e4 * number[:, None] * rng.uniform(0.9, 1.1, shape),
        "shear_fraction": rng.uniform(0.7, 0.8, shape),
    }
    data = xr.Dataset(
        {
            name: ((*dims, "shear_strain"), value[..., None] * [0.9, 1.1])
            for name, value in values.items()
        }
        | {"run_id": (dims, np.full(shape, "x"))},
        {
            "friction": ["0", "1"],
            "shear_inertial_number": number,
            "seed": range(4),
            "shear_strain": [0.1, 0.2],
            "diameter": 1e-3,
            "density": 2500.0,
        },
        {"configuration": json.dumps({"shear": {"pressure": pressure}})},
    )
    figure = import_module("dem.figures.shear").plot(data)
    area = 0.25 * np.pi * 1e-6
    measured = values["shear_rate"] * np.sqrt(2500.0 * area / values["normal_stress"])
    shown = values["lid_shear_stress"] / values["lid_normal_stress"], values["shear_fraction"]
    for axes, runs in zip(figure.axes, shown, strict=True):
        expected = []
        for place in np.ndindex(2, 2):
            mean, half = mean_of(runs[place])
            expected.append([measured[place].mean(), mean, mean - half, mean + half])
        assert_intervals(axes, expected)
        assert axes.get_xscale() == "log"
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["friction 0", "friction 1"]


def test_each_figure_is_asked_for_here():
    asked = {"figure07", "figure08", "figure13", "figure14", *BEDS}
    assert {*FIGURES} == asked | {"sweep", "velocity", "onset", "shear"}
