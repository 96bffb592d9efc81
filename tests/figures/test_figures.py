"""What each figure of dem/figures shows is what its file holds: marks, intervals, words."""

import re
from functools import cache
from importlib import import_module

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from pictures import boxes_shown, intervals_shown, places_shown, words_shown
from project import ROOT, quick
from sweeps import dataset_of
from synthetic import DENSITY, VELOCITY, drags, drawn, jammed, sheared

from dem.analysis.onset import limits
from dem.analysis.velocity import rates
from dem.base.statistics import mean_interval


def plot(name, data):
    return import_module(f"dem.figures.{name}").plot(data)


def row(x, runs):
    """An error bar: x, value, low, high."""
    return [x, *mean_interval(runs)]


def newtons(runs):
    mean = mean_interval(runs)
    return f"{mean.value:.0f} ± {mean.half:.0f} N"


def change(before, after):
    """Of runs in pairs, over the mean of those before, in words."""
    pairs = np.isfinite(before + after)
    mean = mean_interval(100.0 * (after - before)[pairs] / before[pairs].mean())
    return f"{mean.value:+.1f} ± {mean.half:.1f} %"


@cache
def cases():
    """The released file of the paper's sweep, with runs of other means; one run failed. Then the means (seed,)
    within the window of each case."""
    data = xr.load_dataset(ROOT / "docs/data/drag.nc")
    level = np.random.default_rng(1).uniform(0.5, 2.0, (11, 5))
    level[-3, 1] = np.nan  # one of d12
    data["drag"] *= xr.DataArray(level, dims=("case", "seed"))
    runs = data["drag"].sel(displacement=slice(1e-3, 5e-3)).mean("displacement", skipna=False)
    runs = dict(zip(data["case"].values, runs.values, strict=True))
    return data.assign_attrs(window_start=1e-3, window_stop=5e-3), runs


def assert_shown(axes, expected):
    """These error bars (k, 4) are on an axes, whole, and no others."""
    expected = np.array(sorted(expected))
    assert_allclose(intervals_shown(axes), expected, rtol=1e-6, atol=1e-9)
    low, high = axes.get_ylim()
    assert low <= expected[:, 1:].min() and expected[:, 1:].max() <= high


SHAPES = "c1", "d1", "c2", "e1", "e2", "e3"
CURVES = {
    "figure07": (SHAPES, ["running mean over 0.2 mm, 5 runs", "averaging window, 1 mm to 5 mm"]),
    "figure08": (("c1", "e0"), ["code (c1), mean of 5 runs", "code (e0), mean of 5 runs"]),
}


@quick
@pytest.mark.parametrize("name", CURVES)
def test_curves_are_running_means_with_their_intervals(name):
    """Over a fifth of a millimetre; those of the first case are beside all others."""
    (data, runs), (shown, words) = cases(), CURVES[name]
    figure, x = plot(name, data), data["displacement"].values
    near, first = np.abs(x[:, None] - x) < 1e-4 + 1e-6, None
    panels = figure.axes if name == "figure07" else 2 * figure.axes[:1]
    for axes, case in zip(panels, shown, strict=True):
        near_by = data["drag"].sel(case=case).values @ near / near.sum(axis=0)
        mean, *ends = np.transpose([*map(mean_interval, near_by.T)])
        first = mean if first is None else first
        for curve in (mean, *ends, first):
            away = np.abs(places_shown(axes)[:, None] - np.column_stack([1e3 * x, curve])[::60])
            assert (away < [1e-6, 1e-6 * curve.max()]).all(axis=2).any(axis=0).all()
        if name == "figure07":
            assert axes.get_title().startswith(f"{case}: ")
            assert newtons(runs[case]) in [text.get_text() for text in axes.texts]
    assert all(word in words_shown(figure) for word in words)


# figure: place of each case, words
PLACES = {
    "figure08": ({"c1": -0.18, "e0": 0.82}, ["paper: 1295 N", "paper: 1405 N"]),
    "figure13": (
        {case: place for place, case in enumerate(SHAPES)},
        ["mean of 5 runs", "paper, 1295 N"],
    ),
    "figure14": (
        {
            f"{case}{end}": k + x
            for k, case in enumerate(SHAPES[:4])
            for end, x in (("", -0.2), ("2", 0.2))
        },
        [
            "mean of 5 runs at 3 900 kg/m³",
            "mean of 4 to 5 runs at 39 000 kg/m³",
            "paper: at most 21.8 %",
        ],
    ),
}


@quick
@pytest.mark.parametrize("name", PLACES)
def test_the_mean_of_each_case_is_shown_at_its_place(name):
    """As a bar or mark with its interval, and in words; changes are of pairs of runs, over the lower density or
    the disc code. The paper gives means and standard deviations."""
    data, runs = cases()
    figure, (places, words) = plot(name, data), PLACES[name]
    axes, rows = figure.axes[-1], [row(x, runs[case]) for case, x in places.items()]
    at = [label.get_text() for label in axes.get_xticklabels()]
    for note in axes.texts:
        at[round(note.xy[0])] += note.get_text().replace("\N{MINUS SIGN}", "-")
    for case, x in places.items():
        named, said = case[:2], newtons(runs[case])
        if name == "figure08":
            named = data["kind"].sel(case=case).item()
        if name == "figure14":
            said = change(runs[named], runs[f"{named}2"])
        assert named in at[round(x)] and said in at[round(x)]
        there = runs[case][np.isfinite(runs[case])]
        assert np.isclose(places_shown(axes)[:, 1:], there).any(axis=0).all()
    if name == "figure08":
        rows += [[0.25, 1295.0, 1061.9, 1528.1], [1.25, 1405.0, 1166.15, 1643.85]]
        words = [*words, f"e0 against c1: {change(runs['c1'], runs['e0'])}"]
    else:
        bars = [[bar.get_center()[0], bar.get_height()] for bar in axes.patches]
        assert_allclose(bars, [bar[:2] for bar in rows])
    assert_shown(axes, rows)
    assert all(word in words_shown(figure) for word in words)


# Figures 9 to 12: beds

BEDS = {
    "figure09": ("cluster", SHAPES[:3]),
    "figure10": ("layer", SHAPES[:3]),
    "figure11": ("cluster", SHAPES[3:]),
    "figure12": ("layer", SHAPES[3:]),
}


@quick
@pytest.mark.parametrize("name", BEDS)
def test_beds_are_drawn_where_the_file_has_them(name):
    """At the start, halfway and at the end; shaded are those ahead of the cylinder, or every second layer of
    eight, where granules began."""
    colors, names = BEDS[name]
    data = xr.load_dataset(ROOT / "docs/data/snapshots.nc")
    figure, data = plot(name, data), data.isel(seed=0, snapshot=[0, 30, 60])
    panels, words = iter(figure.axes), words_shown(figure)
    for case in names:
        one = data.sel(case=case).dropna("granule", subset=["granule_diameter"])
        height = float(one["box_height"])
        assert re.search(rf"^{case}: .* box 20 mm . {1e3 * height:.3g} mm$", words, re.M)
        places = np.stack([one["granule_x"], one["granule_y"]], axis=-1)
        x, y = places[0].T
        dark = np.floor(8.0 * y / height) % 2 == 1
        if colors == "cluster":
            above, wide = y - float(one["cylinder_y"][0]), 3.175e-3
            dark = (np.abs(x - 0.01) < 0.5 * wide) & (above > 0.0) & (above < 2.0 * wide)
        for place, cylinder in zip(places, one["cylinder_y"].values, strict=True):
            granules, _, ring = next(panels).collections[:3]
            boxes, middle = boxes_shown(granules), boxes_shown(ring).mean(axis=1)
            assert_allclose(boxes.mean(axis=1), 1e3 * place, atol=0.03)
            extent = 1e-6 * np.ptp(boxes, axis=1).prod(axis=1) / one["granule_diameter"] ** 2
            assert ((extent > 0.9) & (extent < 3.0)).all()
            assert_allclose(granules.get_facecolor()[:, :3].mean(axis=1) < 0.8, dark)
            assert_allclose(middle, [[10.0, 1e3 * cylinder]], atol=1e-6)
    titles = [axes.get_title() for axes in figure.axes[:3]]
    assert titles == ["at the start", "after 3.0 mm", "after 6.0 mm"]
    assert f"seed {int(data['seed'])}" in words


def test_a_picture_says_where_outlines_are_not_those_of_the_granules():
    """No reader of results runs the file of a shape of one's own, so that its granules are drawn as discs."""
    beds = xr.load_dataset(ROOT / "docs/data/snapshots.nc").sel(case=["c1", "c2"])
    beds["kind"] = "case", np.array(["pebbles.Pebble", "disc"], object)
    words = words_shown(plot("figure09", beds))
    assert "c1: pebbles.Pebble" in words and words.count(", drawn as discs of equal area") == 1


# Figures over what was varied


def varied(**axes):
    """Drag of a sweep over axes and four seeds, one of which failed once, with names and units."""
    drag = np.random.default_rng(3).uniform(50.0, 150.0, (*map(len, axes.values()), 4))
    drag[(0,) * len(axes) + (2,)] = np.nan
    data = dataset_of(drag, axes)
    data["drag"].attrs |= {"units": "N", "long_name": "drag: force on the cylinder"}
    friction = {"units": "1", "long_name": "friction between granules"}
    for name, attrs in {"friction_granule": friction, "gravity": {"units": "m s-2"}}.items():
        if name in data:
            data[name].attrs |= attrs
    return data, drag


@quick
def test_a_sweep_shows_every_mean_at_its_value():
    """A line for each shape, a panel for each gravity, in the order of the axis, however they are written."""
    friction = [0.3, 0.1, 0.2]
    data, drag = varied(shape=["c1", "d1"], friction_granule=friction, gravity=[10.0, 20.0])
    figure = plot("sweep", data)
    for panel, axes in enumerate(figure.axes):
        at = np.ndindex(2, 3)
        rows = [
            row(friction[k] + (line - 0.5) * 0.012 * 0.2, drag[line, k, panel]) for line, k in at
        ]
        assert_shown(axes, rows)
        title = " ".join(axes.get_title(loc="left").split())
        assert title == f"gravity: {10 + 10 * panel} m s$^{{-2}}$"
    words = words_shown(figure).splitlines()
    assert {"shape: c1", "shape: d1", "Friction between granules (1)"} <= {*words}
    assert figure.axes[0].get_ylabel().endswith("from\n0.5 mm to 3.5 mm (N)")
    assert "(3 to 4 runs each; bars: 95 % intervals)" in figure.get_suptitle()


def test_twelve_cases_have_twelve_looks():
    data, _ = varied(shape=[f"s{k}" for k in range(12)], friction_granule=[0.1, 0.3])
    lines = [container.lines[0] for container in plot("sweep", data).axes[0].containers]
    assert len({(line.get_color(), line.get_marker()) for line in lines}) == 12


@quick
def test_a_sweep_over_more_than_there_is_room_for_shows_means_over_an_axis():
    """Which it names."""
    axes = {"friction_granule": [0.1, 0.2, 0.3], "gravity": [1.0, 2.0]}
    axes |= {name: ["one", "two"] for name in ("box", "wall", "lid")}
    data, drag = varied(**axes)
    figure = plot("sweep", data)
    shown = np.concatenate([intervals_shown(panel)[:, 1] for panel in figure.axes])
    left_out = figure.get_suptitle().partition("averaged over ")[2].rstrip(")")
    means = np.nanmean(drag, axis=-1).mean(axis=list(axes).index(left_out))
    assert len(figure.axes) <= 12
    assert_allclose(np.sort(shown), np.sort(means.ravel()))


def test_words_of_a_figure_stay_in_it_however_long_they_are():
    data, _ = varied(shape=["c1", "d1"], friction_granule=[0.1, 0.3], gravity=[10.0, 20.0])
    data["drag"].attrs["long_name"] = 12 * "force of many words "
    figure = plot("sweep", data)
    figure.draw_without_rendering()
    for text in [*figure.texts, *(axes.yaxis.label for axes in figure.axes)]:
        box = text.get_window_extent()
        assert box.y0 >= 0.0 and box.y1 <= figure.bbox.height and box.x1 <= figure.bbox.width, text


@quick
@pytest.mark.parametrize(
    ("values", "scale"), [([0.0, 1.0, 9.0], "linear"), ([1.0, 5.0], "linear"), ([1.0, 5.1], "log")]
)
def test_a_list_over_more_than_the_fivefold_has_a_logarithmic_axis(values, scale):
    (axes,) = plot("sweep", varied(friction_granule=values)[0]).axes
    assert axes.get_xscale() == scale
    assert_allclose(intervals_shown(axes)[:, 0], values)


# Figures of what a law is fitted to


def test_figure_velocity_shows_means_limits_and_their_ratio():
    """The limit in the legend is where the dotted line is, and what the lower panel is over."""
    drag = np.array([drags(500.0, 20.0, 1.0), drags(900.0, 40.0, 1.0, seed=2)])
    runs = drawn(drag).isel(cylinder_velocity=[6, 0, 3, 1, 2, 5, 4])
    figure, found = plot("velocity", runs), rates(runs)
    (above, below), legend, rows = figure.axes, figure.legends[0].get_texts(), ([], [])
    for (place,), means in found.means.items():
        limit = found.interval(found.laws[(place,)].limit)
        words = "friction {}: limit {:.0f} N ({:.0f} to {:.0f})".format(place, *limit)
        assert legend[int(place)].get_text() == words
        assert limit.value in [line.get_ydata()[0] for line in above.lines]
        for panel, over in zip(rows, (1.0, limit.value), strict=True):
            for k, speed in enumerate(VELOCITY):
                _, *ends = found.interval(means[:, k] / over)
                panel.append([speed, drag[int(place), k].mean() / over, *ends])
    assert_shown(above, rows[0])
    assert_shown(below, rows[1])
    title = figure.get_suptitle()
    assert "means of 6 beds" in title and "grey line: 2 m/s" in title
    figure.draw_without_rendering()
    (top,) = above.child_axes
    assert top.get_xlabel() == "Inertial number"
    assert_allclose(top.get_xlim(), 0.02 / 3.0 * np.array(above.get_xlim()))  # that at 1 m/s


@quick
@pytest.mark.parametrize("sizes", [(200, 50, 100), tuple(50 * 2**k for k in range(9))])
def test_figure_onset_shows_the_means_of_each_size_and_the_limit(sizes):
    """Each size in a look of its own; the limit at its aspect ratio."""
    data = jammed(sizes).isel(ratio=[1, 0])
    figure, found = plot("onset", data), limits(data)
    names = [f"{size} granules" for size in sizes]
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [f"{size} granules" for size in sorted(sizes)] + ["infinitely many"]
    means = data["onset_fraction"].mean("seed").values[0], 4.0 - 2.0 / np.array([sizes, sizes])
    estimates = found.fraction, found.coordination
    for axes, values, (one, other) in zip(figure.axes, means, estimates, strict=True):
        lines = {line.get_label(): line for line in axes.lines}
        lines = [lines[name] for name in names]
        assert_allclose([line.get_ydata() for line in lines], values.T)
        assert all((np.abs(line.get_xdata() - [1.5, 1.0]) < 0.25).all() for line in lines)
        looks = {(line.get_marker(), line.get_markerfacecolor()) for line in lines}
        assert len(looks) == len(sizes)
        assert_shown(axes, [[1.5, *one], [1.0, *other]])
    assert "means of 4 beds of each size" in figure.get_suptitle()


@quick
def test_figure_shear_shows_the_friction_of_the_lid_and_the_packing_fraction():
    """Against the inertial number in the middle, one curve a place, with intervals over runs."""
    data = sheared([[0.2, 0.3], [0.3, 0.4]], seeds=4)
    data["shear_stress"] *= 1.2  # in the middle
    figure, runs = plot("shear", data), data.mean("shear_strain")
    mass = DENSITY * 0.25 * np.pi * 1e-6
    number = (runs["shear_rate"] * np.sqrt(mass / runs["normal_stress"])).mean("seed").values
    shown = runs["lid_shear_stress"] / runs["lid_normal_stress"], runs["shear_fraction"]
    for axes, values in zip(figure.axes, shown, strict=True):
        at = np.ndindex(2, 2)
        assert_shown(axes, [row(number[place], values.values[place]) for place in at])
        assert axes.get_xscale() == "log"
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["friction 0", "friction 1"]
