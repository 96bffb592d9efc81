"""Claims: verdicts that deserve their names, a design that fills its space, a row a run,
jamming."""

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from scipy.stats import qmc
from sweeps import FOREIGN, foreign
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.sweep.state import SweepState
from studies.__main__ import app
from studies.claims import results
from studies.claims.compare import CONTRADICTED, SUPPORTED, UNDECIDED, Comparison
from studies.claims.evidence import NOTHING, Evidence, from_study
from studies.claims.influence import influences
from studies.claims.irregularity import compared
from studies.claims.remains import jamming_in, remaining
from studies.claims.sentences import CLAIMS
from studies.claims.verdicts import UNTESTED, judge, share, together

SMOKE = Path(__file__).parent.parent / "smoke.yaml"
SHAPES = dict(c1=1300.0, d1=2900.0, c2=560.0, e1=900.0, e2=600.0, e3=400.0, e0=1300.0)
AT_BOUNDS = dict(c1=1e3, d1=1e3, c2=1e3 / 1.18, e1=820.0, e2=820.0, e3=820.0, e0=1180.0, c12=1180.0)


def drawn(means, runs=40, scatter=0.12, seed=0, density=None):
    """Runs by case and seed whose true mean drags (N) are given by label."""
    rng = np.random.default_rng(seed)
    drag = np.array([mean * rng.normal(1.0, scatter, runs) for mean in means.values()])
    labels, density = list(means), density or [3.9e3] * len(means)
    coords = {"case": labels, "seed": np.arange(runs)}
    coords |= {"shape": ("case", labels), "density": ("case", density)}
    return xr.Dataset({"drag": (("case", "seed"), drag)}, coords)


def verdicts(runs, **more):
    return {verdict.claim.name: verdict.verdict for verdict in judge(Evidence(runs, **more))}


def test_verdicts_say_what_is_known():
    """The true order is found with many runs; equal means support neither side."""
    runs, equal = verdicts(drawn(SHAPES)), verdicts(drawn(dict.fromkeys(SHAPES, 1000.0)))
    assert runs["dumbbells_above_discs"] == runs["longer_ellipses_drop"] == SUPPORTED
    assert runs["codes_agree"] == SUPPORTED and runs["dumbbells_below_discs"] == CONTRADICTED
    assert equal["dumbbells_above_discs"] == equal["dumbbells_below_discs"] == UNDECIDED
    assert equal["slight_ellipses_drop"] == CONTRADICTED
    few = verdicts(drawn(SHAPES, runs=2, scatter=0.5))
    assert few["longer_ellipses_drop"] == UNDECIDED


def test_wrong_verdicts_are_as_rare_as_the_level_says():
    """Where every truth lies on the bound of its claim, a verdict other than undecided is wrong."""
    names = (
        "dumbbells_above_discs",
        "dumbbells_below_discs",
        "dumbbells_above_small_discs",
        "slight_ellipses_drop",
        "longer_ellipses_drop",
        "codes_agree",
        "momentum_is_insignificant",
    )
    density = [3.9e4 if label == "c12" else 3.9e3 for label in AT_BOUNDS]
    wrong = 0
    for seed in range(60):
        runs = drawn(AT_BOUNDS, runs=10, seed=seed, density=density)
        runs["shape"].values[runs["case"].values == "c12"] = "c1"
        judged = verdicts(runs)
        assert UNTESTED not in {judged[name] for name in names}
        wrong += {judged[name] for name in names} != {UNDECIDED}
    assert wrong <= 8  # where intervals do not hold together, about 14


def test_a_claim_of_parts_needs_all_and_falls_with_one():
    rng = np.random.default_rng(0)
    yes, no, open_ = (
        Comparison(words="", a=rng.normal(mean, 1.0, 50)) for mean in (5.0, -5.0, 0.1)
    )
    assert together([yes, yes], 0.95) == SUPPORTED
    assert together([yes, open_], 0.95) == UNDECIDED
    assert together([yes, open_, no], 0.95) == CONTRADICTED


def test_runs_that_failed_are_left_out():
    a = np.array([1.0, np.nan, 1.2, 1.1])
    assert_allclose(Comparison(words="", a=a).estimate, 1.1)
    assert np.array_equal(np.isnan(Comparison(words="", a=a, b=a).holds()), np.isnan(a))


def test_a_claim_has_its_place_and_survives_a_sweep_of_one_case():
    """No claim of a few words, and none that needs what is not there."""
    for claim in CLAIMS:
        assert claim.reading and claim.place and len(claim.quote.split()) <= 30
        assert (
            claim.compare(Evidence(drawn({"c1": 1000.0}))) == claim.compare(Evidence(NOTHING)) == []
        )


def test_share_of_space_counts_the_points():
    means = drawn({"c1": 1.0, "d1": 1.0}, runs=10, scatter=0.0)
    means["drag"].values[1] = [2.0] * 7 + [0.5] * 2 + [np.nan]
    claim = next(c for c in CLAIMS if c.name == "dumbbells_above_discs")
    result = share(claim, Evidence(means, single=True))
    assert (result.points, result.failed) == (9, 1)
    assert_allclose(result.share, 7 / 9)
    assert result.low < 7 / 9 < result.high


def test_the_order_of_runs_does_not_matter():
    rows = study()
    turned = rows.isel(run=slice(None, None, -1), jam=slice(None, None, -1))
    for one, other in zip(*(judge(from_study(dataset)) for dataset in (rows, turned)), strict=True):
        assert one.verdict == other.verdict
        numbers = (
            [comparison.estimate for comparison in verdict.comparisons] for verdict in (one, other)
        )
        assert_allclose(*numbers, rtol=1e-9)
    assert len(remaining(rows)) == len(remaining(turned)) == 5


def fives(mean, scatter, runs=60):
    """A drag (runs, place) of which five runs have this mean and scatter along their mean curve."""
    rng = np.random.default_rng(round(mean))
    return mean * (1.0 + scatter * np.sqrt(5.0) * rng.normal(size=(runs, 400)))


@pytest.mark.parametrize(
    ("e0", "c1", "verdict"),
    [
        ((1405.0, 0.17), (1295.0, 0.18), SUPPORTED),
        ((1405.0, 0.17), (1295.0, 0.09), CONTRADICTED),
        ((1405.0, 0.34), (1295.0, 0.18), CONTRADICTED),
        ((2810.0, 0.17), (1295.0, 0.18), CONTRADICTED),
    ],
)
def test_the_reported_means_and_scatter_are_those_of_five_runs(e0, c1, verdict):
    """Half the scatter, twice the scatter or twice the mean contradict the report."""
    curve = np.array([fives(*e0), fives(*c1)])
    runs = drawn({"e0": 1405.0, "c1": 1295.0}, runs=60)
    runs = runs.assign(curve=(("case", "seed", "place"), curve))
    runs = runs.assign_coords(place=np.linspace(1e-3, 5e-3, 400))
    runs.attrs |= {"window_start": 0.5e-3, "window_stop": 5.5e-3}
    assert verdicts(runs)["means_and_scatter_as_reported"] == verdict


@pytest.mark.parametrize(("margin", "verdict"), [(0.18, SUPPORTED), (0.40, CONTRADICTED)])
def test_words_of_degree_follow_the_margin(margin, verdict):
    """A drop of 28 % is remarkable by a margin of 18 %, and not by one of 40 %."""
    runs = drawn({"c1": 1000.0, "e1": 720.0})
    assert verdicts(runs, margin=margin)["slight_ellipses_drop"] == verdict


def test_a_flow_twice_as_irregular_is_seen():
    """Twice as irregular is found to be so, with an interval that covers it."""
    rng = np.random.default_rng(3)
    runs = np.array([[1.0], [2.0]]) * rng.normal(1.0, 0.1, (2, 40))
    dataset = xr.Dataset(
        {"mixing": (("case", "seed", "snapshot"), runs[..., None] * np.ones(4))},
        {
            "case": ["round", "long"],
            "shape": ("case", ["c1", "e3"]),
            "density": ("case", [1.0, 1.0]),
            "snapshot_displacement": ("snapshot", [0.0, 1e-3, 2e-3, 9e-3]),
        },
        {"window_start": 1e-3, "window_stop": 5e-3},
    )
    comparison = compared(dataset, "mixing")
    assert abs(comparison.ratio - 2.0) < comparison.half < 0.2
    assert compared(dataset.sel(case=["round"]), "mixing") is None


# The table


@pytest.fixture(scope="module")
def smallest(checkout_with_claims):
    """The smallest form of the study, and its claims.nc."""
    file = checkout_with_claims / "results/smoke/claims.nc"
    return SweepState.of(SMOKE, checkout_with_claims), xr.load_dataset(file)


def test_every_run_of_the_study_is_a_row(smallest):
    state, dataset = smallest
    blocks = [name for name in state.sweep.blocks if not name.startswith("jamming")]
    runs = [run for name in blocks for run in state.block(name).runs.values()]
    names = "part", "case", "setting", "x", "point", "seed"
    columns = (map(str, dataset[f"run_{name}"].values) for name in names)
    assert len(runs) == len(set(zip(*columns, strict=True))) == 63
    packing = [run.configuration.packing.fraction for run in runs]
    assert dataset["run_packing"].values.tolist() == packing
    assert dataset["run_seed"].values.tolist() == [run.seed for run in runs]
    success = dataset["run_status"] == "ran"
    assert success.mean() > 0.8 and (dataset["run_drag"][success] > 0.0).all()
    assert dataset["run_drag"][~success].isnull().all()


def test_a_run_that_failed_is_a_row_with_its_error():
    block = SweepState.of(SMOKE).block("replicates")
    run = block.first
    layout = run.configuration.module.layout
    sizes = run.configuration.module.sizes(run)
    values = {
        name: np.full([sizes[dim] for dim in dims], np.nan) for name, (dims, *_) in layout.items()
    }
    row = results.row_of_run(
        block, next(iter(block.runs)), run, values | {"failure": 3, "spent": 1.0}, {}
    )
    assert row["status"] == "StateError" and np.isnan(row["drag"]) and np.isnan(row["curve"]).all()


def test_points_of_the_design_have_their_factors(smallest):
    """Both cases of a point share its values, a choice is its number; other parts have none."""
    _, dataset = smallest
    designed = dataset["run_point"].values >= 0
    assert (dataset["run_part"].values[designed] == "sensitivity").all()
    assert np.isnan(dataset["run_factor"].values[~designed]).all()
    columns = dataset["run_factor"].values[designed].T
    at = dict(zip(dataset["factor"].values.tolist(), columns, strict=True))
    assert np.array_equal(at["packing.fraction"], dataset["run_packing"].values[designed])
    assert sorted(at["packing.friction"]) == [0.0] * 10 + [1.0] * 10


def test_derived_fractions_are_those_of_the_beds_in_the_file(smallest):
    """Each shape, aspect ratio and box is as far from jamming as the paper's bed is."""
    _, dataset = smallest
    jamming, kinds = jamming_in(dataset), set()
    columns = [
        dataset[f"run_{name}"].values for name in ("part", "case", "setting", "x", "packing")
    ]
    for part, case, words, x, packing in zip(*columns, strict=True):
        if part not in ("matched", "ratios", "scaling") or "equal" not in words:
            continue
        kind, other = {
            "matched": (case, "c1"),
            "ratios": (f"{x:g}:1", "c1"),
            "scaling": (f"{case} {words.partition(',')[0]} {x:g}", case),
        }[part]
        friction = 0.3 if "friction" in words else 0.0
        expected = {"equal fraction": 0.84, "equal load": jamming.at_load(kind, other, 0.84)}
        distance = jamming.at_distance(kind, other, 0.84, friction)
        assert packing == expected.get(words, distance)
        kinds.add((part, words))
    assert len(kinds) == 7


# What decides


def test_influences_find_what_a_response_depends_on():
    """Of ln y = 2 x1 + x2 + noise the factors are found in order, with their growth over the
    range."""
    rng = np.random.default_rng(3)
    unit = qmc.LatinHypercube(3, rng=3).random(200)
    y = np.exp(2.0 * unit[:, 0] + unit[:, 1] + rng.normal(0.0, 0.1, 200))
    points = xr.Dataset(
        {"at": (("case", "seed", "factor"), 5.0 * unit[None]), "drag": (("case", "seed"), y[None])},
        {"case": ["c1"], "seed": np.arange(200), "factor": ["one", "two", "three"]},
    )
    ranked = influences(points, y)
    assert [influence.factor for influence in ranked] == ["one", "two", "three"]
    for influence, slope in zip(ranked, (2.0, 1.0, 0.0), strict=True):
        assert influence.low < 1.02 * np.exp(slope) and influence.high > 0.98 * np.exp(slope)
        assert influence.decides == (slope > 0.0)
    assert_allclose([influence.share for influence in ranked], [0.8, 0.2, 0.0], atol=0.08)


def test_the_package_that_ranks_influences_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "SALib.analyze", None)
    with pytest.raises(InputError, match="SALib: pip install SALib"):
        influences(None, None)


# What remains at equal distance from jamming


def study(drag_at_distance=1600.0, friction=0.0):
    """A study whose first case drags 1000 N, in which e1 drags half as much at equal fraction and
    so much at equal distance, and d1 twice as much throughout."""
    rng = np.random.default_rng(0)
    parts = [
        ("replicates", "c1", "", 0.84, 1000.0),
        ("replicates", "e1", "", 0.84, 500.0),
        ("replicates", "d1", "", 0.84, 2000.0),
        ("matched", "e1", "equal distance", 0.876, drag_at_distance),
        ("matched", "d1", "equal distance", 0.8406, 2000.0),
    ]
    rows = [(*part, seed) for part in parts for seed in range(40)]
    names = "part", "case", "setting", "packing", "drag", "seed"
    runs = dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))
    runs["drag"] = runs["drag"] * rng.normal(1.0, 0.05, len(rows))
    count, shapes = len(rows), np.repeat(["c1", "e1", "d1"], 10)
    runs |= {
        "shape": runs["case"],
        "density": np.full(count, 3.9e3),
        "load": np.ones(count),
        "status": np.full(count, "ran"),
        "spent": np.ones(count),
        "x": np.full(count, np.nan),
        "point": np.full(count, -1),
    }
    jam = np.array([{"c1": 0.814, "e1": 0.850, "d1": 0.8146}[shape] for shape in shapes])
    along = {
        "run_curve": (("run", "place"), runs["drag"][:, None] * np.ones((1, 5))),
        "run_factor": (("run", "factor"), np.full((count, 1), np.nan)),
        "run_alignment": (("run", "moment"), np.full((count, 2), 0.3)),
        "run_alignment_start": (("run", "moment"), np.full((count, 2), 0.1)),
    }
    return xr.Dataset(
        {f"run_{name}": ("run", array) for name, array in runs.items()}
        | along
        | {
            "jam_shape": ("jam", shapes),
            "jam_friction": ("jam", np.full(30, friction)),
            "jam_fraction": ("jam", jam + rng.normal(0.0, 1e-3, 30)),
            "jam_slope": ("jam", np.ones(30)),
            "jam_diameter": ("jam", np.full(30, 1e-3)),
            "reference_shape": "c1",
            "reference_density": 3.9e3,
            "reference_packing": 0.84,
        },
        {"place": np.linspace(1e-3, 5e-3, 5), "moment": [2e-3, 4e-3], "factor": ["a.b"]},
        {"window_start": 0.5e-3, "window_stop": 5.5e-3, "title": "a study"},
    )


@pytest.mark.parametrize("drag", [500.0, 1000.0, 707.1, 2000.0])
def test_what_remains_of_an_effect(drag):
    """All, nothing, half or the opposite of it, and dumbbells keep theirs."""
    ratios = {(r.shape, r.state): r.ratio for r in remaining(study(drag))}
    for place, truth in {
        ("e1", "equal distance"): drag / 1000.0,
        ("d1", "equal distance"): 2.0,
        ("e1", "equal fraction"): 0.5,
    }.items():
        _, low, high = ratios[place]
        assert low < truth < high < 1.5 * low


def test_shapes_under_the_load_of_another():
    """at_load inverts the law it was fitted by: loads over E* are equal there."""
    rows = study().assign(jam_diameter=("jam", np.repeat([1.0, 0.5, 2.0], 10)))
    rows["jam_slope"].values[10:20] = 0.7
    jamming = jamming_in(rows)
    fraction = jamming.at_load("e1", "c1", 0.84)

    def load(shape, at, slope, diameter):
        return (slope * (at - jamming.mean(shape, "fraction"))) ** 1.5 * diameter

    assert_allclose(load("e1", fraction, 0.7, 0.5), load("c1", 0.84, 1.0, 1.0))
    assert jamming.at_load("e1", "c1", 0.80) < jamming.mean("e1", "fraction")


@pytest.mark.parametrize("fault", FOREIGN)
def test_claims_are_tested_on_no_foreign_file(tmp_path, fault):
    """It is answered with a sentence, or with dashes where it has gaps."""
    file = foreign(tmp_path / "mine.nc", FOREIGN[fault])
    run = CliRunner().invoke(app, ["claims", "test", str(file)])
    assert run.exit_code in (0, 2)
    assert "mine.nc" in run.stderr if run.exit_code else "nan" not in run.stdout


def test_claims_are_tested_on_the_file_of_the_study():
    """The released one, also where one claim is asked for."""
    file = Path(__file__).parents[1] / "claims.nc"
    run = CliRunner().invoke(app, ["claims", "test", str(file), "--claim", CLAIMS[0].name])
    assert run.exit_code == 0 and f"{CLAIMS[0].name}: " in run.stdout
