"""Runs and batches of the store that are stopped in the middle, damaged, or cannot be read."""

import time
import tracemalloc
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from command_line import called
from project import quick
from sweeps import (
    CLOCKS,
    Killed,
    bytes_of_results,
    contents,
    drawn,
    interrupted,
    killed_at,
    made,
    of_file,
    simulate,
    smoke,
    varied,
)

import dem
from dem.experiment.bed import make_bed
from dem.sweep.batch_job import make
from dem.sweep.combine import combine_block
from dem.sweep.state import SweepState

pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture
def hurried(monkeypatch):
    """A run saves itself once a minute, and minutes are short."""
    clock = time.monotonic
    monkeypatch.setattr("time.monotonic", lambda: 1e6 * clock())


@quick
def test_a_run_goes_on_from_a_checkpoint_with_the_same_bits(hurried):
    """Stopped at any piece and started again, a run gives what it would have given undisturbed."""
    record = smoke().dump()["record"] | {"observables": ["drag", "snapshots", "stress"]}
    replicate = smoke(record=record).replicate("c1", 3.9e3, 1)
    bed, checkpoint = make_bed(replicate.bed_description), Path("run.npz")
    run = replicate.configuration.module.run
    whole = run(replicate, bed)
    for share in (0.3, 0.6):
        with pytest.raises(Killed):
            run(replicate, bed, killed_at(share), checkpoint=checkpoint)
    progress = []
    resumed = run(replicate, bed, progress.append, checkpoint=checkpoint)
    assert progress[0] > 0.6
    for name in whole.keys() - CLOCKS:
        np.testing.assert_array_equal(whole[name], resumed[name], err_msg=name)


REPLACE = Path.replace


def full(part, target):
    """Path.replace of a disk that has no room for results."""
    if target.suffix == ".nc":
        raise OSError("the disk is full")
    return REPLACE(part, target)


@quick
def test_a_checkpoint_is_there_until_the_result_is(hurried):
    """What cannot be written, because the disk is full, is not lost; nor is that of another run, which is refused
    before any work. Damaged ones are in bad_input.py."""
    checkpoint, output = Path("run.npz"), Path("run.nc")
    command = simulate(output, f"--checkpoint {checkpoint}")
    two = smoke().replicate("c1", 3.9e3, 2)
    with pytest.raises(Killed):
        two.configuration.module.run(two, None, killed_at(0.3), checkpoint=checkpoint)
    content = checkpoint.read_bytes()
    words = "run.npz: it is no checkpoint of this run, or damaged; delete it or name another file"
    assert words in called(command).stderr and checkpoint.read_bytes() == content
    checkpoint.unlink()
    for put, status in (full, 1), (REPLACE, 0):
        with mock.patch.object(Path, "replace", put):
            assert called(command).exit_code == status
        assert (output.exists(), checkpoint.exists()) == (not status, status)


@quick
@pytest.mark.parametrize("kind", ["runs", "checkpoint", "beds", "batches"])
def test_what_cannot_be_read_now_is_left_alone(monkeypatch, kind):
    """One sentence; no file is deleted, renamed, changed or made again, and later all go on."""
    state = interrupted(drawn(observed=True), 1)
    if kind == "batches":
        of_file(Path("sweep.yaml"))
    count, (batch,) = len(made()), state.batches("drag")

    def opened(path, *rest, **more):
        if kind in (name := str(path)) and name.endswith((".nc", ".npz")):
            raise OSError(5, "Input/output error")
        return really(path, *rest, **more)

    really, files = open, bytes_of_results()
    with monkeypatch.context() as patch:
        patch.setattr("io.open", opened)
        patch.setattr("netCDF4.Dataset", opened)
        words = rf"{kind}.*: it cannot be read \(Input/output error\); mend"
        with pytest.raises(OSError, match=words):
            make(state.store, batch.id)
    assert files == bytes_of_results()
    assert len(made()) == count
    make(state.store, batch.id)
    assert len(made()) == 4


@quick
def test_runs_are_kept_until_their_batch_is_there():
    """What the disk has no room for is not made again."""
    file = drawn()
    with mock.patch.object(Path, "replace", full), pytest.raises(OSError, match="the disk is full"):
        of_file(file)
    of_file(file)
    assert len(made()) == 4


@quick
@pytest.mark.parametrize("content", ["", "[]", "other code"])
def test_a_plan_that_is_damaged_or_of_other_code_is_refused(content):
    """In one sentence, before any run: its runs would be called what they are not. It is planned again when the
    sweep starts again."""
    state = SweepState.of(drawn())
    state.begin("drag")
    plan, first = state.store.plan_of(state.batches("drag")[0].id), state.block("drag").first.id
    if content == "other code":
        content = plan.read_text().replace(first, first[::-1])
    plan.write_text(content)
    words = rf"{plan}: it is no plan of a batch for this version of the code .*; start the sweep"
    with pytest.raises(dem.InputError, match=words):
        make(state.store, plan.stem)
    assert not made()
    of_file(Path("sweep.yaml"))
    assert len(made()) == 4


@quick
def test_a_plan_has_once_what_its_runs_share():
    """A bed of thousands of granules from a file would else be written for each of them."""
    sizes = []
    for count in (1, 9):
        state = SweepState.of(drawn(sweep=varied("a", seed=f"1 to {count}"), batch=9))
        state.begin("drag")
        (batch,) = state.batches("drag")
        sizes.append(state.store.plan_of(batch.id).stat().st_size)
    assert sizes[1] < 2 * sizes[0]


def test_memory_of_combining_does_not_grow_with_the_runs():
    """The memory that Python hands out grows by less than what 20 more runs have."""
    record, peaks = {"bins": 1200, "snapshots": 3, "observables": ["drag"]}, []
    for count in (5, 25):
        sweep = varied("a", seed=f"1 to {count}")
        state = of_file(drawn(observed=True, sweep=sweep, batch=10, record=record))
        tracemalloc.start()
        combine_block(state, "drag", "drag", Path("again.nc"))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    batch = contents(state.files("drag")[-1])
    of_run = sum(values[0].nbytes for values in batch.values() if len(values) == 10)
    assert peaks[1] - peaks[0] < 20 * of_run
