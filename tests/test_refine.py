"""Points of a refined value: where least is known, enough of them, and the same however the sweep was made.

Runs are numbers drawn from a distribution here, by an experiment in a file of one's own: they cost nothing.
"""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from forked import snakemake
from made import of_file
from scipy import stats
from typer.testing import CliRunner

import dem
from conftest import posix
from dem.base.errors import InputError, RunError
from dem.base.sources import ROOT
from dem.cli.app import app
from dem.cli.show import PlainConsole
from dem.figures.catalogue import possible
from dem.report.info import summary as info
from dem.report.status import status
from dem.sweep import refine
from dem.sweep.campaign import Campaign
from dem.sweep.estimate import summary
from dem.sweep.refine import EVERY, STEPS, Refine, after, curve, predicted

DRAWN = '''
"""A number drawn from a distribution, whose mean has a peak over the velocity."""
from pathlib import Path

import numpy as np

from dem.base.errors import RunError

SECTIONS = {"cylinder": True, "record": False}
VARIABLES = {"force": ((), "N", "a drawn number"), "offset": ((), "N", "one about zero")}


def run(replicate, bed=None, progress=lambda done: None):
    own = replicate.configuration
    velocity, friction = own.cylinder.velocity, own.friction.granule
    rng = np.random.default_rng([replicate.seed, int(1e6 * velocity), int(1e6 * friction)])
    left = Path("left")  # so many runs until the process is killed
    if left.exists():
        left.write_text(str(int(left.read_text()) - 1))
        if left.read_text() == "-1":
            left.unlink()
            raise KeyboardInterrupt
    if velocity == 1.79 and Path("fails").exists():
        raise RunError("this one fails")
    number = rng.standard_normal()
    peak = 1.0 + np.exp(-2.0 * np.log(velocity / 3.0) ** 2)
    return {"force": 100.0 * peak * (1.0 + friction) * (1.0 + 0.03 * number), "offset": number}
'''
SWEEP = """
extends: config/smoke.yaml
results: results/peaked
experiment: peaked.py
sweep:
"""
VELOCITY = "{refine: log, low: 0.1, high: 32, until: 8 %, of: force}"
FRICTION = "{refine: linear, low: 0.1, high: 0.8, until: 8 %, of: force}"
ONE = {"case": "[c1, e3]", "cylinder.velocity": VELOCITY, "seed": "1 to 3"}
FEW = ONE | {"case": "c1", "cylinder.velocity": VELOCITY.replace("8 %", "16 %, least: 7")}  # few rounds
TWO = {"case": "c1", "cylinder.velocity": VELOCITY, "friction.granule": FRICTION, "seed": "1 to 3"}
TWO = {key: each.replace("8 %", "12 %") for key, each in TWO.items()}


@pytest.fixture
def sweep(tmp_path, monkeypatch):
    """Writes a sweep file of drawn numbers, in a folder of its own where the test works."""
    monkeypatch.chdir(tmp_path)
    Path("peaked.py").write_text(DRAWN)

    def write(keys=ONE, **more):
        lines = [f"  {key}: {each}\n" for key, each in (keys | more).items() if each]
        Path("sweep.yaml").write_text(SWEEP + "".join(lines))
        return Path("sweep.yaml")

    return write


def result(name="peaked") -> xr.Dataset:
    with dem.open_results(f"results/peaked/{name}.nc") as found:
        return found.load()


def put_aside() -> None:
    for name in ("store", "peaked"):
        Path(f"results/{name}").rename(f"{name}-before")


def shown(table) -> str:
    console = PlainConsole(width=200)
    with console.capture() as text:
        console.print(table)
    return text.get()


def refined(function, asked: Refine, scatter: float, seeds=3, draw=0) -> tuple[list, list]:
    """Points of a function of 0 to 1, and the runs of each, drawn with a relative scatter."""
    rng, runs, steps = np.random.default_rng(draw), {}, asked.first(1)
    while True:
        for step in steps:
            drawn = function(step[0] / STEPS) * (1.0 + scatter * rng.standard_normal(seeds))
            runs.setdefault(step, drawn)
        found = after(asked, steps, [[runs[step] for step in steps]])
        if found == steps:
            return steps, [runs[step] for step in steps]
        assert set(found) > set(steps)
        steps = found


def asking(until="5 %", **more) -> Refine:
    return Refine(refine="linear", low=0.0, high=1.0, until=until, **more)


def bump(at):
    return 100.0 * (1.0 + np.exp(-0.5 * ((at - 0.37) / 0.08) ** 2))


def jump(at):
    return 100.0 * (1.0 + 1.0 / (1.0 + np.exp(-(at - 0.55) / 0.02)))


def kink(at):
    return 100.0 * (1.0 + 3.0 * np.maximum(at - 0.6, 0.0))


def line(at):
    return 100.0 * np.exp(1.5 * at)


@pytest.mark.parametrize("function, place", [(jump, 0.55), (kink, 0.6)])
def test_points_gather_where_the_mean_is_least_known(function, place):
    """At a jump between two constants, and at a kink: half as far apart as elsewhere."""
    steps, _ = refined(function, asking("3 %"), 0.003)
    at = np.array([step for step, in steps]) / STEPS
    near, apart = abs(0.5 * (at[1:] + at[:-1]) - place) < 0.08, np.diff(at)
    assert 8 < len(steps) < 40 and apart[near].mean() < 0.7 * apart[~near].mean()


def test_where_runs_scatter_more_points_are_placed():
    counts = [len(refined(line, asking(most=100), scatter)[0]) for scatter in (0.01, 0.04, 0.07)]
    assert counts[0] < counts[1] < counts[2] < 100


def test_more_replicates_take_fewer_points():
    counts = [len(refined(line, asking(most=100), 0.05, seeds)[0]) for seeds in (2, 5, 20)]
    assert counts[0] > counts[1] > counts[2]


@pytest.mark.parametrize("function", [bump, kink, line])
def test_the_true_curve_is_within_what_was_asked_for(function):
    """On nineteen of twenty places, over functions that nobody told the surrogate of."""
    at, within = np.array(EVERY[1]) / STEPS, []
    for draw in range(10):
        asked = asking("4 %", most=60)
        found = curve(asked, *refined(function, asked, 0.03, draw=draw))
        mean, excess = found.excess(asked, at)
        assert excess.max() <= 1.0
        within.append((abs(np.exp(mean) / function(at[:, 0]) - 1.0) <= 0.04).mean())
    assert np.mean(within) > 0.95


def test_the_surrogate_is_the_gaussian_process_of_its_lengths_and_height(monkeypatch):
    """Of one length and one height: as another implementation has it."""
    process = pytest.importorskip("sklearn.gaussian_process")
    kernels = process.kernels
    monkeypatch.setattr(refine, "LENGTHS", np.array([0.3]))
    monkeypatch.setattr(refine, "HEIGHTS", np.array([2.0]))
    rng = np.random.default_rng(1)
    x, at, noise = rng.random((9, 2)), rng.random((50, 2)), rng.uniform(0.01, 0.04, 9)
    y = np.sin(5.0 * x[:, 0]) + x[:, 1]
    kernel = kernels.ConstantKernel(refine.CONSTANT) + 2.0 * kernels.Matern(0.3, nu=1.5)
    size = y.std()
    other = process.GaussianProcessRegressor(kernel, alpha=noise / size**2 + 1e-8, optimizer=None)
    mean, deviation = other.fit(x, (y - y.mean()) / size).predict(at, return_std=True)
    *found, missed = predicted(x, y, noise, at)
    own = kernel(x) + np.diag(noise / size**2 + 1e-8)
    for k in range(9):  # each as the others predict it
        rest = np.arange(9) != k
        weights = np.linalg.solve(own[rest][:, rest], own[rest, k])
        miss = (y - y.mean())[k] / size - weights @ (y - y.mean())[rest] / size
        variance = own[k, k] - weights @ own[rest, k]
        share = 1.0 - (own[k, k] - kernel(x)[k, k]) / variance
        assert missed[:, k] == pytest.approx([share * miss**2 / variance, share], rel=1e-4)
    np.testing.assert_allclose(found[0], y.mean() + size * mean, atol=1e-7)
    np.testing.assert_allclose(found[1], size * deviation, atol=1e-6)


def test_lengths_and_heights_weigh_by_how_well_they_explain_the_means(monkeypatch):
    """The mixture of the processes that another implementation has for each, by its likelihood."""
    process = pytest.importorskip("sklearn.gaussian_process")
    lengths, heights = np.array([0.1, 0.6]), np.array([0.5, 3.0])
    for name, values in (("LENGTHS", lengths), ("HEIGHTS", heights), ("UNLIKELY", 0.0)):
        monkeypatch.setattr(refine, name, values)
    x, at = np.linspace(0.0, 1.0, 8)[:, None], np.linspace(0.0, 1.0, 30)[:, None]
    y, kernels = np.sin(6.0 * x[:, 0]), process.kernels
    y /= y.std()
    fits = []
    for height in heights:
        for length in lengths:
            kernel = kernels.ConstantKernel(refine.CONSTANT) + height * kernels.Matern(length, nu=1.5)
            fits.append(process.GaussianProcessRegressor(kernel, alpha=0.02 + 1e-8, optimizer=None).fit(x, y - y.mean()))
    weight = np.exp([fit.log_marginal_likelihood_value_ for fit in fits])
    mean, deviation = np.moveaxis([fit.predict(at, return_std=True) for fit in fits], 1, 0)
    weight, expected = weight / weight.sum(), np.average(mean, 0, weight)
    assert 0.02 < weight.max() < 0.98
    found = predicted(x, y, np.full(8, 0.02), at)
    np.testing.assert_allclose(found[0], y.mean() + expected, atol=1e-7)
    second = np.average(mean**2 + deviation**2, 0, weight)
    np.testing.assert_allclose(found[1], np.sqrt(second - expected**2), atol=1e-6)


def test_replicates_of_one_point_weigh_as_their_number():
    """The scatter of all points is one; where a run failed a mean is less known."""
    rng, asked = np.random.default_rng(2), asking("5 N")
    samples = [100.0 + rng.standard_normal(4) for _ in range(5)]
    samples[2][1:3] = np.nan
    found = curve(asked, asked.first(1), samples)
    runs = np.array(samples)
    runs -= np.nanmean(runs, axis=1, keepdims=True)
    scatter = np.nansum((runs - np.nanmean(runs, axis=0)) ** 2) / (18 - 5 - 3)
    np.testing.assert_allclose(found.noise, scatter / np.array([4, 4, 2, 4, 4]))
    assert found.quantile == pytest.approx(stats.t(10).ppf(0.975)) and found.beds == 0.0
    np.testing.assert_allclose(found.y, [np.nanmean(each) for each in samples])
    # the mean of logarithms is less than the logarithm of the mean, which is asked for
    few = [[np.exp(rng.normal(3.0, 0.5, 6)) for _ in range(5)] for _ in range(200)]
    logs = [curve(asking(), asked.first(1), each).y.mean() for each in few]
    assert np.mean(logs) == pytest.approx(3.0 + 0.5 * 0.25, abs=0.03)


def test_a_number_without_an_end_counts_as_a_run_that_failed():
    rng, asked = np.random.default_rng(3), asking()
    samples, found = [100.0 + rng.standard_normal(3) for _ in range(5)], []
    for value in (np.nan, np.inf, -np.inf):
        samples[1][0] = value
        found.append(after(asked, asked.first(1), [samples]))
    assert found[0] == found[1] == found[2]


def test_no_point_is_placed_twice():
    """Where more may be placed than the scale has steps."""
    rng, asked, steps = np.random.default_rng(0), asking("0.01 %", most=200), EVERY[1][:-3]
    samples = [100.0 + rng.standard_normal(3) for _ in steps]
    assert after(asked, steps, [samples]) == EVERY[1]


def test_what_seeds_do_to_all_points_alike_is_not_averaged_out():
    """Beds of few seeds leave the height of the whole curve open, however many points there are."""
    rng, asked, found = np.random.default_rng(5), asking("5 %"), []
    steps, held = asked.first(1), []
    for _ in range(400):
        beds = 0.1 * rng.standard_normal(4)
        samples = [100.0 * (1.0 + beds + 0.02 * rng.standard_normal(4)) for _ in steps]
        mean, excess = (own := curve(asked, steps, samples)).excess(asked, np.array([[0.4]]))
        found.append(own.beds)
        held.append(abs(np.exp(mean[0]) / 100.0 - 1.0) < 0.05 * excess[0])
    assert np.mean(held) > 0.92
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(stats.t(3).ppf(0.975) * 0.1 / 2.0, rel=0.1)
    assert after(asked, steps, [samples]) == steps  # only more seeds help


def test_the_order_of_the_runs_does_not_matter():
    """Nor which of two places on other axes comes first."""
    asked, rng = asking(), np.random.default_rng(4)
    steps = asked.first(1)
    one, two = ([bump(s / STEPS) * (1.0 + 0.05 * rng.standard_normal(3)) for s, in steps] for _ in range(2))
    found = after(asked, steps, [one, two])
    assert found == after(asked, steps, [[each[::-1] for each in two], [each[::-1] for each in one]])  # of seeds
    assert len(found) > len(steps)


def test_values_are_on_the_scale_and_have_few_digits():
    own = Refine(refine="log", low=0.1, high=32.0, until="3 %")
    assert [own.values[step] for step, in own.first(1)] == [0.1, 0.423, 1.79, 7.57, 32.0]
    narrow = Refine(refine="linear", low=0.84, high=0.845, until="3 %").values
    assert narrow[64] == 0.8425 and len(set(narrow)) == len(narrow) and narrow == sorted(narrow)
    # three digits tell the last two apart, but one of them would be above high
    over = Refine(refine="linear", low=0.446, high=1.0095, until="3 %").values
    assert over[-2:] == [1.005, 1.0095] and over == sorted(over)


def test_a_refined_sweep_is_as_well_known_as_asked(sweep):
    file = sweep()
    assert "takes 30 runs at least and 240 at most" in summary(Campaign.of(file), 2)
    campaign = of_file(file)
    found = result()
    values = found["cylinder_velocity"].values
    assert found["force"].dims == ("case", "cylinder_velocity", "seed")
    assert 5 < len(values) < 40 and (np.diff(values) > 0.0).all() and values[[0, -1]].tolist() == [0.1, 32.0]
    attrs = found["cylinder_velocity"].attrs
    assert attrs["units"] == "m s-1" and attrs["refined"] == "force within 8 % at 95 %"
    (said,) = campaign.said
    assert float(re.search(r"is ([0-9.]+) times that", said)[1]) <= 1.0 and "raise most" not in said
    assert said in shown(status(Campaign.of(file))) and f"{values[3]:g}" in shown(info(Path("results/peaked/peaked.nc")))
    assert "takes" not in summary(Campaign.of(file), 2)


def test_points_that_reach_the_most_are_said(sweep):
    campaign = of_file(sweep({**ONE, "cylinder.velocity": VELOCITY.replace("8 %", "1 %, most: 8")}))
    assert result().sizes["cylinder_velocity"] == 8
    (said,) = campaign.said
    assert "force within 1 % at 95 %: half the widest interval between 8 points" in said and "raise most, 8" in said


@pytest.mark.parametrize("keys", [ONE, TWO])
def test_a_stopped_sweep_goes_on_to_the_same_points(sweep, keys):
    """Killed twice, in the first round and in a later one, and after another sweep made more seeds."""
    file = sweep(keys)
    of_file(file)
    whole = result().drop_attrs()
    put_aside()
    for runs in (7, 30):
        Path("left").write_text(str(runs))
        with pytest.raises(KeyboardInterrupt):
            of_file(file)
    done = of_file(file)
    xr.testing.assert_equal(result().drop_attrs(), whole)
    again = Campaign.of(file)
    rounds = [[each.block("drag", k).dims + each.block("drag", k).shape for k in each.rounds("drag")] for each in (done, again)]
    assert rounds[0] == rounds[1] and len(rounds[0]) > 2
    if keys == ONE:
        of_file(sweep(keys, seed="1 to 5"))
        of_file(sweep(keys))
        xr.testing.assert_equal(result().drop_attrs(), whole)


@posix
def test_snakemake_makes_the_same_points(sweep):
    of_file(sweep(FEW))
    whole = result().drop_attrs()
    assert 7 < whole.sizes["cylinder_velocity"] < 12  # after two rounds or three
    put_aside()
    words = "-s", ROOT / "Snakefile", "-j2", "results/peaked/peaked.nc"
    ran = snakemake(Path.cwd(), *map(str, words), configfile="sweep.yaml")
    assert ran.returncode == 0, ran.stderr
    xr.testing.assert_equal(result().drop_attrs(), whole)


def test_a_cluster_goes_on_to_the_same_points(sweep, monkeypatch):
    """By a scheduler, whose client stops after a round and is started again."""
    distributed = pytest.importorskip("distributed")
    file = sweep(FEW)
    Path("peaked.py").rename("peaked_afar.py")  # a module that this process has not loaded from elsewhere
    file.write_text(file.read_text().replace("peaked.py", "peaked_afar.py"))
    of_file(file)
    whole = result("peaked_afar").drop_attrs()
    put_aside()
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")
    with cluster as local, distributed.Client(local) as client:
        with monkeypatch.context() as stopping, pytest.raises(KeyboardInterrupt):
            whole_rounds, make_round = [], Campaign._make

            def stop(*words):
                if whole_rounds:
                    raise KeyboardInterrupt
                whole_rounds.append(make_round(*words))

            stopping.setattr(Campaign, "_make", stop)
            dem.run_sweep(file, client)
        assert Campaign.of(file).counts()[0] == 21 < whole["run_id"].size
        with dem.run_sweep(file, client) as found:
            xr.testing.assert_equal(found.load().drop_attrs(), whole)


def test_two_values_have_their_points_together(sweep):
    campaign = of_file(sweep(TWO))
    found, block = result(), campaign.block("drag")
    values = list(zip(found["cylinder_velocity"].values, found["friction_granule"].values, strict=True))
    assert found["force"].dims == ("case", "refined", "seed") and len(set(values)) == len(values) > 9
    corners = {(v, f) for v in (0.1, 32.0) for f in (0.1, 0.8)}
    assert corners <= set(values) and len({v for v, _ in values}) > 3
    # a design has figures that a refined axis, whose points are not spread evenly, has not
    assert "sensitivity" not in possible(block)
    assert "friction.granule" in shown(status(campaign))


def test_a_share_of_a_mean_that_is_not_positive_is_refused_and_the_runs_are_kept(sweep):
    keys = {**ONE, "cylinder.velocity": VELOCITY.replace("force", "offset")}
    with pytest.raises(RunError, match=r"case c1: offset has the mean -.* ask for a number with a unit, such as until: 50 N"):
        of_file(sweep(keys))
    assert Campaign.of(Path("sweep.yaml")).counts() == (30, 30)
    of_file(sweep({**keys, "cylinder.velocity": VELOCITY.replace("force", "offset").replace("8 %", "3 N")}))


@pytest.mark.parametrize(
    "more, words",
    [
        ({"shape": VELOCITY, "case": ""}, "sweep.shape has refine: log; it is no number that may have any value"),
        ({"periodic": VELOCITY}, "sweep.periodic has refine: log; it is no number that may have any value"),
        ({"record.bins": VELOCITY}, "sweep.record.bins has refine: log; it is no number that may have any value"),
        ({"seed": VELOCITY}, "sweep.seed has refine: log; it is no number that may have any value"),
        (
            {"friction.granule": FRICTION, "friction.wall": FRICTION},
            "sweep refines cylinder.velocity, friction.granule, friction.wall; it must refine two values at most",
        ),
        (
            {"friction.granule": FRICTION.replace("8", "5")},
            "sweep.friction.granule asks for force within 5 % at 95 %, with 5 to 40 points; it must be as cylinder.velocity",
        ),
        ({"cylinder.velocity": VELOCITY.replace("32", "0.01")}, "cylinder.velocity: low is 0.1; it must be less than high, 0.01"),
        ({"cylinder.velocity": VELOCITY.replace("32", "0.1")}, "cylinder.velocity: low is 0.1; it must be less than high, 0.1"),
        (
            {"cylinder.velocity": VELOCITY.replace("0.1", "32").replace("high: 32", "high: 32.00000000000001")},
            "cylinder.velocity: low is 32.0; it must leave room for 128 steps to high, 32.00000000000001",
        ),
        ({"cylinder.velocity": VELOCITY.replace("0.1", "0")}, "low is 0; on a log scale it must be above 0"),
        ({"friction.granule": FRICTION.replace("0.1", "-0.1")}, "sweep.friction.granule.low is -0.1; it must be at least 0"),
        (
            {"values": f"{{friction.granule: {FRICTION}}}"},
            "sweep.values.friction.granule has refine, as only a key of a block may; name it there",
        ),
        ({"seed": "3"}, "sweep.seed is 3, and cylinder.velocity is refined; it must list two seeds or more, such as 1 to 4"),
        ({"seed": ""}, "sweep.seed is missing, and cylinder.velocity is refined; it must list two seeds or more"),
        ({"seed": "{until: 5 %, of: force}"}, "and cylinder.velocity is refined; it must list two seeds or more"),
        ({"cylinder.velocity": "{refine: log, low: 0.1, high: 32}"}, "sweep.cylinder.velocity.until is missing"),
        ({"cylinder.velocity": VELOCITY.replace("log", "lgo")}, "velocity.refine is 'lgo'; it must be 'linear' or 'log'"),
        ({"cylinder.velocity": VELOCITY.replace("8 %", "8")}, "velocity.until is 8; it must be a positive number with its unit"),
        ({"cylinder.velocity": VELOCITY.replace("8 %", "8 kg")}, "velocity.until is '8 kg'; it must be a percentage, or a number of N"),
        ({"cylinder.velocity": VELOCITY.replace("force", "forze")}, "forze is no number that these runs record; the nearest is force"),
        ({"cylinder.velocity": VELOCITY.replace("force", "force / c1")}, "of is 'force / c1'; it must be one mean, such as force"),
        ({"cylinder.velocity": VELOCITY.replace("}", ", most: 4}")}, "least is 5, above most, 4"),
        ({"cylinder.velocity": VELOCITY.replace("}", ", least: 2}")}, "velocity.least is 2; it must be at least 3"),
    ],
)
def test_what_cannot_be_refined_is_refused_with_its_key(sweep, more, words):
    """By one sentence, with the status of bad input, and nothing is written."""
    file = sweep(ONE, **more)
    ran = CliRunner().invoke(app, ["sweep", str(file)])
    assert words in ran.stderr and ran.exit_code == 2 and len(ran.stderr.strip().splitlines()) == 1
    assert not Path("results").exists()


def test_values_of_a_derived_block_are_listed(sweep):
    text = sweep().read_text().partition("sweep:")[0]
    first, second = ("case: c1, seed: 1", f"needs: first, case: c1, cylinder.velocity: {VELOCITY}, seed: 1 to 3")
    Path("sweep.yaml").write_text(f"{text}sweep:\n  blocks:\n    first: {{{first}}}\n    second: {{{second}}}\n")
    with pytest.raises(InputError, match=r"second.cylinder.velocity has until, and needs first; list the values"):
        Campaign.of(Path("sweep.yaml"))


def test_a_point_that_failed_is_left_out_of_the_surrogate(sweep):
    """It counts, and no other takes its place."""
    Path("fails").touch()
    file = sweep()
    with pytest.raises(RunError, match="6 of 30 runs could not be made; failures allows 0"):
        of_file(file)
    file.write_text(file.read_text() + "failures: 0.3\n")
    of_file(file)
    found = result()
    assert 1.79 in found["cylinder_velocity"] and len(found["cylinder_velocity"]) > 5
    assert found["force"].sel(cylinder_velocity=1.79).isnull().all()
