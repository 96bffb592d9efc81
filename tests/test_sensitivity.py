"""Which factor matters: indices that are known in closed form, and what is refused."""

import io
import json
import re
import sys
from functools import partial

import numpy as np
import pytest
import xarray as xr
from made import SMOKE
from numpy.testing import assert_allclose
from rich.console import Console
from typer.testing import CliRunner

from conftest import assert_not_blank
from dem.analysis import sensitivity
from dem.analysis.sensitivity import columns_of, sensitivities
from dem.base.errors import InputError
from dem.cli.app import app
from dem.figures.catalogue import FIGURES, draw, drawable_from, possible
from dem.report.build import of_factors
from dem.report.sensitivity import sensitivity_table
from dem.sweep.axis import POINT, name_of
from dem.sweep.config import parse
from dem.sweep.design import Choice, Design, Range, points

NAMES = ("friction.granule", "friction.wall", "material.restitution")
THREE = {name: {"low": 0.1, "high": 0.5} for name in NAMES}
FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)  # of Ishigami's function


def ishigami(unit, a=7.0, b=0.1):
    x = np.pi * (2.0 * unit - 1.0)
    return np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0])


def results(function, over=None, count=128, seed=0, noise=0.0, seeds=1, shapes=("c1",), design="sobol"):
    """A dataset like drag.nc: 1000 N and a function of the factors (n, k), of 0 to 1 on their scale."""
    spec = {"design": design, "points": count, "first_seed": seed, "over": over or THREE}
    wanted = Design.model_validate(spec)
    made = points(wanted)
    values = {path: [point[path] for point in made] for path in wanted.over}
    unit = np.hstack([columns_of(wanted.over[path], each) for path, each in values.items()])
    rng = np.random.default_rng(seed)
    drag = 1000.0 + function(unit)[None, :, None] + noise * rng.standard_normal((len(shapes), count, seeds))
    dims = ("shape", "point", "seed")
    return xr.Dataset(
        {
            "drag": ((*dims, "displacement"), np.repeat(drag[..., None], 2, axis=-1)),
            "run_id": (dims, np.full(drag.shape, "x")),
            "displacement_bounds": (("displacement", "bound"), [[0.0, 1e-3], [1e-3, 2e-3]]),
        },
        {
            "shape": list(shapes), "seed": range(seeds), "displacement": [0.5e-3, 1.5e-3],
            "point": ("point", range(count), {"long_name": POINT}),
            **{name_of(path): ("point", each) for path, each in values.items()},
        },
        {"title": "Made up", "window_start": 0.0, "window_stop": 2e-3,
         "configuration": json.dumps({"sweep": {"shape": list(shapes), "point": spec}})},
    )  # fmt: skip


def linear(unit, slopes=(30.0, 20.0, 0.0)):
    return unit @ np.array(slopes)


def flat(unit):
    return np.zeros(len(unit))


def holds(interval, value, room=0.0):
    return interval[1] - room <= value <= interval[2] + room


def test_ishigamis_indices_are_those_of_its_integrals():
    """And those that SALib estimates from the function itself."""
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as sample

    (found,) = sensitivities(results(ishigami, count=256))
    problem = {"num_vars": 3, "names": list(NAMES), "bounds": [[0.0, 1.0]] * 3}
    taken = sample.sample(problem, 1024, calc_second_order=False, seed=1)
    other = analysis.analyze(problem, ishigami(taken), calc_second_order=False, seed=1)
    for name, exact, key in (("first", FIRST, "S1"), ("total", TOTAL, "ST")):
        for interval, value, salib, half in zip(found.effects[name], exact, other[key], other[f"{key}_conf"], strict=True):
            assert holds(interval, value) and interval[2] - interval[1] < 0.2
            assert holds(interval, salib, half)
    assert found.quality > 0.95 and not found.why and found.points == 256


def test_effects_of_a_linear_function_are_its_coefficients():
    """First-order and total indices are the shares of the squares; the same file gives the same bits."""
    made = results(linear, count=64, design="latin_hypercube")
    (found,), (again,) = sensitivities(made), sensitivities(made)
    assert all((again.effects[name] == found.effects[name]).all() for name in found.effects)
    assert_allclose(found.effects["main"][:, 0], np.array([30.0, 20.0, 0.0]) / 1025.0, atol=1e-4)
    for name in ("first", "total"):
        assert_allclose(found.effects[name][:, 0], [9 / 13, 4 / 13, 0.0], atol=0.03)


def test_factors_are_taken_on_their_scale_and_texts_by_columns():
    """A logarithmic range from 0 to 1, numbers by their place, a column for each text but the first."""
    wide = Range(low=1.0, high=100.0, scale="log")
    assert_allclose(columns_of(wide, [1.0, 10.0, 100.0])[:, 0], [0.0, 0.5, 1.0])
    assert_allclose(columns_of(Choice(choices=(2, 4, 3)), [4, 2, 3])[:, 0], [1.0, 0.0, 0.5])
    three = Choice(choices=("a", "b", "a", "c"))
    assert columns_of(three, ["a", "b", "c"]).tolist() == [[0, 0], [1, 0], [0, 1]]
    assert columns_of(Choice(choices=(3, 3)), [3]).tolist() == [[0.0]]


def test_choices_have_indices_and_two_texts_a_main_effect():
    over = {
        "friction.wall": {"low": 0.01, "high": 1.0, "scale": "log"},
        "ellipse.curvature": {"choices": ["volume", "local"]},
        "packing.preparation": {"choices": ["one", "two", "three"]},
    }
    made = results(lambda u: 40.0 * u[:, 0] + 40.0 * u[:, 1] + 40.0 * u[:, 3], over, count=64)
    (found,) = sensitivities(made)
    middle = float(made["drag"].mean())
    main = found.effects["main"]
    assert_allclose(main[:2, 0], 40.0 / middle, atol=1e-4)
    assert np.isnan(main[2]).all()
    variances = 40.0**2 * np.array([1 / 12, 1 / 4, 2 / 9])
    assert_allclose(found.effects["first"][:, 0], variances / variances.sum(), atol=0.05)


def test_noise_alone_is_refused_with_its_q2():
    """Main effects stay, and hold zero."""
    refused, held = 0, []
    for seed in range(6):
        (found,) = sensitivities(results(flat, count=32, seed=seed, noise=10.0))
        refused += bool(re.fullmatch(r"no Sobol indices, .* than the mean: Q2 = -?0\.\d\d\.", found.why))
        held += [holds(each, 0.0) for each in found.effects["main"]]
    assert refused >= 5 and np.mean(held) > 0.8


def test_intervals_cover_what_is_true():
    """Of noisy means, as wide as a mean of beds scatters: nine of ten intervals hold the index."""
    held = {"main": [], "first": [], "total": []}
    exact = {"main": np.array([30.0, 20.0, 0.0]) / 1025.0, "first": [9 / 13, 4 / 13, 0], "total": [9 / 13, 4 / 13, 0]}
    for seed in range(4):
        (found,) = sensitivities(results(linear, count=32, seed=seed, noise=6.0))
        for name, values in exact.items():
            held[name] += [holds(a, b, 0.02) for a, b in zip(found.effects[name], values, strict=True)]
    assert all(np.mean(each) >= 0.85 for each in held.values()), held


def test_each_place_has_its_own_effects_and_seeds_are_averaged():
    made = results(linear, count=32, seeds=3, noise=1.0, shapes=("c1", "e3"))
    made["drag"].loc[{"shape": "e3"}] *= -1.0
    made["drag"].loc[{"shape": "c1", "point": 3}] = np.nan
    one, two = sensitivities(made)
    assert (one.place, one.points, two.place, two.points) == ("c1", 31, "e3", 32)
    assert_allclose(one.effects["main"][:, 0], two.effects["main"][:, 0], atol=2e-3)


def written(tmp_path, made):
    made.to_netcdf(tmp_path / "drag.nc")
    return tmp_path / "drag.nc"


def changed(made, **values):
    sweep = json.loads(made.attrs["configuration"])
    sweep["sweep"]["point"] |= values
    return made.assign_attrs(configuration=json.dumps(sweep))


def plain(made):
    made["point"].attrs.clear()
    return made


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (plain, "its runs are not the points of a design"),
        (lambda made: made.isel(point=slice(4)), "no design of the values along point"),
        (partial(changed, first_seed=5), "no design of the values along point"),
        (lambda made: made.where(made["point"] < 4), "it has 4 points with drag; 3 factors take 5"),
        (lambda made: made.where(made["point"] < 0), "all its runs failed"),
    ],
)
def test_what_has_no_effects_is_refused_in_a_sentence(tmp_path, change, words):
    made = results(linear, count=8)
    whole = made["run_id"], made["displacement_bounds"]
    made = change(made)
    if made.sizes["point"] == 8:
        made["run_id"], made["displacement_bounds"] = whole
    path = written(tmp_path, made)
    done = CliRunner().invoke(app, ["sensitivity", str(path)])
    assert done.exit_code == 2 and words in done.stderr and done.stderr.count("\n") == 1
    with pytest.raises(InputError, match=words):
        draw("sensitivity", path, tmp_path)


def test_the_table_holds_the_effects(tmp_path):
    path = written(tmp_path, results(linear, count=16, shapes=("c1", "e3")))
    done = CliRunner().invoke(app, ["sensitivity", str(path), "-o", str(tmp_path / "table.txt")])
    assert done.exit_code == 0, done.stderr
    text = (tmp_path / "table.txt").read_text()
    assert re.search(r"c1 +friction\.granule +\+2\.9 % \(\+2\.9 to \+2\.9\) +0\.\d\d \(0\.\d\d to 0\.\d\d\)", text)
    assert "c1: 16 points, Q2 = " in text and "e3: 16 points" in text


def test_without_the_package_main_effects_stay_and_it_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    made = results(linear, count=32, shapes=("c1", "e3"))
    table, notes = sensitivity_table(made)
    console = Console(width=200, file=io.StringIO())
    console.print(table)
    assert "+2.9 %" in console.file.getvalue()
    assert notes == ["c1: 32 points", "e3: 32 points", sensitivity.MISSING]
    assert "pip install 'granular-drag[design]'" in sensitivity.MISSING
    draw("sensitivity", written(tmp_path, made), tmp_path)
    assert_not_blank(tmp_path / "sensitivity.png")


def test_the_figure_and_the_report_show_the_indices_greatest_first():
    from dem.figures.sensitivity import plot

    made = results(linear, count=16)
    axes = plot(made).axes
    assert [label.get_text() for label in axes[0].get_yticklabels()] == list(NAMES)
    (found,) = sensitivities(made)
    for lines, name in zip(axes[0].containers, ("total", "first"), strict=True):
        assert_allclose(lines[0].get_xdata(), found.effects[name][:, 0])
    told = of_factors(made)
    assert [row[1] for row in told["rows"]] == list(NAMES)
    assert told["notes"] == [f"all: 16 points, Q2 = {found.quality:.2f}"]


@pytest.mark.parametrize(("count", "drawn"), [(8, True), (4, False)])
def test_the_figure_is_offered_for_designs_with_enough_points(tmp_path, count, drawn):
    """Of a sweep before it is run, and of its file."""
    assert FIGURES["sensitivity"].axes == {POINT: 2}
    point = {"design": "sobol", "points": count, "over": THREE}
    values = {"extends": str(SMOKE), "results": "results/points"}
    sweep = parse(values | {"sweep": {"shape": ["c1", "e3"], "point": point, "seed": [1, 2]}})
    assert ("sensitivity" in possible(sweep.block("drag"))) == drawn
    made = results(linear, count=count)
    assert ("sensitivity" in drawable_from(tmp_path, made.assign_coords(density=3900.0))) == drawn
    grid = parse(values | {"sweep": {"shape": ["c1"], "friction.wall": [0.1, 0.2, 0.3]}})
    assert "sensitivity" not in possible(grid.block("drag"))


def test_claims_name_the_package_that_ranks_influences(monkeypatch):
    influence = pytest.importorskip("studies.claims.influence")
    monkeypatch.setitem(sys.modules, "SALib.analyze", None)
    with pytest.raises(InputError, match=r"SALib: pip install 'granular-drag\[design\]'"):
        influence.influences(None, None)


def test_many_points_are_fitted_by_the_first_of_them(monkeypatch):
    monkeypatch.setattr(sensitivity, "POINTS", 32)
    monkeypatch.setattr("dem.report.sensitivity.POINTS", 32)
    _, notes = sensitivity_table(results(linear, count=64))
    assert re.fullmatch("all: 64 points, the first 32 for the indices, Q2 = [01][.0-9]+", *notes)
