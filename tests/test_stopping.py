"""Runs, batches and files that are stopped in the middle, and gone on with."""

import os
import shutil
import socket
import time

import numpy as np
import pytest
from conftest import CONFIG
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.base.files import atomic
from dem.cli.app import app
from dem.experiment import drag
from dem.experiment.resume import checkpoint_of
from dem.io.checksums import seal
from dem.io.results_folder import clear_parts
from dem.studies.config import load, parse
from dem.sweep.batch import batch, settled
from dem.sweep.combine import combine

CLOCKS = ("run_time",)


def smoke(**changes):
    sweep = load(CONFIG / "smoke.yaml")
    data = sweep.model_dump(mode="json", exclude={"accuracy", "claims"}) | changes
    return parse(data)


def simulate(output, checkpoint):
    """A command line that runs one replicate."""
    return ["simulate", "--config", str(CONFIG / "smoke.yaml"), "--shape", "c1", "--density", "3900",
            "--seed", "1", "-o", str(output), "--checkpoint", str(checkpoint)]  # fmt: skip


def stop_after(bins):
    """A progress that stops the run."""

    def progress(done):
        if done >= bins:
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize("shape", ["c1", "d1", "e3"])
def test_a_run_goes_on_from_a_checkpoint_with_the_same_bits(tmp_path, monkeypatch, shape):
    """Stopped at any piece and started again, a run gives what it would have given undisturbed."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    replicate = smoke().replicate(shape, 3.9e3, 1)
    bed, checkpoint = drag.make_bed(replicate), tmp_path / "run.npz"
    whole = drag.run(replicate, bed)
    for bins in (40, 80):
        with pytest.raises(KeyboardInterrupt):
            drag.run(replicate, bed, stop_after(bins), checkpoint=checkpoint)
        assert checkpoint.is_file()
    seen = []
    again = drag.run(replicate, bed, seen.append, checkpoint=checkpoint)
    assert seen[0] > 20
    for name in whole.keys() - set(CLOCKS):
        np.testing.assert_array_equal(whole[name], again[name], err_msg=name)


@pytest.mark.parametrize("writes", [True, False])
def test_a_checkpoint_is_there_until_the_result_is(tmp_path, monkeypatch, writes):
    """What cannot be written, because the disk is full, is not lost."""

    def write(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    checkpoint, output = tmp_path / "run.npz", tmp_path / "run.nc"
    if not writes:
        monkeypatch.setattr(drag, "write_replicate", write)
    result = CliRunner().invoke(app, simulate(output, checkpoint))
    assert result.exit_code == (0 if writes else 1)
    assert (output.exists(), checkpoint.exists()) == (writes, not writes)


def stopped(folder, replicate, bed):
    """A checkpoint of a run that was stopped."""
    checkpoint = folder / "run.npz"
    with pytest.raises(KeyboardInterrupt):
        drag.run(replicate, bed, stop_after(40), checkpoint=checkpoint)
    return checkpoint


DAMAGE = {
    "half": lambda content: content[: len(content) // 2],
    "head only": lambda content: content[:200],
    "empty": lambda content: b"",
    "a flipped bit": lambda content: (
        content[:-5000] + bytes([content[-5000] ^ 1]) + content[-4999:]
    ),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_checkpoint_is_not_used(tmp_path, monkeypatch, capfd, damage):
    """The run then begins again, and says so in one line."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    replicate = smoke().replicate("c1", 3.9e3, 1)
    bed = drag.make_bed(replicate)
    checkpoint = stopped(tmp_path, replicate, bed)
    checkpoint.write_bytes(DAMAGE[damage](checkpoint.read_bytes()))
    seen = []
    again = drag.run(replicate, bed, seen.append, checkpoint=checkpoint)
    assert seen[0] == 20
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1 and "damaged; the run begins again" in said[0]
    np.testing.assert_array_equal(again["drag"], drag.run(replicate, bed)["drag"])


def other_npz(path):
    np.savez(path.with_suffix(".npz"), mark=np.arange(3))
    path.with_suffix(".npz").replace(path)


FOREIGN = {
    "text": lambda path: path.write_text("a note"),
    "array": lambda path: np.save(path.open("wb"), np.arange(3)),
    "another archive": other_npz,
}


@pytest.mark.parametrize("fault", ["another seed", "another bed", *FOREIGN])
def test_a_file_that_is_no_checkpoint_of_the_run_is_refused(tmp_path, monkeypatch, fault):
    """It stays as it is; the workflow's own file is deleted instead, and said so."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    one, two = (smoke().replicate("c1", 3.9e3, seed) for seed in (1, 2))
    bed, checkpoint = drag.make_bed(one), tmp_path / "run.npz"
    if fault in FOREIGN:
        FOREIGN[fault](checkpoint)
    elif fault == "another seed":
        stopped(tmp_path, two, drag.make_bed(two))
    else:
        stopped(tmp_path, one, bed._replace(angle=bed.angle + 1.0))
    before = checkpoint.read_bytes()
    with pytest.raises(InputError, match="delete it or name another file"):
        drag.run(one, bed, checkpoint=checkpoint)
    assert checkpoint.read_bytes() == before


@pytest.mark.parametrize("fault", FOREIGN)
def test_the_command_deletes_no_file_that_it_did_not_write(tmp_path, fault):
    """Status 2 before any work, whatever the file that is given as checkpoint."""
    checkpoint, output = tmp_path / "run.npz", tmp_path / "run.nc"
    FOREIGN[fault](checkpoint)
    before = checkpoint.read_bytes()
    result = CliRunner().invoke(app, simulate(output, checkpoint))
    assert result.exit_code == 2 and "it is no checkpoint" in result.stderr, result.output
    assert checkpoint.read_bytes() == before and not output.exists()


def test_a_stale_checkpoint_of_the_workflow_is_replaced(tmp_path, monkeypatch):
    """After an edit or damage the sweep goes on: its own file is deleted, and said so in one line."""
    monkeypatch.chdir(tmp_path)
    replicate = load(CONFIG / "smoke.yaml").replicate("c1", 3.9e3, 1)
    own = tmp_path / replicate.sweep.results / checkpoint_of(replicate)
    own.parent.mkdir(parents=True)
    FOREIGN["text"](own)
    result = CliRunner().invoke(app, simulate(tmp_path / "run.nc", own))
    assert result.exit_code == 0, result.output
    said = [line for line in result.stderr.splitlines() if "deleted; the run begins again" in line]
    assert len(said) == 1 and not own.exists()


def test_a_batch_leaves_alone_what_is_there(tmp_path):
    """A batch that was stopped makes what is missing, damaged or of other values, and no more."""
    sweep = smoke(seeds=[1, 2, 3], batch=3)
    assert batch(sweep, "c1", 0, tmp_path) == (3 * 2, [])
    files = {each.path: tmp_path / each.path for each in sweep.replicates() if each.label == "c1"}
    stamps = {name: file.stat().st_mtime_ns for name, file in files.items()}
    first, second, *others = files
    files[first].unlink()
    files[second].write_bytes(files[second].read_bytes()[:5000])
    assert batch(sweep, "c1", 0, tmp_path) == (2, [])
    assert all(files[name].stat().st_mtime_ns == stamps[name] for name in others)
    rough = smoke(seeds=[1, 2, 3], batch=3, friction={"granule": 0.2, "wall": 0.2, "cylinder": 0.2})
    assert not any(settled(files[each.path], each) for each in rough.replicates() if each.label == "c1")  # fmt: skip
    with pytest.raises(InputError, match="batch is 1; there are 1"):
        batch(sweep, "c1", 1, tmp_path)


def test_a_batch_gives_the_bits_of_single_runs(tmp_path):
    sweep = smoke(seeds=[1, 2], batch=2)
    batch(sweep, "c1", 0, tmp_path)
    replicate = sweep.replicate("c1", 3.9e4, 2)
    alone = drag.run(replicate, drag.make_bed(replicate))
    from dem.io.dataset import read

    values, _ = read(tmp_path / replicate.path, ("drag", "granule_x", "steps"))
    for name, value in values.items():
        np.testing.assert_array_equal(value, alone[name])


def test_memory_of_combining_does_not_grow_with_the_replicates(tmp_path):
    """Ten times the replicates take less than twice the memory that Python hands out."""
    import tracemalloc

    base = smoke(seeds=[1], cases={"c1": {"shape": "c1", "density": 3.9e3}})
    batch(base, "c1", 0, tmp_path)
    source, peaks = tmp_path / base.replicates()[0].path, []
    for count in (30, 300):
        sweep = smoke(
            seeds=list(range(1, count + 1)), cases={"c1": {"shape": "c1", "density": 3.9e3}}
        )
        for each in sweep.replicates():
            renamed(source, tmp_path / each.path, each)
        files = [tmp_path / each.path for each in sweep.replicates()]
        tracemalloc.start()
        combine(files, sweep, tmp_path / f"drag{count}.nc")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 2.0 * peaks[0]


def renamed(source, target, replicate):
    """A copy of a replicate that says that it is another seed."""
    import netCDF4

    if target != source:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)
    with netCDF4.Dataset(target, "a") as file:
        file["seed"][...] = replicate.seed
        file.run_key = replicate.run_key()
    seal(target)


def test_what_killed_processes_left_is_cleared_away(tmp_path):
    """Half-written files of processes that are no more go, those of living ones stay, and those of other computers for a day."""
    host = socket.gethostname()
    gone = tmp_path / f".a.nc.{host}.{2**22 + 1}.part"
    mine, other = tmp_path / f".b.nc.{host}.{os.getpid()}.part", tmp_path / f".c.nc.{host}x.77.part"
    old = tmp_path / f".d.nc.{host}x.78.part"
    for file in (gone, mine, other, old):
        file.touch()
    os.utime(old, (time.time() - 2e5,) * 2)
    assert clear_parts(tmp_path) == 2
    assert [file.exists() for file in (gone, mine, other, old)] == [False, True, True, False]


def test_a_file_is_written_whole_or_not_at_all(tmp_path):
    file = tmp_path / "file.txt"
    file.write_text("before")
    with pytest.raises(ZeroDivisionError), atomic(file) as part:
        part.write_text("half")
        raise ZeroDivisionError
    with pytest.raises(OSError, match=r"cannot be written .*run the same command again"), atomic(file) as part:  # fmt: skip
        part.write_text("half")
        raise RuntimeError("NetCDF: HDF error")
    assert file.read_text() == "before" and [file] == list(tmp_path.iterdir())
