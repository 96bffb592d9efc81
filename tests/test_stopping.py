"""Runs, batches and files that are stopped in the middle, and gone on with."""

import os
import shutil
import socket
import time

import numpy as np
import pytest
from conftest import CONFIG
from typer.testing import CliRunner

from dem import drag
from dem.batch import batch, settled
from dem.cli import app
from dem.combine import combine
from dem.config import load, parse
from dem.errors import InputError
from dem.files import atomic
from dem.workplace import clear_parts

CLOCKS = ("run_time",)


def smoke(**changes):
    sweep = load(CONFIG / "smoke.yaml")
    data = sweep.model_dump(mode="json", exclude={"accuracy", "claims"}) | changes
    return parse(data)


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
    """What can not be written, because the disk is full, is not lost."""

    def write(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    checkpoint, output = tmp_path / "run.npz", tmp_path / "run.nc"
    if not writes:
        monkeypatch.setattr(drag, "write_replicate", write)
    words = ["simulate", "--config", str(CONFIG / "smoke.yaml"), "--shape", "c1", "--density", "3900", "--seed", "1",
             "-o", str(output), "--checkpoint", str(checkpoint)]  # fmt: skip
    result = CliRunner().invoke(app, words)
    assert result.exit_code == (0 if writes else 1)
    assert (output.exists(), checkpoint.exists()) == (writes, not writes)


@pytest.mark.parametrize("fault", ["another seed", "another bed", "half a file", "no checkpoint"])
def test_a_checkpoint_that_does_not_fit_is_not_used(tmp_path, monkeypatch, fault):
    """The run then begins anew, and says nothing wrong."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    one, two = (smoke().replicate("c1", 3.9e3, seed) for seed in (1, 2))
    checkpoint, other = tmp_path / "run.npz", two if fault == "another seed" else one
    with pytest.raises(KeyboardInterrupt):
        bed = drag.make_bed(other)
        if fault == "another bed":
            bed = bed._replace(angle=bed.angle + 1.0)
        drag.run(other, bed, stop_after(40), checkpoint=checkpoint)
    if fault == "half a file":
        checkpoint.write_bytes(checkpoint.read_bytes()[:1000])
    if fault == "no checkpoint":
        checkpoint.write_text("a note")
    bed, seen = drag.make_bed(one), []
    again = drag.run(one, bed, seen.append, checkpoint=checkpoint)
    assert seen[0] == 20
    np.testing.assert_array_equal(again["drag"], drag.run(one, bed)["drag"])


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
    from dem.dataset import read

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
    with pytest.raises(OSError, match=r"can not be written .*run the same command again"), atomic(file) as part:  # fmt: skip
        part.write_text("half")
        raise RuntimeError("NetCDF: HDF error")
    assert file.read_text() == "before" and [file] == list(tmp_path.iterdir())
