"""Claims: verdicts that deserve their names, a design that fills its space, jamming, alignment."""

import numpy as np
import pytest
import xarray as xr
from conftest import CONFIG, make_small_bed
from numpy.testing import assert_allclose
from scipy.stats import qmc

from dem.claims import design
from dem.claims.alignment import alignment
from dem.claims.changes import changed
from dem.claims.compare import CONTRADICTED, SUPPORTED, UNDECIDED, Comparison, together
from dem.claims.evidence import NOTHING, Evidence
from dem.claims.influence import influences, share_of_space
from dem.claims.jamming import NOISE, line
from dem.claims.plan import Choice, Range, SensitivitySection
from dem.claims.remains import remaining
from dem.claims.sentences import CLAIMS
from dem.claims.trials import PARTS, share, trials
from dem.claims.verdicts import judge
from dem.compaction import Press
from dem.config import load
from dem.errors import InputError

INFINITE = float("inf")
SHAPES = {"c1": 1300.0, "d1": 2900.0, "c2": 560.0, "e1": 900.0, "e2": 600.0, "e3": 400.0, "e0": 1300.0}  # fmt: skip


def drawn(means, runs=40, scatter=0.12, seed=0, density=None):
    """Runs by case and seed whose true mean drags (N) are given by label."""
    rng = np.random.default_rng(seed)
    drag = np.array([mean * rng.normal(1.0, scatter, runs) for mean in means.values()])
    return xr.Dataset(
        {"drag": (("case", "seed"), drag)},
        {
            "case": list(means), "seed": np.arange(runs), "shape": ("case", list(means)),
            "density": ("case", density or [3.9e3] * len(means)),
        },
    )  # fmt: skip


def verdict_on(name, runs):
    return next(v.verdict for v in judge(Evidence(runs)) if v.claim.name == name)


@pytest.mark.parametrize("paired", [True, False])
def test_intervals_of_ratios_hold_the_truth_as_often_as_they_say(paired):
    """Of 2000 intervals at 95 % between 93 and 97 % hold the ratio of the true means."""
    rng, held = np.random.default_rng(1), 0
    for _ in range(2000):
        bed = rng.normal(1.0, 0.1, 20) if paired else 1.0
        a, b = (mean * bed * rng.normal(1.0, 0.1, 20) for mean in (2.0, 1.0))
        low, high = Comparison("", a, b, 0.0, 1.0, paired).interval()
        held += low < 2.0 < high
    assert 0.93 < held / 2000 < 0.97


def test_pairing_takes_the_scatter_of_beds_out():
    bed = np.random.default_rng(1).normal(1.0, 0.3, 20)
    widths = [
        np.diff(Comparison("", 1.1 * bed, bed, 0.0, 1.0, paired).interval())[0]
        for paired in (True, False)
    ]
    assert widths[0] < 1e-6 < widths[1]


def test_verdicts_say_what_is_known():
    """The true order is found with many runs; equal means support neither side."""
    runs = drawn(SHAPES)
    assert verdict_on("dumbbells_above_discs", runs) == SUPPORTED
    assert verdict_on("dumbbells_below_discs", runs) == CONTRADICTED
    assert verdict_on("longer_ellipses_drop", runs) == SUPPORTED
    assert verdict_on("codes_agree", runs) == SUPPORTED
    equal = drawn(dict.fromkeys(SHAPES, 1000.0))
    assert verdict_on("dumbbells_above_discs", equal) == UNDECIDED
    assert verdict_on("dumbbells_below_discs", equal) == UNDECIDED
    assert verdict_on("slight_ellipses_drop", equal) == CONTRADICTED
    few = drawn(SHAPES, runs=2, scatter=0.5)
    assert verdict_on("longer_ellipses_drop", few) == UNDECIDED


def test_wrong_verdicts_are_rare():
    """Where no shape differs, hardly one sweep in twenty claims an order of any two."""
    ordered = {"dumbbells_above_discs", "dumbbells_below_discs", "dumbbells_above_small_discs", "longer_ellipses_drop"}  # fmt: skip
    wrong = 0
    for seed in range(200):
        found = judge(Evidence(drawn(dict.fromkeys(SHAPES, 1000.0), runs=10, seed=seed)))
        wrong += any(v.verdict == SUPPORTED for v in found if v.claim.name in ordered)
    assert wrong <= 16


def test_a_claim_of_parts_needs_all_and_falls_with_one():
    rng = np.random.default_rng(0)
    yes, no, open_ = (
        Comparison("", rng.normal(mean, 1.0, 50), None, 0.0, INFINITE) for mean in (5.0, -5.0, 0.1)
    )
    assert together([yes, yes], 0.95) == SUPPORTED
    assert together([yes, open_], 0.95) == UNDECIDED
    assert together([yes, open_, no], 0.95) == CONTRADICTED


def test_runs_that_failed_are_left_out():
    a = np.array([1.0, np.nan, 1.2, 1.1])
    assert_allclose(Comparison("", a, None, 0.0, 2.0).estimate, 1.1)
    assert np.array_equal(np.isnan(Comparison("", a, a, 0.0, 2.0).holds()), np.isnan(a))


def test_every_claim_says_what_it_is_and_survives_a_sweep_of_one_case():
    """No claim of a few words, no claim without its place, and none that needs what is not there."""
    for claim in CLAIMS:
        assert claim.reading and claim.place and len(claim.quote.split()) <= 20
        assert claim.compare(Evidence(drawn({"c1": 1000.0}))) == []
        assert claim.compare(Evidence(NOTHING)) == []


def test_share_of_space_counts_the_points():
    means = drawn({"c1": 1.0, "d1": 1.0}, runs=10, scatter=0.0)
    means["drag"].values[1] = [2.0] * 7 + [0.5] * 2 + [np.nan]
    claim = next(c for c in CLAIMS if c.name == "dumbbells_above_discs")
    found = share_of_space(Evidence(NOTHING, means), claim)
    assert found.points == 9
    assert_allclose(found.share, 7 / 9)
    assert found.low < 7 / 9 < found.high


# The design


FACTORS = {
    "friction.granule": Range(low=0.1, high=0.6),
    "material.young_modulus": Range(low=1e9, high=1e11, scale="log"),
    "packing.friction": Choice(choices=(0.0, 0.3)),
}
DESIGN = SensitivitySection(points=40, cases=("c1",), factors=FACTORS)


def test_design_fills_every_range():
    """Every fortieth of every range, on its scale, holds one point; choices come equally often."""
    found = design.points(DESIGN, 1)
    linear = np.array([point["friction.granule"] for point in found])
    log = np.log([point["material.young_modulus"] for point in found])
    for values, low, high in ((linear, 0.1, 0.6), (log, np.log(1e9), np.log(1e11))):
        assert sorted(((values - low) / (high - low) * 40).astype(int)) == list(range(40))
    assert [point["packing.friction"] for point in found].count(0.3) == 20
    assert design.points(DESIGN, 1) == found != design.points(DESIGN, 2)


def test_a_change_reaches_its_value_and_no_other():
    sweep = load(CONFIG / "smoke.yaml")
    before = changed(sweep, {}, "c1", 3.9e3, 7)
    after = changed(sweep, {"friction.wall": 0.7, "shapes.d1.granules": 5}, "c1", 3.9e3, 7)
    assert after.sweep.friction.wall == 0.7
    assert after.sweep.model_copy(update={"friction": before.sweep.friction}) == before.sweep
    assert changed(sweep, {"shapes.d1.granules": 50}, "d1", 3.9e3, 7).shape.granules == 50
    with pytest.raises(InputError, match=r"seed 7: friction.wall is -1"):
        changed(sweep, {"friction.wall": -1.0}, "c1", 3.9e3, 7)


def test_jobs_share_out_all_runs_of_a_part():
    """No run is lost between two jobs or made twice, and those of a bed stay together."""
    sweep = load(CONFIG / "paper.yaml")
    for part in ("replicates", "scaling"):
        every = trials(sweep, part)
        size = sweep.claims.group
        jobs = [share(sweep, part, n) for n in range(-(-len(every) // size))]
        assert [t for job in jobs for t in job] == every
        with pytest.raises(InputError, match="group is"):
            share(sweep, part, len(jobs))
    with pytest.raises(InputError, match="part is 'others'"):
        trials(sweep, "others")
    assert len(PARTS) == 5


# What decides


def test_influences_find_what_a_response_depends_on():
    """Of ln y = 2 x1 + x2 + noise the factors are found in order, with their growth over the range."""
    rng = np.random.default_rng(3)
    unit = qmc.LatinHypercube(3, rng=3).random(200)
    y = np.exp(2.0 * unit[:, 0] + unit[:, 1] + rng.normal(0.0, 0.1, 200))
    points = xr.Dataset(
        {"at": (("case", "seed", "factor"), 5.0 * unit[None]), "drag": (("case", "seed"), y[None])},
        {"case": ["c1"], "seed": np.arange(200), "factor": ["one", "two", "three"]},
    )
    found = influences(Evidence(NOTHING, points), y)
    assert [each.factor for each in found] == ["one", "two", "three"]
    for each, slope in zip(found, (2.0, 1.0, 0.0), strict=True):
        assert each.low < 1.02 * np.exp(slope) and each.high > 0.98 * np.exp(slope)
    assert_allclose([each.share for each in found], [0.8, 0.2, 0.0], atol=0.08)


# Jamming


def test_line_finds_where_pressure_begins():
    fraction = np.arange(0.74, 0.90, 0.005)
    pressure = (1e-2 * np.maximum(fraction - 0.8137, 0.0)) ** 1.5 + 0.1 * NOISE * (fraction < 0.81)
    found = line(fraction, pressure * (1e-6 / pressure.max()) ** 0.0)
    assert_allclose(found.jamming, 0.8137, atol=2e-4)
    assert_allclose(found.slope, 1e-2, rtol=0.02)
    assert np.isnan(line(fraction[:5], pressure[:5]).jamming)


def test_a_bed_has_pressure_only_above_its_jamming_fraction():
    """The line through the pressures of a bed ends between its last loose and its first tight state."""
    small = make_small_bed("disc")
    press = Press(small.shape, small.bed.width, small.bed.height, small.cylinder, 1)
    fractions = 0.74 + 0.005 * np.arange(28)
    pressures = np.array([press.press(fraction) for fraction in fractions])
    found = line(fractions, pressures)
    loose = fractions[pressures <= NOISE].max()
    assert loose - 0.01 < found.jamming < loose + 0.02


# Alignment


@pytest.mark.parametrize(("turn", "expected"), [(0.0, 1.0), (np.pi / 2, -1.0), (np.pi, 1.0)])
def test_alignment_tells_along_from_across(turn, expected):
    rng = np.random.default_rng(0)
    before = rng.uniform(-2e-3, 2e-3, (200, 2))
    moved = 1e-4 * rng.normal(size=(200, 2))
    angle = np.arctan2(moved[:, 1], moved[:, 0]) + turn
    along, _ = alignment(before, before + moved, angle, (0.0, 0.0), 1e-3, 1e-3, 5e-4)
    assert along == pytest.approx(expected)


def test_alignment_at_random_is_none_and_far_granules_do_not_count():
    rng = np.random.default_rng(0)
    before = rng.uniform(-2e-3, 2e-3, (4000, 2))
    after = before + 1e-4 * rng.normal(size=before.shape)
    angle = rng.uniform(0.0, 2.0 * np.pi, 4000)
    assert np.abs(alignment(before, after, angle, (0, 0), 1e-3, 1e-3, 5e-4)).max() < 0.06
    assert np.isnan(alignment(before + 1.0, after + 1.0, angle, (0, 0), 1e-3, 1e-3, 5e-4)).all()


# What remains at equal distance from jamming


def matched(drag_at_distance):
    """A study in which e1 drags half as much as c1 at equal fraction, and so much at equal distance."""
    rng = np.random.default_rng(0)
    rows = [("replicates", "c1", "", 0.84, 1000.0), ("replicates", "e1", "", 0.84, 500.0),
            ("matched", "e1", "equal distance", 0.876, drag_at_distance)]  # fmt: skip
    columns = [[row[n] for row in rows for _ in range(40)] for n in range(5)]
    drag = np.array(columns[4]) * rng.normal(1.0, 0.05, 120)
    names = "run_part", "run_case", "run_setting", "run_packing"
    runs = {name: ("run", np.array(c)) for name, c in zip(names, columns, strict=False)}
    runs |= {"run_drag": ("run", drag), "run_pressure": ("run", np.ones(120))}
    shapes = np.array(["c1"] * 10 + ["e1"] * 10)
    jam = np.where(shapes == "c1", 0.814, 0.850) + rng.normal(0.0, 1e-3, 20)
    return xr.Dataset(runs | {
        "jam_shape": ("jam", shapes), "jam_friction": ("jam", np.zeros(20)),
        "jam_fraction": ("jam", jam), "jam_slope": ("jam", np.ones(20)),
    })  # fmt: skip


@pytest.mark.parametrize(("drag", "part"), [(500.0, 1.0), (1000.0, 0.0), (1000.0 * 0.5**0.5, 0.5)])
def test_what_remains_of_an_effect(drag, part):
    (found,) = remaining(matched(drag))
    assert found.part[1] < part < found.part[2]
    assert found.part[2] - found.part[1] < 0.4
