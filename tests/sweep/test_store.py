"""Runs and batches of the store that are stopped in the middle, damaged, or cannot be read."""

import time
import tracemalloc
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from sweeps import (
    CLOCKS,
    Killed,
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
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.cli.app import app
from dem.experiment.bed import make_bed
from dem.sweep.batch import make
from dem.sweep.state import SweepState


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def hurried(monkeypatch):
    """A run saves itself once a minute, and minutes are short."""
    clock = time.monotonic
    monkeypatch.setattr("time.monotonic", lambda: 1e6 * clock())


@pytest.mark.parametrize("shape", [pytest.param("c1", marks=pytest.mark.quick), "d1", "e3"])
def test_a_run_goes_on_from_a_checkpoint_with_the_same_bits(hurried, shape):
    """Stopped at any piece and started again, a run gives what it would have given undisturbed."""
    record = smoke().dump()["record"] | {"observables": ["drag", "snapshots", "stress"]}
    replicate = smoke(record=record).replicate(shape, 3.9e3, 1)
    bed, checkpoint = make_bed(replicate), Path("run.npz")
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


@pytest.mark.quick
@pytest.mark.parametrize("full", [False, True])
def test_a_checkpoint_is_there_until_the_result_is(hurried, full):
    """What cannot be written, because the disk is full, is not lost."""
    checkpoint, output, replace = Path("run.npz"), Path("run.nc"), Path.replace

    def put(part, target):
        if full and target.suffix == ".nc":
            raise OSError("the disk is full")
        return replace(part, target)

    with mock.patch.object(Path, "replace", put):
        result = CliRunner().invoke(app, simulate(output, "--checkpoint", checkpoint))
    assert result.exit_code == full, result.output
    assert (output.exists(), checkpoint.exists()) == (not full, full)


NO_CHECKPOINTS = {
    "half": lambda content: content[: len(content) // 2],
    "empty": lambda content: b"",
    "overwritten": lambda content: content[:9000] + b"\xff" * 1000 + content[10000:],
    "a note": lambda content: b"a note",
    "of another run": lambda content: content,
}


def test_a_file_that_is_no_checkpoint_of_the_run_is_refused_and_stays(hurried):
    """Status 2 before any work."""
    checkpoint, output = Path("run.npz"), Path("run.nc")
    two = smoke().replicate("c1", 3.9e3, 2)
    with pytest.raises(Killed):
        two.configuration.module.run(two, None, killed_at(0.3), checkpoint=checkpoint)
    whole = checkpoint.read_bytes()
    for name, change in NO_CHECKPOINTS.items():
        checkpoint.write_bytes(content := change(whole))
        result = CliRunner().invoke(app, simulate(output, "--checkpoint", checkpoint))
        words = (
            "run.npz: it is no checkpoint of this run, or damaged; delete it or name another file"
        )
        assert result.exit_code == 2 and words in result.stderr, (name, result.output)
        assert checkpoint.read_bytes() == content and not output.exists()


@pytest.mark.quick
@pytest.mark.parametrize("kind", ["runs", "checkpoint", "beds", "batches"])
def test_what_cannot_be_read_now_is_left_alone(monkeypatch, kind):
    """One sentence; no file is deleted, renamed, changed or made again, and later all go on."""
    state = interrupted(drawn(observed=True), 1)
    if kind == "batches":
        of_file(Path("sweep.yaml"))
    count, (batch,) = len(made()), state.batches("drag")
    files = {path: path.read_bytes() for path in Path("results").rglob("*.n*")}
    with monkeypatch.context() as patch:
        patch.setattr("io.open", unless(kind, open))
        patch.setattr("builtins.open", unless(kind, open))
        patch.setattr("netCDF4.Dataset", unless(kind, None))
        with pytest.raises(
            OSError, match=rf"{kind}.*: it cannot be read \(Input/output error\); mend"
        ):
            make(state.store, batch.id)
    assert files == {path: path.read_bytes() for path in Path("results").rglob("*.n*")}
    assert len(made()) == count
    make(state.store, batch.id)
    assert len(made()) == 4


def unless(kind, opened):
    """A disk that cannot read files of a kind."""

    def open_or_not(path, *rest, **more):
        name = str(path)
        if kind in name and name.endswith((".nc", ".npz")) and "part" not in name:
            raise OSError(5, "Input/output error")
        return opened(path, *rest, **more)

    return open_or_not


@pytest.mark.quick
def test_a_damaged_file_is_put_aside_and_said_once(capsys):
    """Its bytes stay under another name, and the run that it held is made again."""
    state = interrupted(drawn(observed=True), 2)
    for path in state.store.files():
        if path.suffix == ".npz":
            path.write_bytes(path.read_bytes()[:100])
    capsys.readouterr()
    of_file(Path("sweep.yaml"))
    lines = capsys.readouterr().err.splitlines()
    aside = sorted(state.store.folder.rglob("*.damaged"))
    assert (
        len(lines) == len(aside) == 6 and len(made()) == 6
    )  # two runs, a checkpoint and three beds
    for path in aside:
        words = f"{path.with_suffix('')}: it is damaged, and kept as {path.name}; it is made again."
        assert any(line.endswith(words) for line in lines) and len(path.read_bytes()) == 100


@pytest.mark.quick
def test_runs_are_kept_until_their_batch_is_there():
    """What the disk has no room for is not made again."""
    file, replace = drawn(), Path.replace

    def put(part, target):
        if target.suffix == ".nc":
            raise OSError("the disk is full")
        return replace(part, target)

    with mock.patch.object(Path, "replace", put), pytest.raises(OSError, match="the disk is full"):
        of_file(file)
    of_file(file)
    assert len(made()) == 4


PLANS = ["", "[]", '{"values": [], "of": [[0, {}]], "runs": []}', "other code", "none"]


@pytest.mark.quick
@pytest.mark.parametrize("content", PLANS)
def test_a_plan_that_is_damaged_or_of_other_code_is_refused(content):
    """In one sentence, before any run: its runs would be called what they are not. It is planned again when the
    sweep starts again."""
    state = SweepState.of(drawn())
    state.begin("drag")
    plan = state.store.plan_of(state.batches("drag")[0].id)
    if content == "other code":
        first = state.block("drag").first.id
        plan.write_text(plan.read_text().replace(first, first[::-1]))
    elif content == "none":
        plan.unlink()
    else:
        plan.write_text(content)
    words = rf"{plan}: it is no plan of a batch for this version of the code .*; start the sweep"
    with pytest.raises(InputError, match=words):
        make(state.store, plan.stem)
    assert not made()
    of_file(Path("sweep.yaml"))
    assert len(made()) == 4


def test_memory_of_combining_does_not_grow_with_the_runs():
    """The memory that Python hands out grows by less than what 20 more runs have."""
    record, peaks = {"bins": 1200, "snapshots": 3, "observables": ["drag"]}, []
    for count in (5, 25):
        sweep = varied("a", seed=f"1 to {count}")
        state = of_file(drawn(observed=True, sweep=sweep, batch=10, record=record))
        Path("results/drawn/drag.nc").unlink()
        tracemalloc.start()
        of_file(Path("sweep.yaml"))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    batch = contents(state.files("drag")[-1])
    of_run = sum(values[0].nbytes for values in batch.values() if len(values) == 10)
    assert peaks[1] - peaks[0] < 20 * of_run
