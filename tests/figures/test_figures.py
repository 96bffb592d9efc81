"""What each figure of dem/figures shows is what its file holds: marks, intervals, words."""

import json
from functools import cache
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

quick = pytest.mark.quick


def plot(name, data):
    return import_module(f"dem.figures.{name}").plot(data)


def mean_of(runs):
    """Mean and half its interval by Student's t, of runs (seed, ...) that there are."""
    runs = runs[np.isfinite(runs).all(axis=tuple(range(1, runs.ndim)))]
    return runs.mean(axis=0), stats.t.ppf(0.975, len(runs) - 1) * stats.sem(runs)


def row(x, runs):
    """An error bar: x, value, low, high."""
    mean, half = mean_of(runs)
    return [x, mean, mean - half, mean + half]


def newtons(runs):
    return "{:.0f} ± {:.0f} N".format(*mean_of(runs))


def change(before, after):
    """Of runs in pairs, over the mean of those before, in words."""
    pairs = np.isfinite(before + after)
    share = 100.0 * (after - before)[pairs] / before[pairs].mean()
    return "{:+.1f} ± {:.1f} %".format(*mean_of(share))


@cache
def cases():
    """The released file of the paper's sweep, with runs of other means; one run failed. Then the means (seed,)
    within the window of each case."""
    with xr.open_dataset(ROOT / "docs/data/drag.nc") as data:
        data = data[["drag", "run_id", "displacement_bounds", "time_step"]].load()
    level = np.random.default_rng(1).uniform(0.5, 2.0, (11, 5))
    level[-3, 1] = np.nan  # one of d12
    data["drag"] = data["drag"] * xr.DataArray(level, dims=("case", "seed"))
    runs = data["drag"].sel(displacement=slice(1e-3, 5e-3)).mean("displacement", skipna=False)
    runs = {str(case): runs.sel(case=case).values for case in data["case"].values}
    return data.assign_attrs(window_start=1e-3, window_stop=5e-3), runs


def assert_intervals(axes, expected):
    """These error bars (k, 4) are on an axes, and no others."""
    assert_allclose(intervals_shown(axes), np.array(sorted(expected)), rtol=1e-6, atol=1e-9)


CURVES = {
    "figure07": ["running mean over 0.2 mm, 5 runs", "averaging window, 1 mm to 5 mm"],
    "figure08": ["code (c1), mean of 5 runs", "code (e0), mean of 5 runs"],
}
SHAPES = "c1", "d1", "c2", "e1"
DENSITIES = ("", -0.2), ("2", 0.2)


@quick
@pytest.mark.parametrize("name", CURVES)
def test_curves_are_running_means_with_their_intervals(name):
    """Over a fifth of a millimetre; those of the first case are beside all others."""
    data, runs = cases()
    figure, x = plot(name, data), data["displacement"].values
    near = np.abs(x[:, None] - x) < 1e-4 + 1e-6
    first, apart = None, name == "figure07"
    for place, case in enumerate([*SHAPES[:3], "e1", "e2", "e3"] if apart else ["c1", "e0"]):
        axes = figure.axes[place * apart]
        mean, half = mean_of(data["drag"].sel(case=case).values @ near / near.sum(axis=0))
        first = mean if first is None else first
        for curve in (mean, mean - half, mean + half, first):
            away = np.abs(places_shown(axes)[:, None] - np.column_stack([1e3 * x, curve])[::60])
            assert (away < [1e-6, 1e-6 * curve.max()]).all(axis=2).any(axis=0).all()
        if apart:
            assert axes.get_title().startswith(f"{case}: ")
            assert newtons(runs[case]) in [text.get_text() for text in axes.texts]
    assert all(words in words_shown(figure) for words in CURVES[name])


# figure: place of each case, words
PLACES = {
    "figure08": (
        {"c1": -0.18, "e0": 0.82},
        ["paper: 1295 N", "paper: 1405 N"],
    ),
    "figure13": (
        {case: place for place, case in enumerate([*SHAPES, "e2", "e3"])},
        ["mean of 5 runs", "paper, 1295 N"],
    ),
    "figure14": (
        {f"{case}{end}": k + x for k, case in enumerate(SHAPES) for end, x in DENSITIES},
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
    if name == "figure08":
        rows += [[0.25, 1295.0, 1061.9, 1528.1], [1.25, 1405.0, 1166.15, 1643.85]]
        words = [*words, f"e0 against c1: {change(runs['c1'], runs['e0'])}"]
    else:
        assert_allclose(bars_shown(axes), [bar[:2] for bar in sorted(rows)])
    assert_intervals(axes, rows)
    assert all(word in words_shown(figure) for word in words)
    at = [label.get_text() for label in axes.get_xticklabels()]
    for note in axes.texts:
        at[round(note.xy[0])] += note.get_text().replace("\N{MINUS SIGN}", "-")
    for case, x in places.items():
        base = case[:2]
        said, code = newtons(runs[case]), {"c1": "disc", "e0": "ellipse"}
        if name == "figure14":
            said = change(runs[base], runs[f"{base}2"])
        assert said in at[round(x)]
        assert (code[case] if name == "figure08" else base) in at[round(x)]
        there = runs[case][np.isfinite(runs[case])]
        assert np.isclose(places_shown(axes)[:, 1:], there).any(axis=0).all()


# Figures 9 to 12: beds

BEDS = {
    "figure09": ("cluster", ["c1", "d1", "c2"]),
    "figure10": ("layer", ["c1", "d1", "c2"]),
    "figure11": ("cluster", ["e1", "e2", "e3"]),
    "figure12": ("layer", ["e1", "e2", "e3"]),
}


def middles(paths):
    """Of the boxes (k, 2) around outlines, and their areas."""
    low, high = (
        np.array([end(path.vertices, axis=0) for path in paths]) for end in (np.min, np.max)
    )
    return 0.5 * (low + high), (high - low).prod(axis=1)


@pytest.mark.parametrize(
    "name", [pytest.param("figure11", marks=quick), *sorted({*BEDS} - {"figure11"})]
)
def test_beds_are_drawn_where_the_file_has_them(name):
    """At the start, halfway and at the end; shaded are those ahead of the cylinder, or every second layer of
    eight, where granules began."""
    colors, names = BEDS[name]
    with xr.open_dataset(ROOT / "docs/data/snapshots.nc") as data:
        data = data.load()
    figure, data = plot(name, data), data.isel(seed=0, snapshot=[0, 30, 60])
    panels = iter(figure.axes)
    for case in names:
        one = data.sel(case=case).dropna("granule", subset=["granule_diameter"])
        height = float(one["box_height"])
        places = np.stack([one["granule_x"], one["granule_y"]], axis=-1)
        x, y = places[0].T
        dark = np.floor(8.0 * y / height) % 2 == 1
        if colors == "cluster":
            above, wide = y - float(one["cylinder_y"][0]), 3.175e-3
            dark = (np.abs(x - 0.01) < 0.5 * wide) & (above > 0.0) & (above < 2.0 * wide)
        for k in range(3):
            axes = next(panels)
            granules, _, ring = axes.collections[:3]
            place, box = middles(granules.get_paths())
            assert_allclose(place, 1e3 * places[k], atol=0.03)
            extent = 1e-6 * box / one["granule_diameter"].values ** 2
            assert (extent > 0.9).all() and (extent < 3.0).all()
            assert_allclose(granules.get_facecolor()[:, :3].mean(axis=1) < 0.8, dark)
            middle, _ = middles(ring.get_paths())
            assert_allclose(middle, [[10.0, 1e3 * float(one["cylinder_y"][k])]], atol=1e-6)
            if k == 0:
                (label,) = (text.get_text() for text in axes.texts if case in text.get_text())
                assert label.startswith(f"{case}: ") and "box 20 mm" in label
                assert label.endswith(f"{1e3 * height:.3g} mm")
    titles = [axes.get_title() for axes in figure.axes[:3]]
    assert titles == ["at the start", "after 3.0 mm", "after 6.0 mm"]
    assert f"seed {int(data['seed'])}" in figure.get_suptitle()


@pytest.mark.parametrize(("kind", "note"), [("disc", False), ("pebbles.Pebble", True)])
def test_a_picture_says_where_outlines_are_not_those_of_the_granules(kind, note):
    """No reader of results runs the file of a shape of one's own, so that its granules are drawn as discs."""
    with xr.open_dataset(ROOT / "docs/data/snapshots.nc") as beds:
        beds = beds.sel(case=["c1"]).load()
    beds["kind"] = ("case", np.array([kind], object))
    words = words_shown(plot("figure09", beds))
    assert (", drawn as discs of equal area" in words) == note and f"c1: {kind}" in words


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
@pytest.mark.parametrize("friction", [[0.1, 0.2, 0.3], [0.3, 0.1, 0.2]])
def test_a_sweep_shows_every_mean_at_its_value(friction):
    """A line for each shape, a panel for each gravity, in the order of the axis, however they are written."""
    data, drag = varied(shape=["c1", "d1"], friction_granule=friction, gravity=[10.0, 20.0])
    figure = plot("sweep", data)
    for panel, axes in enumerate(figure.axes):
        expected = [
            row(value + (line - 0.5) * 0.012 * 0.2, drag[line, place, panel])
            for line in range(2)
            for place, value in enumerate(friction)
        ]
        assert_intervals(axes, expected)
        title = " ".join(axes.get_title(loc="left").split())
        assert title == f"gravity: {10 + 10 * panel} m s$^{{-2}}$"
        low, high = axes.get_ylim()
        assert low <= np.min(expected) and np.max(expected) <= high
    words = words_shown(figure).splitlines()
    assert {"shape: c1", "shape: d1", "Friction between granules (1)"} <= {*words}
    assert figure.axes[0].get_ylabel().endswith("from\n0.5 mm to 3.5 mm (N)")
    assert "(3 to 4 runs each; bars: 95 % intervals)" in figure.get_suptitle()


@quick
def test_a_sweep_over_more_than_there_is_room_for_shows_means_over_an_axis():
    """Which it names."""
    axes = {"friction_granule": [0.1, 0.2, 0.3], "gravity": [1.0, 2.0]}
    axes |= {name: [f"{name} {k}" for k in range(2)] for name in ("box", "wall", "lid")}
    data, drag = varied(**axes)
    figure = plot("sweep", data)
    shown = np.concatenate([intervals_shown(panel)[:, 1] for panel in figure.axes])
    left_out = figure.get_suptitle().partition("averaged over ")[2].rstrip(")")
    means = np.nanmean(drag, axis=-1).mean(axis=list(axes).index(left_out))
    assert len(figure.axes) <= 12
    assert_allclose(np.sort(shown), np.sort(means.ravel()))


@pytest.mark.parametrize("words", [12, 1])
def test_words_of_a_figure_stay_in_it_however_long_they_are(words):
    data, _ = varied(shape=["c1", "d1"], friction_granule=[0.1, 0.3], gravity=[10.0, 20.0])
    data["drag"].attrs["long_name"] = " ".join(words * ["force of many words"])
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


def test_figure_velocity_shows_means_limits_and_their_ratio():
    """The limit in the legend is where the dotted line is, and what the lower panel is over."""
    speed, rng = np.array([8.0, 0.1, 0.5, 1.0, 2.0]), np.random.default_rng(1)
    drag = np.array([500.0, 900.0])[:, None, None] * (1.0 + 0.04 * speed[:, None])
    drag = drag * rng.uniform(0.95, 1.05, (2, 5, 6))
    runs = dataset_of(drag, {"friction": ["0", "1"], AXIS: speed})
    runs["packing_pressure"] = runs["run_id"].dims, np.full(drag.shape, 1e7)
    values = {"cylinder": {"diameter": 3e-3, "velocity": 2.0}}
    runs = runs.assign_attrs(configuration=json.dumps(values))
    runs = runs.assign_coords(diameter=1e-3, density=4000.0)
    figure = plot("velocity", runs)
    above, below = figure.axes[:2]
    found, order = rates(runs), np.argsort(speed)
    expected, below_that = [], []
    for place, text in enumerate(figure.legends[0].get_texts()[:2]):
        limit, low, high = found.interval(found.laws[(str(place),)].limit)
        words = f"friction {place}: limit {limit:.0f} N ({low:.0f} to {high:.0f})"
        assert text.get_text() == words
        assert limit == pytest.approx((500.0, 900.0)[place], rel=0.05)
        assert limit in [line.get_ydata()[0] for line in above.lines]
        for rows, over in ((expected, 1.0), (below_that, limit)):
            for column, k in enumerate(order):
                interval = found.interval(found.means[(str(place),)][:, column] / over)
                mean = drag[place, k].mean() / over
                rows.append([speed[k], mean, interval.low, interval.high])
    assert_intervals(above, expected)
    assert_intervals(below, below_that)
    assert "means of 6 beds" in figure.get_suptitle()
    assert "grey line: 2 m/s" in figure.get_suptitle()
    top = above.child_axes[0]
    number = 1e-3 / 3e-3 * np.sqrt(4000.0 / 1e7)  # at 1 m/s
    assert top.get_xlabel() == "Inertial number"
    figure.draw_without_rendering()
    assert_allclose(top.get_xlim(), number * np.array(above.get_xlim()), rtol=1e-6)


@quick
@pytest.mark.parametrize("sizes", [(200, 50, 100), tuple(50 * 2**k for k in range(9))])
def test_figure_onset_shows_the_means_of_each_size_and_the_limit(sizes):
    """Each size in a look of its own; the limit at its aspect ratio."""
    rng, n = np.random.default_rng(1), np.array(sizes)[:, None]
    dims, shape = ("ratio", "size", "seed"), (2, len(sizes), 4)
    fraction = 0.84 - 0.05 * n**-0.5 + 1e-3 * rng.standard_normal(shape)
    contacts, rattlers = 2.0 * n + rng.uniform(0.0, 1.0, shape), rng.integers(0, 4, shape)
    values = {"fraction": fraction, "contacts": contacts, "rattlers": rattlers}
    data = xr.Dataset(
        {f"onset_{name}": (dims, value) for name, value in values.items()}
        | {"run_id": (dims, np.full(shape, "x"))},
        {"granules": ("size", list(sizes)), "aspect_ratio": ("ratio", [1.5, 1.0])},
    )
    figure = plot("onset", data.assign_coords(seed=range(4)))
    names = [f"{size} granules" for size in sizes]
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [f"{size} granules" for size in sorted(sizes)] + ["infinitely many"]
    found, each = limits(data), 2.0 * contacts / (n - rattlers)
    limit = found.fraction, found.coordination
    for axes, values, estimates in zip(figure.axes, (fraction, each), limit, strict=True):
        lines = {line.get_label(): line for line in axes.lines}
        lines = [lines[name] for name in names]
        assert_allclose([line.get_ydata() for line in lines], values.mean(axis=-1).T)
        assert all((np.abs(line.get_xdata() - [1.5, 1.0]) < 0.25).all() for line in lines)
        looks = {(line.get_marker(), line.get_markerfacecolor()) for line in lines}
        assert len(looks) == len(sizes)
        assert_intervals(axes, [[1.5, *estimates[0]], [1.0, *estimates[1]]])
    assert "means of 4 beds of each size" in figure.get_suptitle()


@quick
def test_figure_shear_shows_the_friction_of_the_lid_and_the_packing_fraction():
    """Against the inertial number in the middle, one curve a place, with intervals over runs."""
    rng, dims = np.random.default_rng(2), ("friction", "shear_inertial_number", "seed")
    number, pressure = np.array([0.1, 0.01]), 6e7
    ranges = {
        "lid_shear_stress": (0.2 * pressure, 0.4 * pressure),
        "lid_normal_stress": (0.9 * pressure, 1.1 * pressure),
        "shear_stress": (0.5 * pressure, 0.6 * pressure),
        "normal_stress": (0.9 * pressure, 1.1 * pressure),
        "shear_rate": (900.0, 1100.0),
        "shear_fraction": (0.7, 0.8),
    }
    values = {name: rng.uniform(*ends, (2, 2, 4)) for name, ends in ranges.items()}
    values["shear_rate"] *= 10.0 * number[:, None]
    data = xr.Dataset(
        {
            name: ((*dims, "shear_strain"), value[..., None] * [0.9, 1.1])
            for name, value in values.items()
        }
        | {"run_id": (dims, np.full((2, 2, 4), "x"))},
        {"friction": ["0", "1"], "shear_inertial_number": number, "shear_strain": [0.1, 0.2]},
        {"configuration": json.dumps({"shear": {"pressure": pressure}})},
    )
    figure = plot("shear", data.assign_coords(diameter=1e-3, density=2500.0, seed=range(4)))
    mass = 2500.0 * 0.25 * np.pi * 1e-6
    measured = values["shear_rate"] * np.sqrt(mass / values["normal_stress"])
    shown = values["lid_shear_stress"] / values["lid_normal_stress"], values["shear_fraction"]
    for axes, runs in zip(figure.axes, shown, strict=True):
        at = np.ndindex(2, 2)
        assert_intervals(axes, [row(measured[place].mean(), runs[place]) for place in at])
        assert axes.get_xscale() == "log"
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["friction 0", "friction 1"]


def test_each_figure_is_asked_for_here():
    asked = {*CURVES, *PLACES, *BEDS}
    assert {*FIGURES} == asked | {"sweep", "velocity", "onset", "shear"}
