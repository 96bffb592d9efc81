"""What goes wrong around a sweep: runs that fail, a folder that others use, clocks, Ctrl-C."""

import errno
import io
import os
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest
from pictures import assert_not_blank
from project import CONFIG, posix
from rich.console import Console
from sweeps import Killed, combined, discs, killed_at, planned, simulate, smoke
from typer.testing import CliRunner

from dem.analysis.drag import change, summarise
from dem.base.errors import InputError, OverlapError, PackingError, RunError
from dem.base.files import atomic
from dem.cli.app import app
from dem.experiment.bed import make_bed
from dem.experiment.kinds import drag
from dem.figures.catalogue import draw
from dem.io.dataset import read
from dem.io.lazily import open_lazily
from dem.io.progress import span
from dem.report.build import build
from dem.report.info import summary
from dem.sweep import batch as making
from dem.sweep import state as working
from dem.sweep.combine import combine_block
from dem.sweep.config import save
from dem.sweep.estimate import summary as estimated
from dem.sweep.restart import prepare
from dem.sweep.state import SweepState
from dem.sweep.store import Store
from dem.sweep.workers import Workers


@pytest.fixture
def two_fail(monkeypatch):
    """The bed of seed 2, and the run of seed 3 at the higher density, fail; how often they are tried."""
    attempts, make_bed, run = [], making.make_bed, drag.run

    def bed(replicate, checkpoint):
        if replicate.seed == 2:
            attempts.append((replicate.seed, replicate.density))
            raise PackingError("seed 2 cannot be made.")
        return make_bed(replicate, checkpoint)

    def running(replicate, *rest, **more):
        if (replicate.seed, replicate.density) == (3, 3.9e4):
            attempts.append((replicate.seed, replicate.density))
            raise OverlapError("granule 7 at step 12.")
        return run(replicate, *rest, **more)

    monkeypatch.setattr(making, "make_bed", bed)
    monkeypatch.setattr(drag, "run", running)
    return attempts


def done(sweep, folder):
    """A sweep at work, its only chunk made."""
    work, chunk = planned(sweep, folder)
    making.make(work.store, chunk)
    return work


def test_runs_that_fail_are_gaps_where_the_sweep_allows_them(tmp_path, two_fail):
    """They are tried once, drag.nc says why they are missing, and numbers are those of the others."""
    sweep = discs([1, 2, 3], failures=0.5)
    work = done(sweep, tmp_path)
    assert len(two_fail) == 3 and done(sweep, tmp_path) and len(two_fail) == 3
    with netCDF4.Dataset(combined(work, tmp_path)) as file:
        flags = dict(
            zip(file["failure"].flag_meanings.split(), file["failure"].flag_values, strict=True)
        )
        none, packing, overlap = (flags[name] for name in ("none", "PackingError", "OverlapError"))
        np.testing.assert_array_equal(
            file["failure"][:], [[none, packing, none], [none, packing, overlap]]
        )
        gaps = np.isnan(np.ma.filled(file["drag"][:], np.nan)).all(axis=-1)
    np.testing.assert_array_equal(gaps, [[False, True, False], [False, True, True]])
    with open_lazily(tmp_path / "drag.nc") as dataset:
        numbers = summarise(dataset)
        runs = numbers["run_mean"].sel(case="c1").values[[0, 2]]
        assert float(numbers["mean"].sel(case="c1")) == pytest.approx(runs.mean())
        pair = numbers["run_mean"].sel(seed=1).values  # the only seed with both
        assert change(numbers["run_mean"], "c1", "c12")[0] == pytest.approx(pair[1] / pair[0] - 1.0)


def test_what_is_shown_of_a_sweep_with_failed_runs_has_no_gaps(tmp_path, monkeypatch, two_fail):
    """Figures, tables and the page hold numbers, and the count of runs."""
    monkeypatch.chdir(tmp_path)
    work = done(discs([1, 2, 3], failures=0.5, results="results"), tmp_path)
    drag, beds = combined(work, tmp_path), tmp_path / "snapshots.nc"
    combine_block(work, "drag", "snapshots", beds)
    for name in ("all", "figure09", "figure10"):
        draw(name, drag if name == "all" else beds, tmp_path / "figures")
    for picture in (tmp_path / "figures").glob("*.png"):
        assert_not_blank(picture)
    assert len(list((tmp_path / "figures").glob("*.png"))) > 3
    build(drag, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert not re.search(r"\bnan\b", page) and re.search(r"\b3 runs\b", page)
    console = Console(width=160, file=io.StringIO())
    console.print(summary(drag))
    assert "3 of 6 runs failed" in console.file.getvalue()
    assert not re.search(r"\bnan\b", console.file.getvalue())


@pytest.mark.quick
def test_a_case_without_any_run_stops_a_sweep(tmp_path, two_fail):
    """There is nothing to show of it, however many failures the sweep allows."""
    work = done(discs([2], failures=0.9), tmp_path)
    with pytest.raises(RunError, match="c1 at 3900 kg/m3: none of its 1 runs could be made"):
        combined(work, tmp_path)


@pytest.mark.parametrize("failures", [0.0, 0.4])
def test_runs_that_fail_stop_a_sweep_that_does_not_allow_so_many(tmp_path, two_fail, failures):
    """The first is named with its reason; no drag.nc is left, and what could be made is kept."""
    work = done(discs([1, 2, 3], failures=failures), tmp_path)
    sentence = (
        rf"3 of 6 runs .* failures allows {failures:g} .* c1 at 3900 kg/m3, seed 2: seed 2 cannot"
    )
    with pytest.raises(RunError, match=sentence):
        combined(work, tmp_path)
    assert not (tmp_path / "drag.nc").exists()
    values, _ = read(work.files("drag")[0], ("failure", "failure_reason", "seed"))
    assert (values["failure"] == 0).sum() == 3
    assert set(values["failure_reason"][values["seed"] == 2]) == {"seed 2 cannot be made."}


@pytest.mark.quick
def test_a_run_that_failed_is_tried_again_when_it_is_asked_for(tmp_path, monkeypatch, two_fail):
    """Or other values make it another run; those that did not fail are kept as they are."""
    sweep = discs([1, 2, 3], failures=0.5)
    work = done(sweep, tmp_path)
    (file,), names = work.files("drag"), ("drag", "failure", "spent", "steps")
    old, _ = read(file, names)
    assert work.retry() == 3 and len(two_fail) == 3
    monkeypatch.undo()
    done(sweep, tmp_path)
    new, _ = read(file, names)
    success = old["failure"] == 0
    assert not new["failure"].any() and np.isfinite(new["drag"]).all()
    for name in names:
        np.testing.assert_array_equal(old[name][success], new[name][success])
    assert work.retry() == 0 and file.is_file()
    rough = discs([1, 2, 3], friction={"granule": 0.1, "wall": 0.1, "cylinder": 0.1})
    assert not set(rough.block("drag").points) & set(sweep.block("drag").points)


@pytest.mark.quick
def test_a_run_that_failed_in_another_batch_is_tried_again(tmp_path, two_fail):
    """Where two sweeps were planned before it was made; the second takes over what did not fail."""
    store, results = Store(tmp_path / "store"), []
    sweeps = [
        SweepState(discs([1, 2], results=f"results/{name}"), store, root=tmp_path) for name in "ab"
    ]
    for work in sweeps:
        work.begin("drag")
    for tries, work in zip((2, 4), sweeps, strict=True):
        (path,) = (making.make(store, batch.id) for batch in work.batches("drag"))
        assert len(two_fail) == tries
        results.append(read(path, ("failure", "spent"))[0])
    one, other = results
    success = one["failure"] == 0
    assert success.sum() == 2 and (success == (other["failure"] == 0)).all()
    np.testing.assert_array_equal(one["spent"][success], other["spent"][success])


def test_a_dry_run_counts_failed_runs_of_a_chunk_under_way(tmp_path, two_fail):
    """Apart from those that are there."""
    work, chunk = planned(discs([1, 2]), tmp_path)
    with pytest.raises(Killed):
        making.make(work.store, chunk, progress=killed_at(3))
    assert "2 finished, 1 failed" in estimated(work, 1)
    path = making.make(work.store, chunk)
    assert "2 finished, 2 failed" in estimated(work, 1)
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match="delete it and run again"):
        estimated(work, 1)


def test_the_command_ends_with_1_where_runs_failed_and_tries_them_again(tmp_path, monkeypatch):
    """One sentence; with --retry the failed runs are made, and the same command ends well."""
    monkeypatch.chdir(tmp_path)
    sweep = discs([1, 2], results="results/few")
    save(sweep, tmp_path / "few.yaml")
    arguments = ["sweep", "few.yaml", "-j", "1"]
    monkeypatch.setattr(working, "make_batches", in_this_process)
    monkeypatch.setattr(making, "make_bed", failing)
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1, (result.output, result.exception)
    (line,) = [line for line in result.stderr.splitlines() if "could be made" in line]
    assert "c1 at 3900 kg/m3: none of its 2 runs" in line
    monkeypatch.setattr(making, "make_bed", make_bed)
    assert CliRunner().invoke(app, arguments).exit_code == 1
    output = CliRunner().invoke(app, [*arguments, "--dry-run"]).stdout
    assert "0 finished, 4 failed (dem sweep --retry makes these" in output
    assert "About" not in output
    output = CliRunner().invoke(app, [*arguments, "--dry-run", "--retry"]).stdout
    assert "4 failed (these are made again)" in output and "About" in output
    result = CliRunner().invoke(app, [*arguments, "--retry"])
    assert result.exit_code == 0 and "4 failed runs are tried again" in result.stderr, result.output
    assert (tmp_path / "results/few/drag.nc").is_file()


SHORT = {"bins": 4, "snapshots": 2, "window": [0.4e-3, 1e-3], "observables": ["drag"]}


def test_a_sweep_says_how_many_runs_of_its_file_will_be_gone(tmp_path, monkeypatch):
    """Of the same file, changed, or of another one of the same folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(working, "make_batches", in_this_process)
    for name, seeds, lost in (
        ("one.yaml", [1, 2, 3], ""),
        ("one.yaml", [3, 4], "drag.nc: 2 of the 3 runs that it held are no longer"),
        ("two.yaml", [1], "drag.nc: 2 of the 2 runs that it held are no longer"),
        ("results/few/config.yaml", [1], ""),
    ):
        if not name.startswith("results"):
            varied = {"case": ["c1"], "seed": seeds}
            save(smoke(results="results/few", record=SHORT, sweep=varied), name)
        result = CliRunner().invoke(app, ["sweep", name, "-j", "1"])
        assert result.exit_code == 0 and lost in result.output, result.output
        assert bool(lost) == ("no longer" in result.output)
        with netCDF4.Dataset("results/few/drag.nc") as file:
            assert file["seed"][:].tolist() == seeds


def failing(replicate, *options):
    raise PackingError("it cannot be made.")


def in_this_process(store, chunks, jobs, progress):
    for chunk in chunks:
        making.make(store, chunk.id)


def test_a_sweep_that_makes_no_run_changes_no_file(tmp_path, monkeypatch):
    """Also later: what was combined of the same runs has the same bytes, and is not newer."""
    monkeypatch.chdir(tmp_path)
    work = SweepState(smoke(sweep={"case": ["c1"], "seed": [1, 2]}, batch=1))
    work.make(Workers())
    files = {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in tmp_path.rglob("*") if p.is_file()}
    time.sleep(1.1)  # times in files are of seconds
    SweepState(work.sweep).make(Workers())
    for path, (content, written) in files.items():
        assert path.read_bytes() == content and path.stat().st_mtime_ns == written, path
    retitled = smoke(sweep={"case": ["c1"], "seed": [1, 2]}, batch=1, title="another")
    SweepState(retitled).make(Workers())
    assert read(work.combined("drag")[0], ())[1]["title"] == "another"


def test_a_folder_is_held_until_its_process_ends(tmp_path):
    """However it ends: SIGKILL leaves no lock behind."""
    code = f"""
from pathlib import Path
from dem.sweep.restart import prepare
lock = prepare(*[Path({str(tmp_path)!r})] * 2)
print('held', flush=True)
input()
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "held\n"
    with pytest.raises(RunError, match="another run works in this folder; wait for it or stop it"):
        prepare(tmp_path, tmp_path)
    process.kill()
    process.communicate()
    prepare(tmp_path, tmp_path).release()


@posix
@pytest.mark.parametrize("number", [errno.ENOLCK, 524, errno.ENOSYS, errno.EOPNOTSUPP])
def test_a_disk_without_locks_is_one_sentence_that_says_what_to_do(tmp_path, monkeypatch, number):
    """Also where files of locks are left from a time when it had them."""
    prepare(tmp_path, tmp_path).release()

    def flock(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("fcntl.flock", flock)
    words = r"/.lock: it cannot be locked \(this disk gives no locks; work on another, or mount it"
    with pytest.raises(OSError, match=words):
        prepare(tmp_path, tmp_path)


@posix
@pytest.mark.parametrize(
    ("disk", "words"),
    [
        ({"f_files": 9, "f_favail": 0}, r"\(the disk has no inode left for another file\)"),
        (
            {"f_files": 0, "f_favail": 0},
            r"\(\[Errno 28\] No space left on device\)",
        ),  # it counts none
    ],
)
def test_a_disk_that_is_full_is_named_with_what_it_lacks(tmp_path, monkeypatch, disk, words):
    disk |= {"f_frsize": 4096, "f_bavail": 10**6, "f_blocks": 10**7, "f_bfree": 10**6}
    monkeypatch.setattr("os.statvfs", lambda folder: SimpleNamespace(**disk))
    with (
        pytest.raises(OSError, match=f"file.nc: it cannot be written {words}; mend that"),
        atomic(tmp_path / "file.nc"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")


STREAMS = {"full": "> /dev/full", "closed": ">&-", "both closed": ">&- 2>&-"}


@posix
@pytest.mark.parametrize("stream", STREAMS)
@pytest.mark.parametrize("words", ["--help", "--version", f"sweep {CONFIG}/smoke.yaml -n", "store"])
def test_a_verb_says_at_most_one_sentence_where_it_cannot_write(tmp_path, stream, words):
    """On a full disk, or into what is closed; no traceback."""
    if stream == "full" and not Path("/dev/full").exists():
        pytest.skip("a system without /dev/full")
    command = f"{sys.executable} -m dem {words} {STREAMS[stream]}"
    options = {"cwd": tmp_path, "stderr": subprocess.PIPE, "text": True, "shell": True}
    (tmp_path / "results/store").mkdir(parents=True)
    run = subprocess.run(command, check=False, **options)
    full = stream == "full"
    assert run.returncode == full
    assert run.stderr == ("[Errno 28] No space left on device\n" if full else "")


def test_a_time_is_said_as_a_reader_would_say_it():
    texts = [span(seconds) for seconds in (59.4, 60, 3599, 3600, 90000)]
    assert texts == ["59 s", "1 min 0 s", "59 min 59 s", "1 h 0 min", "25 h 0 min"]


SAYS_WHEN_IT_PACKS = """
from dem.cli.app import app
from dem.experiment import bed
make_bed = bed.make_bed
bed.make_bed = lambda *of: print("packing", flush=True) or make_bed(*of)
app()
"""


@posix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_command_says_one_sentence_and_leaves_no_file(tmp_path, number):
    words = simulate(tmp_path / "out.nc") + ["shapes.c1.granules=10000", "box_width=0.1"]
    command = [sys.executable, "-c", SAYS_WHEN_IT_PACKS, *words]  # of a large bed, so that it lasts
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **streams) as process:
        assert process.stdout.readline() == "packing\n"
        process.send_signal(number)
        text = process.stderr.read()
    assert process.returncode == 128 + number
    assert text.endswith("Interrupted; no half-written file is left.\n") and "Traceback" not in text
    assert not list(tmp_path.iterdir())


@posix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("again", [(), (0.02,), (0.05, 0.05, 0.1, 0.1)])
def test_a_stopped_sweep_keeps_what_is_finished_and_says_how_to_go_on(tmp_path, number, again):
    """No worker is left alive, and no half-written file; also where it is stopped again, so many s
    later."""
    (tmp_path / "many.yaml").write_text(
        f"extends: {CONFIG}/smoke.yaml\nresults: results/many\nsweep: {{case: [c1], seed: 1 to 400}}\n"
    )
    command = [sys.executable, "-m", "dem", "sweep", "many.yaml", "-j2"]
    options = {"cwd": tmp_path, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    runs = tmp_path / "results/store/runs"
    with subprocess.Popen(command, **options) as process:
        while not list(runs.rglob("*.npz")):
            assert process.poll() is None
            time.sleep(0.05)
        # as a process leaves it that is ended while it writes
        (runs / f".a.npz.{socket.gethostname()}.{2**22 + 1}.dem.part").touch()
        for wait in (0.0, *again):
            time.sleep(wait)
            process.send_signal(number)
        output = process.stderr.read()  # until its workers have ended, which have the pipe too
    assert process.returncode == 128 + number
    sentence = r"Interrupted; (\d+) of 400 runs are kept; run the same command to go on"
    match = re.fullmatch(sentence, output.splitlines()[-1])
    assert match and int(match[1]) > 0 and "Traceback" not in output, output
    assert not list(tmp_path.rglob("*.part"))
