"""Replicates until a mean is known: as many as were asked for, the same however the sweep was made."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from project import quick
from sweeps import drawn, interrupted, made, of_file, order, smoke, varied

import dem
from dem.base.statistics import mean_interval, ratio_interval
from dem.sweep import precision
from dem.sweep.batch_job import make
from dem.sweep.state import SweepState

pytestmark = pytest.mark.usefixtures("folder")


def until(precision="20 %", *cases, of="force", most=60, **more):
    """What varies: replicates until the mean of a drawn number is so well known."""
    return varied(
        *(cases or "ab"), seed={"until": precision, "of": of, "least": 4, "most": most} | more
    )


def result(name="drawn") -> xr.Dataset:
    with dem.open_results(f"results/drawn/{name}.nc") as dataset:
        return dataset.load()


ASKED = {
    "a number with its unit": ("25 N", "force", "95 %"),
    "a share at another level": ("12 %", "force", "80 %"),
    "a ratio at another level": ("50 %", "force / a", "99.9 %"),
}


@quick
@pytest.mark.parametrize("asked", ASKED)
def test_replicates_are_added_until_a_mean_is_known_as_well_as_asked_and_no_longer(asked):
    """Its interval, as test_statistics.py has it, is as narrow as asked for, and was not after the first round."""
    words, of, confidence = stated = ASKED[asked]
    state = of_file(drawn(sweep=until(words, of=of, confidence=confidence, most=200)))
    rounds = [[*state.block("drag", k).counts.values()] for k in state.rounds("drag")]
    dataset = result()
    count, samples = dataset["replicates"], dataset["force"].values
    assert tuple(count.attrs[name] for name in ("until", "of", "confidence")) == stated
    assert rounds[0] == [4, 4] and len(rounds) > 1 and count.values.tolist() == rounds[-1]
    # looking at every interval would stop at the first that is narrow by chance
    for old, new in pairwise(np.array(rounds)):
        assert ((old <= new) & (new <= 2 * old)).all()
    number, unit = words.split()

    def excess(counts):
        """The greatest half interval over what is asked for."""
        one, two = (samples[k, :n] for k, n in enumerate(counts))
        means = mean_interval(one, level), mean_interval(two, level)
        for mean in [ratio_interval(two, one, level)] if "/" in of else means:
            yield mean.half / float(number) / (0.01 * mean.value if unit == "%" else 1.0)

    level = float(confidence.split()[0]) / 100.0
    assert max(excess(rounds[-1])) <= 1.0 and max(excess(rounds[0])) > 0.95
    if "/" in of:
        assert min(rounds[-1]) > 4  # both parts of a ratio get replicates
    # seeds without gaps, and nothing where a point has no replicate
    present = np.arange(int(count.max())) < count.values[:, None]
    np.testing.assert_array_equal(dataset["run_id"] != "", present)
    np.testing.assert_array_equal(dataset["force"].notnull(), present)
    assert dataset["seed"].values.tolist() == list(range(1, present.shape[1] + 1))


@quick
def test_a_mean_of_a_run_is_that_within_the_window():
    """Of bins from 4 to 9 of 12, and snapshots 2 and 3 of 5, also of what has another dimension after them."""
    record = {"bins": 12, "snapshots": 5, "window": [0.4e-3, 1e-3]}
    observables = ["drag", "snapshots", "stress"]
    run = smoke(record=record | {"observables": observables}).replicate("c1", 3900.0, 1)
    for name, count, expected in ("drag", 12, 6.5), ("stress_xx", 5, 2.5), ("granule_x", 5, 2.5):
        row = {name: np.arange(count), "failure": 0}
        assert precision.run_mean(run, name, row) == (expected, "")


@quick
def test_a_stopped_sweep_goes_on_to_the_same_runs():
    """Killed in the first round and in a later one, and after another sweep made more seeds."""
    sweep = until("25 %", most=24)
    of_file(drawn(sweep=sweep))
    whole = result().drop_attrs()
    for name in ("store", "drawn"):
        Path(f"results/{name}").rename(f"{name}-before")
    for runs in (5, 13):
        interrupted(drawn(sweep=sweep), runs)
    old = of_file(Path("sweep.yaml"))
    xr.testing.assert_equal(result().drop_attrs(), whole)
    # Snakemake asks for each round by its number, and would make a round again that is another one now
    fresh = SweepState.of(Path("sweep.yaml"))
    rounds = [[work.block("drag", k).counts for k in work.rounds("drag")] for work in (old, fresh)]
    assert rounds[0] == rounds[1] and len(rounds[0]) > 2
    of_file(drawn(sweep=varied("a", "b", seed="1 to 24")))
    of_file(drawn(sweep=sweep))
    xr.testing.assert_equal(result().drop_attrs(), whole)


def test_blocks_that_share_runs_are_made():
    """The second is planned with runs that a later round of the first takes."""
    seeds = {"one": until()["seed"], "two": "1 to 20"}
    blocks = {name: varied("a", seed=seed) for name, seed in seeds.items()}
    state = SweepState.of(file := drawn(sweep={"blocks": blocks}))
    for _ in state.rounds("one"):  # as Snakemake asks: round by round, all in one process
        state.begin("one")
        for batch in state.batches("one"):
            make(state.store, batch.id)
    assert state.block("one").counts[0,] > 4 and state.near_zero("one", "one") == ""
    assert of_file(file).counts()[0] == len(state.runs()) == len(made())


@quick
def test_a_point_whose_first_runs_fail_gets_more_and_one_whose_all_fail_is_said(capsys):
    """A failed run counts, and is not replaced; it is no number of the sample."""
    fails = [f"300 {seed}" for seed in range(1, 5)] + [f"rough 300 {seed}" for seed in range(1, 9)]
    order(fails=dict.fromkeys(fails, "RunError"))
    rough = until("90 %", "a", "c", most=8) | {"friction.granule": [0.2, 0.5]}
    state = of_file(drawn(sweep=rough, failures=0.9))
    assert result()["replicates"].values.tolist() == [[4, 4], [8, 8]]
    sample = result()["force"].sel(case="c", friction_granule=0.2)
    assert np.isnan(sample).values.tolist() == 4 * [True] + 4 * [False]
    np.testing.assert_array_equal(state.values(state.block("drag"))[1, 0], sample)
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "1 of 4 points" in sentence and "case c, friction_granule 0.5" in sentence
    assert "is not known after 8 replicates" in sentence


@quick
def test_a_point_whose_mean_may_be_zero_is_said_and_all_files_are_written():
    """Also of points that are known well enough. With a number that has a unit it may be."""
    words = r"offset may be zero at 1 of 2 points, .*: case a, is .* after 8 replicates; all files"
    with pytest.raises(dem.RunError, match=words):
        of_file(drawn(sweep=until("10 %", of="offset", most=8)))
    assert result()["replicates"].values.tolist() == [8, 4]
    of_file(drawn(sweep=until("2 N", of="offset")))


@quick
def test_a_sweep_that_varies_seeds_alone_has_one_point():
    """Of one shape, whose point has no axis beside that of the seeds."""
    asked, sample = precision.Until(until="1 %"), np.random.default_rng(1).normal(100.0, 10.0, 10)
    assert precision.counts(asked, {(): sample}, {(): None}) == {(): 20}
