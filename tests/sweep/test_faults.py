"""What goes wrong around a sweep: runs that fail, a folder that others use, Ctrl-C."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray as xr
from command_line import called
from project import posix, quick
from sweeps import SMOKE, VALUES, contents, drawn, made, of_file, order, varied

from dem.base.errors import RunError
from dem.sweep.batch_job import make
from dem.sweep.combine import combine
from dem.sweep.restart import prepare
from dem.sweep.state import SweepState
from dem.sweep.workers import Workers

ERRORS = "PackingError", "OverlapError", "StateError", "RunError", "ZeroDivisionError"


@quick
def test_runs_that_fail_are_gaps_with_their_reason(folder):
    """Named by the flags of the file. What they would have given is NaN, and nothing else is."""
    order(fails={f"300 {seed}": name for seed, name in enumerate(ERRORS)})
    record = VALUES["record"] | {"observables": ["drag", "snapshots"]}
    sweep = varied("a", "c", seed=f"0 to {len(ERRORS)}")
    of_file(drawn(observed=True, record=record, sweep=sweep, failures=0.6))
    with xr.open_dataset("results/drawn/drag.nc", mask_and_scale=False) as data:
        failure, meanings = data["failure"], data["failure"].flag_meanings.split()
        told = [meanings[list(failure.flag_values).index(flag)] for flag in failure[1]]
        assert told == [*ERRORS[:3], "other", "other", "none"] and not failure[0].any()
        assert "PackingError of 300 0" in failure.comment
        for name, values in data.data_vars.items():
            if values.dims[:2] == failure.dims and values.dtype.kind == "f":
                assert (values.isnull() == (failure != 0)).all(), name


TOO_MANY = {
    "a case without any run": (0.9, 4, "c1 at 100 kg/m3: none of its 4 runs could be made"),
    "more than are allowed": (
        0.2,
        2,
        r"2 of 8 runs .* failures allows 0.2 .* c1 at 100 kg/m3, seed 1: StateError of 100 1",
    ),
}


@quick
@pytest.mark.parametrize("case", TOO_MANY)
def test_runs_that_fail_stop_a_sweep_that_does_not_allow_so_many(folder, case):
    """The first of the sweep is named with its reason, whichever batch is read first; no file is combined. What
    could be made is kept, and what failed is not made before it is asked for."""
    failures, count, words = TOO_MANY[case]
    order(fails={f"100 {seed}": "StateError" for seed in range(1, count + 1)})
    state = SweepState.of(drawn(sweep=varied("a", "c", seed="1 to 4"), failures=failures, batch=1))
    for _ in range(2):
        with pytest.raises(RunError, match=words):
            state.make(Workers())
    output = Path("reversed.nc")
    with pytest.raises(RunError, match=words):
        combine(state.files("drag")[::-1], state.sweep, state.block("drag"), "drawn", output)
    assert not [*Path().rglob("drawn.nc"), *Path().glob("*.nc")] and len(made()) == 8


@quick
def test_a_run_that_failed_in_the_batch_of_another_sweep_is_tried_again(folder):
    """Where two sweeps were planned before it was made; the second takes over what did not fail."""
    order(fails={"100 2": "RunError"})
    sweep = varied("a", seed=[1, 2])
    states = [SweepState.of(drawn(results=f"results/{name}", sweep=sweep)) for name in "ab"]
    for state in states:
        state.begin("drag")
    for count, state in zip((2, 3), states, strict=True):
        (batch,) = state.batches("drag")
        make(state.store, batch.id)
        assert len(made()) == count


def test_the_command_ends_with_1_where_runs_failed_and_tries_them_again(folder):
    """One sentence; with --retry the failed runs are made, and the same command ends well."""
    order(fails={f"100 {seed}": "RunError" for seed in (1, 2)})
    drawn(sweep=varied("a", seed=[1, 2]))
    for option, status, words in (
        ("-j1", 1, "c1 at 100 kg/m3: none of its 2 runs could be made"),
        (
            "--dry-run",
            0,
            "0 finished, 2 failed (dem sweep --retry makes these again), 0 to be made",
        ),
        ("--retry", 0, "2 failed runs are tried again"),
    ):
        result = called(f"sweep sweep.yaml {option}")
        assert result.exit_code == status and result.output.count(words) == 1, result.output
        order()
    assert Path("results/drawn/drawn.nc").is_file()


def test_a_sweep_says_how_many_runs_of_its_file_will_be_gone(folder):
    """Of the same file, changed, or of another one of the same folder."""
    for seeds, lost in ([1, 2, 3], ""), ([3, 4], "2 of the 3 runs"), ([1], "2 of the 2 runs"):
        state = SweepState.of(drawn(sweep=varied("a", seed=seeds)))
        said = [line for line in state.check() if "drawn.nc" in line]
        assert len(said) == bool(lost) and all(lost in line for line in said)
        state.make(Workers())
        assert contents(Path("results/drawn/drawn.nc"))["seed"].tolist() == seeds


@quick
def test_a_sweep_that_makes_no_run_changes_no_file(folder):
    """Also later: what was combined of the same runs has the same bytes, and is not newer."""
    of_file(drawn(batch=1))
    paths = [path for path in Path("results").rglob("*") if path.is_file()]
    files = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in paths}
    time.sleep(1.1)  # times in files are of seconds
    of_file(Path("sweep.yaml"))
    for path, file in files.items():
        assert (path.read_bytes(), path.stat().st_mtime_ns) == file, path


@quick
def test_a_folder_is_held_by_one_process_at_a_time(folder):
    held = prepare(folder, folder)
    with pytest.raises(RunError, match="another run works in this folder; wait for it or stop it"):
        prepare(folder, folder)
    held.release()
    prepare(folder, folder).release()


SAYING = "--version", f"sweep {SMOKE} -n", "store"
FULL = [f"{words} > /dev/full" for words in SAYING]


@posix
@pytest.mark.parametrize("words", [*FULL, *(f"{words} >&- 2>&-" for words in SAYING[1:])])
def test_a_verb_says_at_most_one_sentence_where_it_cannot_write(folder, words):
    """On a full disk, or into what is closed; no traceback."""
    if words in FULL and not Path("/dev/full").exists():
        pytest.skip("a system without /dev/full")
    Path("results/store").mkdir(parents=True)
    command = f"{sys.executable} -m dem {words}"
    run = subprocess.run(command, stderr=subprocess.PIPE, text=True, shell=True)
    assert run.returncode == (words in FULL)
    assert run.stderr == ("[Errno 28] No space left on device\n" if words in FULL else "")


def started(condition, *words):
    """A command of dem in a process of its own, once it is so far."""
    options = {"stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    process = subprocess.Popen([sys.executable, "-m", "dem", *words], **options)
    while not condition():
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.05)
    return process


SLOW = """
import time
from pathlib import Path

VARIABLES = {"slow": (("snapshot",), "1", "what takes long")}


def look(simulation):
    Path("begun").touch()
    time.sleep(60)
"""


@posix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_command_says_one_sentence_and_leaves_no_file(folder, number):
    Path("slow.py").write_text(SLOW)
    Path("slow.yaml").write_text(
        f"extends: {SMOKE}\nresults: results/slow\nrecord: {{observables: [drag, slow.py]}}\n"
    )
    words = "simulate --config slow.yaml --shape c1 --density 3900 --seed 1 -o out.nc"
    with started(Path("begun").exists, *words.split()) as process:
        process.send_signal(number)
        text = process.stderr.read()
    assert process.returncode == 128 + number
    assert text.endswith("Interrupted; no half-written file is left.\n") and "Traceback" not in text
    assert {path.name for path in folder.glob("[!_]*")} == {"slow.py", "slow.yaml", "begun"}


@posix
@pytest.mark.parametrize(
    ("number", "again"),
    [(signal.SIGTERM, (0.02,)), (signal.SIGINT, ()), (signal.SIGINT, (0.05, 0.05, 0.1, 0.1))],
)
def test_a_stopped_sweep_keeps_what_is_finished_and_says_how_to_go_on(folder, number, again):
    """No worker is left alive, and no half-written file; also where it is stopped again, so many s
    later."""
    order(sleeps=0.05)
    drawn(sweep=varied("a", seed="1 to 400"))
    runs = Path("results/store/runs")
    with started(lambda: [*runs.rglob("*.npz")], "sweep", "sweep.yaml", "-j2") as process:
        for wait in (0.0, *again):
            time.sleep(wait)
            process.send_signal(number)
        output = process.stderr.read()  # until its workers have ended, which have the pipe too
    assert process.returncode == 128 + number
    sentence = r"Interrupted; (\d+) of 400 runs are kept; run the same command to go on"
    match = re.fullmatch(sentence, output.splitlines()[-1])
    assert match and int(match[1]) > 0 and "Traceback" not in output, output
    assert not list(folder.rglob("*.part"))


@posix
def test_workers_end_with_the_process_that_started_them(folder, monkeypatch):
    """However it ends, also while they compile: they would keep memory, and a pipe that somebody reads."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder))
    Path("long.yaml").write_text(
        f"extends: {SMOKE}\nresults: results/long\nsweep: {{case: c1, seed: 1 to 400}}\n"
    )
    with started(lambda: [*folder.rglob("runs/**/*.lock")], "sweep", "long.yaml", "-j2") as process:
        process.kill()
        process.communicate(timeout=30.0)  # until nobody has the pipe
