"""What goes wrong around a sweep: runs that fail, a folder that others use, Ctrl-C."""

import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import chdir
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from project import posix
from sweeps import SMOKE, VALUES, contents, drawn, made, of_file, order, varied
from typer.testing import CliRunner

from dem.analysis.drag import change, summarise
from dem.base.errors import RunError
from dem.cli.app import app
from dem.io.lazily import open_lazily
from dem.sweep.batch import make
from dem.sweep.restart import prepare
from dem.sweep.state import SweepState

ERRORS = "PackingError", "OverlapError", "StateError", "RunError", "ZeroDivisionError"
SEEDS, CASES = len(ERRORS) + 2, ("c1", "c2")
ORDERS = {
    **{f"100 {seed}": name for seed, name in enumerate(ERRORS[:2], 2)},
    **{f"300 {seed}": name for seed, name in enumerate(ERRORS, 1)},
}


@pytest.fixture(scope="module")
def failed(tmp_path_factory):
    """A folder with the files of a sweep of two cases, of which runs fail for every reason."""
    folder = tmp_path_factory.mktemp("failed")
    with chdir(folder):
        order(fails=ORDERS)
        record = VALUES["record"] | {"observables": ["drag", "snapshots"]}
        cases = {name: VALUES["cases"][old] for name, old in zip(CASES, "ac", strict=True)}
        sweep = varied(*cases, seed=f"1 to {SEEDS}")
        of_file(drawn(observed=True, record=record, cases=cases, sweep=sweep, failures=0.6))
        assert len(made()) == 2 * SEEDS
    return folder / "results/drawn"


@pytest.mark.quick
def test_runs_that_fail_are_gaps_with_their_reason(failed):
    """Named by the flags of the file. What they would have given is NaN, and nothing else is."""
    with netCDF4.Dataset(failed / "drag.nc") as file:
        file.set_auto_mask(False)
        flags = np.atleast_1d(file["failure"].flag_values).tolist()
        meanings = dict(zip(flags, file["failure"].flag_meanings.split(), strict=True))
        known = {name: name for name in ERRORS[:3]} | dict.fromkeys(ERRORS[3:], "other")
        gaps = np.zeros((2, SEEDS), bool)
        for (case, seed), flag in np.ndenumerate(file["failure"][:]):
            error = ORDERS.get(f"{(100, 300)[case]} {seed + 1}")
            assert meanings[int(flag)] == known.get(error, "none"), (case, seed)
            gaps[case, seed] = error is not None
        assert "PackingError of 100 2" in file["failure"].comment
        for name, variable in file.variables.items():
            if variable.dimensions[:2] == ("case", "seed") and variable.dtype.kind == "f":
                missing = np.isnan(variable[:]).reshape(2, SEEDS, -1)
                assert (missing == gaps[..., None]).all(), name


@pytest.mark.quick
def test_numbers_of_a_sweep_with_failed_runs_are_those_of_the_others(failed):
    """Means of all that are there, and changes of the seeds that both cases have."""
    drag = contents(failed / "drag.nc")["drag"][:, :, 4:10].mean(axis=-1)  # the bins of the window
    with open_lazily(failed / "drag.nc") as dataset:
        numbers = summarise(dataset)
        for case, runs in zip(CASES, drag, strict=True):
            assert float(numbers["mean"].sel(case=case)) == pytest.approx(np.nanmean(runs))
        one, two = drag[:, len(ERRORS) :].mean(axis=1)
        assert change(numbers["run_mean"], *CASES)[0] == pytest.approx(two / one - 1.0)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


TOO_MANY = {
    "a case without any run": (0.9, 4, "c1 at 100 kg/m3: none of its 4 runs could be made"),
    "more than are allowed": (
        0.2,
        2,
        r"2 of 8 runs .* failures allows 0.2 .* c1 at 100 kg/m3, seed 1: StateError of 100 1",
    ),
    "one where none is allowed": (0.0, 1, r"1 of 8 runs .* failures allows 0 of them"),
}


@pytest.mark.quick
@pytest.mark.parametrize("case", TOO_MANY)
def test_runs_that_fail_stop_a_sweep_that_does_not_allow_so_many(folder, case):
    """The first is named with its reason; no file is combined. What could be made is kept, what failed is
    made when it is asked for, and nothing else is."""
    failures, count, words = TOO_MANY[case]
    order(fails={f"100 {seed}": "StateError" for seed in range(1, count + 1)})
    file = drawn(sweep=varied("a", "c", seed="1 to 4"), failures=failures)
    for _ in range(2):
        with pytest.raises(RunError, match=words):
            of_file(file)
    assert not Path("results/drawn/drawn.nc").exists() and len(made()) == 8
    state = SweepState.of(file)
    (batch,) = state.files("drag")
    before = contents(batch, without=())
    order()
    assert state.retry() == count
    of_file(file)
    after = contents(batch, without=())
    assert len(made()) == 8 + count and not after["failure"].any() and state.retry() == 0
    for name in ("force", "spent"):
        kept = before["failure"] == 0
        np.testing.assert_array_equal(before[name][kept], after[name][kept])


@pytest.mark.quick
def test_a_run_that_failed_in_the_batch_of_another_sweep_is_tried_again(folder):
    """Where two sweeps were planned before it was made; the second takes over what did not fail."""
    order(fails={"100 2": "RunError"})
    sweep = varied("a", seed=[1, 2])
    states = [SweepState.of(drawn(results=f"results/{name}", sweep=sweep)) for name in "ab"]
    for state in states:
        state.begin("drag")
    for count, state in zip((2, 3), states, strict=True):
        for batch in state.batches("drag"):
            make(state.store, batch.id)
        assert len(made()) == count and state.store.rows(state.runs())


def command(*words):
    return CliRunner().invoke(app, ["sweep", "sweep.yaml", "-j", "1", *words])


def test_the_command_ends_with_1_where_runs_failed_and_tries_them_again(folder):
    """One sentence; with --retry the failed runs are made, and the same command ends well."""
    order(fails={f"{density} {seed}": "RunError" for density in (100, 300) for seed in (1, 2)})
    drawn(sweep=varied("a", "c", seed=[1, 2]))
    for _ in range(2):
        result = command()
        assert result.exit_code == 1, (result.output, result.exception)
        assert result.stderr.count("c1 at 100 kg/m3: none of its 2 runs could be made") == 1
    output = command("--dry-run").stdout
    assert "0 finished, 4 failed (dem sweep --retry makes these" in output and "About" not in output
    output = command("--dry-run", "--retry").stdout
    assert "4 failed (these are made again)" in output and "About" in output
    order()
    result = command("--retry")
    assert result.exit_code == 0 and "4 failed runs are tried again" in result.stderr, result.output
    assert Path("results/drawn/drawn.nc").is_file()


def test_a_sweep_says_how_many_runs_of_its_file_will_be_gone(folder):
    """Of the same file, changed, or of another one of the same folder."""
    path = Path("results/drawn/drawn.nc")
    for seeds, lost in (
        ([1, 2, 3], ""),
        ([3, 4], "drawn.nc: 2 of the 3 runs that it held are no longer"),
        ([1], "drawn.nc: 2 of the 2 runs that it held are no longer"),
        ([1], ""),
    ):
        drawn(sweep=varied("a", seed=seeds))
        result = command()
        assert result.exit_code == 0 and lost in result.output, result.output
        assert bool(lost) == ("no longer" in result.output)
        assert contents(path)["seed"].tolist() == seeds


@pytest.mark.quick
def test_a_sweep_that_makes_no_run_changes_no_file(folder):
    """Also later: what was combined of the same runs has the same bytes, and is not newer."""
    of_file(drawn(batch=1))
    paths = [path for path in Path("results").rglob("*") if path.is_file()]
    files = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in paths}
    time.sleep(1.1)  # times in files are of seconds
    of_file(Path("sweep.yaml"))
    for path, file in files.items():
        assert (path.read_bytes(), path.stat().st_mtime_ns) == file, path
    of_file(drawn(batch=1, title="another"))
    with netCDF4.Dataset("results/drawn/drawn.nc") as file:
        assert file.title == "another" and len(made()) == 4


def test_a_folder_is_held_until_its_process_ends(folder):
    """However it ends: SIGKILL leaves no lock behind."""
    code = (
        "from pathlib import Path; from dem.sweep.restart import prepare; "
        "lock = prepare(Path(), Path()); print('held', flush=True); input()"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    process = subprocess.Popen([sys.executable, "-c", code], **pipes)
    assert process.stdout.readline() == "held\n"
    with pytest.raises(RunError, match="another run works in this folder; wait for it or stop it"):
        prepare(Path(), Path())
    process.kill()
    process.communicate()
    prepare(Path(), Path()).release()


SAYING = "--help", "--version", f"sweep {SMOKE} -n", "store"
FULL = [f"{words} > /dev/full" for words in SAYING]


@posix
@pytest.mark.parametrize("words", [*FULL, *(f"{words} >&- 2>&-" for words in SAYING[2:])])
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
    [(signal.SIGTERM, ()), (signal.SIGTERM, (0.02,)), (signal.SIGINT, (0.05, 0.05, 0.1, 0.1))],
)
def test_a_stopped_sweep_keeps_what_is_finished_and_says_how_to_go_on(folder, number, again):
    """No worker is left alive, and no half-written file; also where it is stopped again, so many s
    later."""
    order(sleeps=0.05)
    drawn(sweep=varied("a", seed="1 to 400"))
    runs = Path("results/store/runs")
    with started(lambda: [*runs.rglob("*.npz")], "sweep", "sweep.yaml", "-j2") as process:
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
    assert not list(folder.rglob("*.part"))
