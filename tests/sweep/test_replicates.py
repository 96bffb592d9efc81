"""Replicates until a mean is known: as many as were asked for, the same however the sweep was made.

Runs are numbers drawn from a distribution here, by an experiment in a file of one's own: they cost nothing.
"""

import errno
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from pictures import text_of
from project import posix
from scipy import stats
from sweeps import of_file
from typer.testing import CliRunner
from workflows import snakemake

import dem
from dem.analysis.means import means
from dem.base.errors import InputError
from dem.base.files import lock
from dem.base.source_hash import ROOT
from dem.base.statistics import half_interval, ratio_interval
from dem.cli.app import app
from dem.report.info import summary as summary_of
from dem.report.status import status
from dem.sweep import precision
from dem.sweep.batch import make
from dem.sweep.combine import combine_block
from dem.sweep.estimate import summary
from dem.sweep.state import SweepState

pytestmark = pytest.mark.quick

DRAWN = '''
"""A number drawn from a distribution, of the density as its mean."""
from pathlib import Path

import numpy as np

from dem.base.errors import RunError

SECTIONS = {"cylinder": False, "record": False}
VARIABLES = {"force": ((), "N", "a drawn number"), "offset": ((), "N", "one about zero")}


def run(replicate, bed=None, progress=lambda done: None):
    if replicate.seed == 7 and replicate.density == 300.0:
        raise RunError("this one fails")
    friction = replicate.configuration.friction.granule
    if replicate.density == 400.0 and (replicate.seed <= 10 or friction > 0.4):
        raise RunError("the first fail, or all")
    number = np.random.default_rng([replicate.seed, int(replicate.density)]).standard_normal()
    left = Path("left")  # so many runs until the process is killed
    if left.exists():
        left.write_text(str(int(left.read_text()) - 1))
        if left.read_text() == "-1":
            left.unlink()
            raise KeyboardInterrupt
    offset = number + (50.0 if replicate.density == 200.0 else 0.0)
    return {"force": replicate.density * (1.0 + 0.3 * number), "offset": offset}
'''
SWEEP = """
extends: config/smoke.yaml
results: results/drawn
experiment: drawn.py
shapes:
  c1: {{kind: disc, diameter: 1.0e-3, granules: 60}}
  c2: {{kind: disc, diameter: 1.1e-3, granules: 50}}
cases:
  a: {{shape: c1, density: 100}}
  b: {{shape: c2, density: 200}}  # of other beds
  c: {{shape: c1, density: 300}}
  d: {{shape: c1, density: 400}}
sweep:
  case: {cases}
  seed: {seed}
"""
SEED = "{until: 10 %, of: force, most: 120}"


@pytest.fixture
def sweep(tmp_path, monkeypatch):
    """Writes a sweep file of drawn numbers, in a folder of its own where the test works."""
    monkeypatch.chdir(tmp_path)
    Path("drawn.py").write_text(DRAWN)

    def write(seed=SEED, cases="[a, b]", more=""):
        Path("sweep.yaml").write_text(SWEEP.format(seed=seed, cases=cases) + more)
        return Path("sweep.yaml")

    return write


def result() -> xr.Dataset:
    with dem.open_results("results/drawn/drawn.nc") as dataset:
        return dataset.load()


def table(state) -> str:
    """The table of a sweep's status as text."""
    return text_of(status(state))


def test_replicates_are_added_until_the_mean_is_as_well_known_as_asked(sweep):
    of_file(sweep())
    dataset = result()
    sample, count = dataset["force"], dataset["replicates"]
    asked = "until", "of", "confidence"
    assert [count.attrs[name] for name in asked] == ["10 %", "force", "95 %"]
    assert (count >= 10).all() and (count < 120).all()
    assert (half_interval(sample) <= 0.1 * abs(sample.mean("seed"))).all()
    # seeds without gaps, and nothing where a point has no replicate
    for case in "ab":
        present = dataset["run_id"].sel(case=case).values != ""
        assert present.tolist() == (np.arange(len(present)) < int(count.sel(case=case))).tolist()
        assert (sample.sel(case=case).notnull().values == present).all()
    assert dataset["seed"].values.tolist() == list(range(1, int(count.max()) + 1))


def test_a_round_at_most_doubles_the_replicates(sweep):
    """Looking at every interval would stop at the first that is narrow by chance."""
    state = of_file(sweep("{until: 3 %, of: force, most: 500}"))
    counts = [state.block("drag", k).counts for k in state.rounds("drag")]
    assert counts[0] == {(0,): 10, (1,): 10} and len(counts) > 3
    for old, new in pairwise(counts):
        assert all(old[point] <= new[point] <= 2 * old[point] for point in old)


def test_the_interval_that_is_printed_is_that_of_the_runs(sweep):
    """And not what the replicates were added until, which is wider."""
    of_file(sweep("{until: 50 %, of: force}"))
    path = Path("results/drawn/drawn.nc")
    force = result()["force"].sel(case="a").dropna("seed")
    half = stats.t.ppf(0.975, force.size - 1) * force.std("seed", ddof=1) / np.sqrt(force.size)
    assert float(half) < 0.4 * float(force.mean())
    assert float(means(path)["force_half_interval"].sel(case="a")) == pytest.approx(float(half))
    assert re.search(rf"{float(force.mean()):.5g} +{float(half):.5g}", text_of(summary_of(path)))


def test_a_dry_run_says_how_many_runs_a_precision_takes(sweep):
    file = sweep("{until: 10 %, of: force, most: 120}")
    assert "takes 20 to 240 runs" in summary(SweepState.of(file), 2)


def test_a_stopped_sweep_goes_on_to_the_same_runs(sweep, tmp_path):
    """Killed twice, in the first round and in a later one, and after another sweep made more seeds."""
    seed = "{until: 5 %, of: force, most: 300}"
    of_file(sweep(seed))
    whole = result().drop_attrs()
    for name in ("store", "drawn"):
        Path(f"results/{name}").rename(f"{name}-before")
    for runs in (7, 28):
        Path("left").write_text(str(runs))
        with pytest.raises(KeyboardInterrupt):
            of_file(sweep(seed))
    old = of_file(sweep(seed))
    xr.testing.assert_equal(result().drop_attrs(), whole)
    # Snakemake asks for each round by its number, and would make a round again that is another one now
    fresh = SweepState.of(Path("sweep.yaml"))
    rounds = [[work.block("drag", k).counts for k in work.rounds("drag")] for work in (old, fresh)]
    assert rounds[0] == rounds[1] and len(rounds[0]) > 2
    of_file(sweep("1 to 300"))
    of_file(sweep(seed))
    xr.testing.assert_equal(result().drop_attrs(), whole)


@posix
def test_snakemake_makes_the_same_replicates_and_adds_those_of_a_finer_precision(sweep):
    """Also to a file that is there, of which it does not ask what it was made of."""
    coarse, fine = (f"{{until: {p} %, of: force, least: 4, most: 60}}" for p in (30, 15))
    of_file(sweep(fine))
    whole = result().drop_attrs()
    for name in ("store", "drawn"):
        Path(f"results/{name}").rename(f"{name}-before")
    counts, target = [], "results/drawn/drawn.nc"
    for seed, option in ((coarse, "-j2"), (fine, "-j2"), (fine, "-n")):
        words = "-s", str(ROOT / "Snakefile"), option, target
        process = snakemake(Path.cwd(), *words, configfile=str(sweep(seed)))
        assert process.returncode == 0, process.stderr
        counts.append(int(result()["replicates"].sum()))
    assert "Nothing to be done" in process.stdout + process.stderr
    assert counts[1] > 1.5 * counts[0]
    xr.testing.assert_equal(result().drop_attrs(), whole)


def test_blocks_that_share_runs_are_made(sweep):
    """The second is planned with runs that a later round of the first takes."""
    text = sweep().read_text().partition("sweep:")[0]
    blocks = f"    one: {{case: a, seed: {SEED}}}\n    two: {{case: a, seed: 1 to 30}}\n"
    Path("sweep.yaml").write_text(f"{text}sweep:\n  blocks:\n{blocks}")
    state = SweepState.of(Path("sweep.yaml"))
    for _ in state.rounds("one"):  # as Snakemake asks: round by round, all in one process
        state.begin("one")
        for batch in state.batches("one"):
            make(state.store, batch.id)
    assert state.block("one").counts[0,] > 10 and state.near_zero("one", "one") == ""
    state = of_file(Path("sweep.yaml"))
    assert state.counts()[0] == len(state.runs())


def test_a_point_that_stops_at_the_cap_is_said(sweep, capsys):
    of_file(sweep("{until: 1 %, of: force, most: 12}"))
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "2 of 2 points are not as well known as asked for" in sentence
    assert "after 12 replicates" in sentence
    assert result()["replicates"].values.tolist() == [12, 12]


def test_a_failed_run_counts_and_is_not_replaced(sweep):
    state = of_file(sweep(SEED, "[a, c]", "failures: 0.1\n"))
    dataset = result().sel(case="c")
    present = dataset["run_id"].values != ""
    assert present.sum() == int(dataset["replicates"]) == dataset["force"].count() + 1
    assert np.isnan(dataset["force"].sel(seed=7)) and "1 failed: this one fails" in table(state)
    values = state.values(state.block("drag"))[1,]
    np.testing.assert_array_equal(values, dataset["force"].values[present])


def test_a_point_whose_first_runs_fail_gets_more_and_one_whose_all_fail_is_said(sweep, capsys):
    cases = "[b, d]\n  friction.granule: [0.2, 0.5]"
    of_file(sweep("{until: 20 %, of: force, most: 40}", cases, "failures: 0.9\n"))
    dataset = result().sel(case="d")
    assert dataset["replicates"].values.tolist()[1] == 40
    sample = dataset["force"].sel(friction_granule=0.2).dropna("seed")
    assert sample.size >= 10 and float(half_interval(sample)) <= 0.2 * float(sample.mean())
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "1 of 4 points" in sentence and "case d, friction_granule 0.5" in sentence
    assert "is not known after 40 replicates" in sentence


def test_an_absolute_precision_is_in_the_units_of_what_is_measured(sweep):
    of_file(sweep("{until: 12 N, of: force, most: 200}"))
    assert (half_interval(result()["force"]) <= 12.0).all()
    with pytest.raises(InputError, match="it must be a percentage, or a number of N"):
        SweepState.of(sweep("{until: 12 kg, of: force}"))


@posix
@pytest.mark.parametrize("by", ["dem", "snakemake"])
def test_a_point_whose_mean_may_be_zero_is_said_and_all_files_are_written(sweep, by):
    """Status 1, as of failed runs; also of points that are known well enough."""
    file = str(sweep("{until: 10 %, of: offset, most: 20}"))
    if by == "dem":
        words = [sys.executable, "-m", "dem", "sweep", file, "-j1"]
        run = subprocess.run(words, capture_output=True, text=True, check=False)
    else:
        run = snakemake(Path.cwd(), "-s", str(ROOT / "Snakefile"), "-j1", configfile=file)
    code, text = run.returncode, run.stderr
    assert code == 1 and text.count("may be zero") == 1, text
    words = r"offset may be zero at 1 of 2 points, .*: case a, is .* after 20 replicates; all files"
    assert re.search(words, text), text
    assert result()["replicates"].values.tolist() == [20, 10]
    of_file(sweep("{until: 0.5 N, of: offset}"))


def test_both_parts_of_a_ratio_get_replicates(sweep):
    state = of_file(sweep("{until: 10 %, of: force / a, most: 200}"))
    block = state.block("drag")
    (estimate,) = precision.estimates(block.until, state.values(block), block.partners).values()
    assert precision.excess(estimate, block.until) <= 1.0
    assert block.counts[0,] > 10 and block.counts[1,] > 10
    # of one mean alone fewer would have been enough
    assert block.counts[1,] > of_file(sweep()).block("drag").counts[1,]


def test_fieller_s_interval_is_where_the_difference_is_significant():
    """At its ends r, t of `mean - r reference` is Student's quantile (Fieller 1954)."""
    rng = np.random.default_rng(3)
    above, below = rng.normal(3.0, 0.6, 12), rng.normal(1.0, 0.2, 30)
    interval = ratio_interval(above, below, 0.9)
    ratio = above.mean() / below.mean()
    variances = above.var(ddof=1) / 12, ratio**2 * below.var(ddof=1) / 30
    freedom = sum(variances) ** 2 / (variances[0] ** 2 / 11 + variances[1] ** 2 / 29)
    for end in (interval.low, interval.high):
        spread = np.sqrt(above.var(ddof=1) / 12 + end**2 * below.var(ddof=1) / 30)
        t = abs(above.mean() - end * below.mean()) / spread
        assert stats.t(freedom).cdf(t) == pytest.approx(0.95, abs=1e-12)
    assert interval.low < ratio < interval.high
    # a reference that may be zero leaves the ratio open
    assert ratio_interval(above, below - below.mean(), 0.9).half == np.inf


@pytest.mark.parametrize(
    "seed, words",
    [
        ("{until: 0}", "sweep.seed.until is 0; it must be a positive number with its unit"),
        ("{until: 5}", "sweep.seed.until is 5; it must be a positive number with its unit"),
        ("{until: -5 %}", "sweep.seed.until is '-5 %'; it must be a positive number with its unit"),
        ("{until: 5 %, of: force, most: -1}", "sweep.seed.most is -1; it must be at least 3"),
        ("{until: 5 %, of: force, least: 50, most: 20}", "least is 50, above most, 20"),
        ("{until: 500 %, of: force}", "until is 500 %; it must be below 100 %"),
        ("{until: 5 %, of: force, first: 2147483640}", "the last seed must be below 2147483648"),
        (
            "{until: 5 %, of: forze}",
            "forze is no number that these runs record; the nearest is force",
        ),
        ("{until: 5 %, of: run_time}", "run_time is no number that these runs record"),
        (
            "{until: 5 %, of: force / z}",
            "'z' is no case or shape that this block varies; there are a, b",
        ),
        ("{until: 5 N, of: force / a}", "sweep.seed.until is '5 N'; it must be a percentage"),
        (
            "{until: 5 %, of: force, confidence: 5}",
            "it must be a percentage between 50 % and 99.99 %",
        ),
        ("{untl: 5 %}", "sweep.seed.untl is not a known key; the nearest is until"),
    ],
)
def test_a_precision_that_cannot_be_is_refused_with_its_key(sweep, seed, words):
    with pytest.raises(InputError) as error:
        SweepState.of(sweep(seed))
    assert words in str(error.value)


def test_replicates_of_a_derived_block_are_listed(sweep):
    text = sweep().read_text().partition("sweep:")[0]
    second = f"    second: {{needs: first, case: a, seed: {SEED}}}\n"
    blocks = f"sweep:\n  blocks:\n    first: {{case: a, seed: 1}}\n{second}"
    Path("sweep.yaml").write_text(text + blocks)
    with pytest.raises(InputError, match="seed has until, and needs first; list the seeds"):
        SweepState.of(Path("sweep.yaml"))


def test_status_tells_what_is_done_waits_and_failed_and_changes_nothing(sweep):
    file = sweep(SEED, "[a, c]", "failures: 0.1\nbatch: 4\n")
    assert "waiting: 20." in table(SweepState.of(file)) and not Path("results").exists()
    Path("left").write_text("15")
    with pytest.raises(KeyboardInterrupt):
        of_file(file)
    files = sorted((p, p.stat().st_mtime_ns) for p in Path("results").rglob("*"))
    text = table(SweepState.of(file))
    (names,) = (line.split() for line in text.splitlines() if line.startswith("case "))
    lines = (line.split() for line in text.splitlines() if line.startswith(("a ", "c ")))
    rows = {line[0]: dict(zip(names, line, strict=False)) for line in lines}
    assert sum(int(row["done"]) for row in rows.values()) == 15 and rows["c"]["failed"] == "1", text
    assert "under way: 0, waiting: 4." in text
    assert files == sorted((p, p.stat().st_mtime_ns) for p in Path("results").rglob("*"))


@pytest.mark.parametrize(
    "words",
    [
        "status sweep.yaml",
        "sweep sweep.yaml --dry-run",
        "combine --config sweep.yaml --observable drawn -o part.nc --partial",
    ],
)
@pytest.mark.parametrize("fault", ["damaged", "of another user", "no memory"])
def test_a_command_that_reads_changes_no_file_of_the_store(sweep, monkeypatch, words, fault):
    """Whatever finished runs it cannot read: damaged ones do not count, others are one sentence."""
    Path("left").write_text("15")
    with pytest.raises(KeyboardInterrupt):
        of_file(sweep(more="batch: 4\n"))
    file, *_ = Path("results/store/runs").rglob("*.npz")
    content, opened = file.read_bytes(), open
    if fault == "damaged":
        file.write_bytes(content[:100])

    def open_or_not(path, *rest, **more):
        if fault != "damaged" and Path(str(path)).name == file.name:
            raise {"no memory": MemoryError()}.get(fault, PermissionError(errno.EACCES, "Denied"))
        return opened(path, *rest, **more)

    files = {path: path.read_bytes() for path in Path("results").rglob("*.n*")}
    with monkeypatch.context() as patch:
        patch.setattr("io.open", open_or_not)
        patch.setattr("builtins.open", open_or_not)
        run = CliRunner().invoke(app, words.split())
    assert files == {path: path.read_bytes() for path in Path("results").rglob("*.n*")}
    if fault == "damaged":
        assert run.exit_code == 0, run.output
    else:
        words = {"no memory": "memory is used up."}.get(fault, f"{file.name}: it cannot be read")
        assert run.exit_code == 1 and words in run.stderr, run.output


@posix
def test_status_tells_which_run_a_process_is_at(sweep):
    state = SweepState.of(sweep())
    state.begin("drag")
    run = next(state.block("drag").unique())
    with lock(state.store.run_of(run.id, ".lock")):
        assert "under way: 1, waiting: 19." in table(SweepState.of(Path("sweep.yaml")))
    left = table(SweepState.of(Path("sweep.yaml")))  # the lock is there, and nobody holds it
    assert "under way: 0, waiting: 20." in left


def test_a_partial_file_holds_what_is_there_and_says_so(sweep):
    file = sweep()
    Path("left").write_text("12")
    with pytest.raises(KeyboardInterrupt):
        of_file(file)
    state = SweepState.of(file)
    combine_block(state, "drag", "drawn", Path("part.nc"), partial=True)
    with dem.open_results("part.nc") as part:
        assert part.attrs["partial"] == "12 of 20 runs"
        assert int(part["force"].count()) == 12 == int((part["run_id"] != "").sum())
        assert int(part["replicates"].sum()) == 12


def test_sizes_may_not_name_the_granules(sweep):
    """Whose number each run has of its own: refused before any run."""
    sizes = 'SIZES = {"granule": 5}\nVARIABLES = {"each": (("granule",), "N", "of each"), '
    Path("drawn.py").write_text(DRAWN.replace("VARIABLES = {", sizes))
    with pytest.raises(InputError, match="SIZES has granule, the number of granules of a run"):
        SweepState.of(sweep())


@pytest.mark.parametrize("name", ["null", '""', '" "'])
def test_points_of_a_group_have_names(sweep, name):
    points = f"  rough:\n    {name}: {{friction.granule: 0.3}}\n    b: {{friction.granule: 0.4}}\n"
    with pytest.raises(InputError, match=r"sweep.rough has a point without a name; give it one"):
        SweepState.of(sweep(more=points))


def test_a_sweep_that_varies_seeds_alone_has_one_point():
    """Of one shape, whose point has no axis beside that of the seeds."""
    until, sample = precision.Until(until="1 %"), np.random.default_rng(1).normal(100.0, 10.0, 10)
    assert precision.counts(until, {(): sample}, {(): None}) == {(): 20}
