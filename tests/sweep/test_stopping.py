"""Runs, chunks and files that are stopped in the middle, and gone on with."""

import errno
import os
import socket
import time
from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest
from sweeps import (
    CLOCKS,
    Killed,
    combined,
    contents,
    differing,
    discs,
    killed_at,
    planned,
    simulate,
    smoke,
)
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.base.files import atomic
from dem.cli.app import app
from dem.experiment.bed import make_bed
from dem.experiment.kinds import drag
from dem.experiment.run import Replicate
from dem.io.dataset import read
from dem.sweep import batch as making
from dem.sweep.restart import clear_parts
from dem.sweep.state import SweepState
from dem.sweep.store import Store


@pytest.mark.quick
@pytest.mark.parametrize("shape", ["c1", "d1", "e3"])
def test_a_run_goes_on_from_a_checkpoint_with_the_same_bits(tmp_path, monkeypatch, shape):
    """Stopped at any piece and started again, a run gives what it would have given undisturbed."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    observables = ["drag", "snapshots", "stress"]
    record = smoke().dump()["record"] | {"observables": observables}
    replicate = smoke(record=record).replicate(shape, 3.9e3, 1)
    bed, checkpoint = make_bed(replicate), tmp_path / "run.npz"
    whole = drag.run(replicate, bed)
    for share in (0.3, 0.6):
        with pytest.raises(Killed):
            drag.run(replicate, bed, killed_at(share), checkpoint=checkpoint)
        assert checkpoint.is_file()
    progress = []
    resumed = drag.run(replicate, bed, progress.append, checkpoint=checkpoint)
    assert progress[0] > 0.2
    for name in whole.keys() - CLOCKS:
        np.testing.assert_array_equal(whole[name], resumed[name], err_msg=name)


@pytest.mark.quick
@pytest.mark.parametrize("writes", [True, False])
def test_a_checkpoint_is_there_until_the_result_is(tmp_path, monkeypatch, writes):
    """What cannot be written, because the disk is full, is not lost."""

    def write(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    checkpoint, output = tmp_path / "run.npz", tmp_path / "run.nc"
    if not writes:
        monkeypatch.setattr(making, "write_one", write)
    result = CliRunner().invoke(app, simulate(output, "--checkpoint", checkpoint))
    assert result.exit_code == (0 if writes else 1)
    assert (output.exists(), checkpoint.exists()) == (writes, not writes)


def stopped(folder, replicate, bed):
    """A checkpoint of a run that was stopped."""
    checkpoint = folder / "run.npz"
    with pytest.raises(Killed):
        drag.run(replicate, bed, killed_at(0.3), checkpoint=checkpoint)
    return checkpoint


DAMAGE = {
    "half": lambda content: content[: len(content) // 2],
    "empty": lambda content: b"",
    "zeros": lambda content: bytes(len(content)),
    "another head": lambda content: b"x" + content,
    "overwritten": lambda content: (
        content[: len(content) // 2] + b"\xff" * 1000 + content[len(content) // 2 + 1000 :]
    ),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_checkpoint_that_the_user_names_is_refused(tmp_path, monkeypatch, damage):
    """It stays as it is."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    replicate = smoke().replicate("c1", 3.9e3, 1)
    bed = make_bed(replicate)
    checkpoint = stopped(tmp_path, replicate, bed)
    content = DAMAGE[damage](checkpoint.read_bytes())
    checkpoint.write_bytes(content)
    with pytest.raises(InputError, match="or damaged; delete it or name another file"):
        drag.run(replicate, bed, checkpoint=checkpoint)
    assert checkpoint.read_bytes() == content


FOREIGN = {
    "text": lambda path: path.write_text("a note"),
    "array": lambda path: np.save(path.open("wb"), np.arange(3)),
    "another archive": lambda path: np.savez(path.open("wb"), mark=np.arange(3)),
}


def test_a_checkpoint_of_another_run_is_refused(tmp_path, monkeypatch):
    """It stays as it is."""
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    one, two = (smoke().replicate("c1", 3.9e3, seed) for seed in (1, 2))
    checkpoint = stopped(tmp_path, two, make_bed(two))
    content = checkpoint.read_bytes()
    with pytest.raises(InputError, match="delete it or name another file"):
        drag.run(one, make_bed(one), checkpoint=checkpoint)
    assert checkpoint.read_bytes() == content


@pytest.mark.parametrize("fault", FOREIGN)
def test_the_command_deletes_no_file_that_it_did_not_write(tmp_path, fault):
    """Status 2 before any work, whatever the file that is given as checkpoint."""
    checkpoint, output = tmp_path / "run.npz", tmp_path / "run.nc"
    FOREIGN[fault](checkpoint)
    content = checkpoint.read_bytes()
    result = CliRunner().invoke(app, simulate(output, "--checkpoint", checkpoint))
    assert result.exit_code == 2 and "it is no checkpoint" in result.stderr, result.output
    assert checkpoint.read_bytes() == content and not output.exists()


@pytest.fixture
def attempts(monkeypatch):
    """Seeds and densities of the runs that begin, and the share that is done when they first tell."""
    attempts, run = [], drag.run

    def running(replicate, bed, progress, *rest, **more):
        attempts.append((replicate.seed, replicate.density, shares := []))
        return run(replicate, bed, lambda s: (shares.append(s), progress(s)), *rest, **more)

    monkeypatch.setattr(drag, "run", running)
    monkeypatch.setattr(drag, "SAVED_EVERY", 0.0)
    return attempts


@pytest.mark.quick
def test_a_chunk_that_is_stopped_goes_on_with_the_run_under_way(tmp_path, attempts):
    """Finished runs are kept and the one under way goes on from its checkpoint; bits are the same."""
    sweep = discs([1, 2])  # four runs, of which one and a half are done
    whole, chunk = planned(sweep, tmp_path / "whole")
    making.make(whole.store, chunk)
    work, same_chunk = planned(sweep, tmp_path / "stopped")
    assert same_chunk == chunk
    attempts.clear()
    with pytest.raises(Killed):
        making.make(work.store, chunk, progress=killed_at(1.5))
    first, second = (key for *key, _ in attempts)
    assert not work.store.file_of(chunk).exists()
    attempts.clear()
    making.make(work.store, chunk)
    begun = [key for *key, _ in attempts]
    assert begun[0] == second and first not in begun and len(begun) == 3
    assert attempts[0][2][0] > 0.2  # not from its start
    files = (store.file_of(chunk) for store in (whole.store, work.store))
    assert differing(*map(contents, files)) == []
    left = [path for path in (work.store.folder / "runs").rglob("*") if path.is_file()]
    assert left == []


@pytest.mark.quick
def test_a_chunk_that_cannot_be_written_loses_no_run(tmp_path, attempts, monkeypatch):
    """Runs are forgotten after the file that holds them is there, and not before."""

    def killed(*_):
        raise Killed

    work, chunk = planned(discs([1]), tmp_path)
    with monkeypatch.context() as patch, pytest.raises(Killed):
        patch.setattr(making, "write_batch", killed)
        making.make(work.store, chunk)
    assert len(attempts) == 2
    making.make(work.store, chunk)
    assert len(attempts) == 2 and work.store.file_of(chunk).is_file()


@pytest.mark.quick
def test_a_chunk_that_is_there_is_left_alone(tmp_path, attempts):
    """One that is damaged is made again, and one that is wanted again is."""
    work, chunk = planned(discs([1]), tmp_path)
    path = making.make(work.store, chunk)
    stamp = path.stat().st_mtime_ns
    attempts.clear()
    making.make(work.store, chunk)
    assert path.stat().st_mtime_ns == stamp and not attempts
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    making.make(work.store, chunk)
    assert len(attempts) == 2
    read(path, ("drag",))
    path.unlink()
    making.make(work.store, chunk)
    assert len(attempts) == 4


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("kind", ["runs", "beds", "checkpoints of runs", "checkpoints of beds"])
def test_a_damaged_file_of_the_store_is_put_aside_and_made_again(
    tmp_path, attempts, capfd, kind, damage
):
    """Its bytes stay under another name, one line says so, and results are as if there was no damage."""
    sweep = discs([1])
    whole, chunk = planned(sweep, tmp_path / "whole")
    making.make(whole.store, chunk)
    work, _ = planned(sweep, tmp_path / "stopped")
    with pytest.raises(Killed):
        making.make(work.store, chunk, progress=killed_at(1.4))
    paths = (work.store.folder / kind.split()[-1]).rglob("[!.]*.npz")
    of_run = kind == "checkpoints of runs"
    (file,) = (path for path in paths if ("checkpoint" in path.name) == of_run)
    if kind == "checkpoints of beds":
        file = file.rename(file.with_suffix(".checkpoint.npz"))
    content = DAMAGE[damage](file.read_bytes())
    file.write_bytes(content)
    attempts.clear()
    capfd.readouterr()
    making.make(work.store, chunk)
    assert len(attempts) == (2 if kind == "runs" else 1)
    aside = file.with_name(f"{file.name}.damaged")
    (line,) = capfd.readouterr().err.splitlines()
    assert aside.read_bytes() == content and line.startswith(f"{file}: ") and aside.name in line
    files = (store.file_of(chunk) for store in (whole.store, work.store))
    assert differing(*map(contents, files)) == []


CANNOT = {
    "of another user": PermissionError(errno.EACCES, "Permission denied"),
    "no free file descriptor": OSError(errno.EMFILE, "Too many open files"),
    "a disk at fault": OSError(errno.EIO, "Input/output error"),
    "a disk of the network that is away": OSError(errno.ESTALE, "Stale file handle"),
    "no memory": MemoryError("Unable to allocate 8 GiB"),
}


@pytest.mark.parametrize("cannot", CANNOT)
@pytest.mark.parametrize("kind", ["runs", "checkpoint", "beds", "batches"])
def test_what_cannot_be_read_now_is_not_damaged(tmp_path, attempts, monkeypatch, kind, cannot):
    """One sentence; no file is deleted, renamed, changed or made again, and later all go on."""
    work, chunk = planned(discs([1]), tmp_path)
    with suppress(Killed):
        making.make(work.store, chunk, progress=killed_at(2.1 if kind == "batches" else 1.4))
    attempts.clear()
    files = {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file() and p.suffix != ".lock"}
    error, opened = CANNOT[cannot], open

    def open_or_not(path, *rest, **more):
        name = str(path)
        if kind in name and name.endswith((".nc", ".npz")) and "part" not in name:
            raise error
        return opened(path, *rest, **more)

    def dataset(*_):
        raise error if isinstance(error, MemoryError) else HDF  # which names no reason

    with monkeypatch.context() as patch, pytest.raises((OSError, MemoryError)) as raised:
        patch.setattr("builtins.open", open_or_not)
        patch.setattr("io.open", open_or_not)
        patch.setattr("netCDF4.Dataset", dataset)
        making.make(work.store, chunk)
    assert {path: path.read_bytes() for path in files} == files
    assert not list(tmp_path.rglob("*.damaged"))
    if isinstance(error, OSError):
        words = f"it cannot be read ({error.strerror}); mend that and run the same command again."
        assert str(raised.value).endswith(words) and kind in str(raised.value)
    making.make(work.store, chunk)
    assert len(attempts) == (0 if kind == "batches" else 1)


def test_a_plan_of_other_code_is_refused(tmp_path, monkeypatch):
    """In one sentence, before any run: its runs would be called what they are not."""
    work, chunk = planned(discs([1]), tmp_path)
    monkeypatch.setattr(Replicate, "source_hash", "other")
    with pytest.raises(
        InputError, match=r"no plan of a batch for this version of the code .*; start the sweep"
    ):
        making.make(work.store, chunk)


@pytest.mark.parametrize(
    "content", ["", "{", "[]", "{}", '{"values": [], "of": [[0, {}]], "runs": []}']
)
def test_a_damaged_plan_is_refused(tmp_path, content):
    """And planned again when the sweep starts again; one that is not there is named."""
    sweep = discs([1])
    work, chunk = planned(sweep, tmp_path)
    work.store.plan_of(chunk).write_text(content)
    for _ in range(2):
        with pytest.raises(InputError, match=f"{chunk}.json: it is no plan of a batch"):
            work.store.replicates(chunk)
        work.store.plan_of(chunk).unlink(missing_ok=True)
    work.store.plan_of(chunk).write_text(content)
    assert planned(sweep, tmp_path)[0].store.replicates(chunk)


def test_memory_of_combining_does_not_grow_with_the_runs(tmp_path):
    """The memory that Python hands out grows by less than what 45 more runs have."""
    import tracemalloc

    record = smoke().dump()["record"] | {"observables": ["drag"]}
    work, chunk = planned(discs([1], record=record), tmp_path)
    names = tuple(making.layout_of(work.store.replicates(chunk)[0]))
    values, _ = read(making.make(work.store, chunk), names)
    row, peaks = {name: value[0] for name, value in values.items() if len(value) == 2}, []
    for count in (5, 50):
        sweep = discs(f"1 to {count}", batch=10, record=record)
        many = SweepState(sweep, Store(tmp_path / f"store{count}"), root=tmp_path)
        for batch in many.batches("drag"):
            runs = [run for run in sweep.block("drag").unique() if run.id in batch.runs]
            making.write_batch(many.store.file_of(batch.id), runs, [row] * len(runs))
        tracemalloc.start()
        combined(many, tmp_path)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] - peaks[0] < 45 * sum(np.asarray(value).nbytes for value in row.values())


@pytest.mark.quick
def test_what_killed_processes_left_is_cleared_away(tmp_path):
    """Half-written files of processes that are no more go, those of living ones stay, and those of
    other computers for a day. What anybody else left is not touched, however old it is."""
    with atomic(tmp_path / "a.nc") as part:
        part_file = tmp_path / part.name
        part.touch()
    end, dead = f".{os.getpid()}.", f".{2**22 + 1}."
    stale = tmp_path / part_file.name.replace(end, dead)
    host = socket.gethostname()
    other, old = (tmp_path / part_file.name.replace(host, name) for name in ("one", f"x{host}.org"))
    names = "notes.part", ".thesis.doc.part", ".77.dem.part", f"a.nc.host{dead}dem.part"
    left = [tmp_path / name for name in names]
    for file in (stale, part_file, other, old, *left):
        file.touch()
    for file in (stale, old, *left):
        os.utime(file, (time.time() - 2e5,) * 2)
    assert clear_parts(tmp_path) == 2
    assert [file.exists() for file in (stale, part_file, other, old)] == [False, True, True, False]
    assert all(file.exists() for file in left)


FULL = OSError(errno.ENOSPC, "No space left on device")
HDF = RuntimeError("NetCDF: HDF error")  # all that netCDF says


@pytest.mark.quick
@pytest.mark.parametrize(
    ("error", "free", "words"),
    [
        (ZeroDivisionError("a fault"), 10**9, "a fault"),
        (HDF, 10**9, "file.txt: it cannot be written .*run the same command again"),
        (HDF, 0, r"file.txt: .* \(the disk is full\)"),
        (FULL, 0, r"file.txt: .* \(the disk is full\)"),
    ],
)
def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch, error, free, words):
    """What is wrong with the disk is one sentence, whatever netCDF says of it."""
    monkeypatch.setattr("shutil.disk_usage", lambda folder: SimpleNamespace(free=free))
    file = tmp_path / "file.txt"
    file.write_text("before")
    kind = ZeroDivisionError if words == "a fault" else OSError
    with pytest.raises(kind, match=words), atomic(file) as part:
        part.write_text("half")
        raise error
    assert file.read_text() == "before" and [file] == list(tmp_path.iterdir())


def test_a_file_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    """Else the name may be that of a file of zeros when power fails."""
    file, named = tmp_path / "file.txt", []
    monkeypatch.setattr("os.fsync", lambda fd: named.append((os.fstat(fd).st_size, file.exists())))
    with atomic(file) as part:
        part.write_text("whole")
    assert named == [(5, False)] and file.read_text() == "whole"
