"""What a dry run, the status and a partial file say of a sweep that is under way, and of the time that it takes."""

import re
from pathlib import Path

import numpy as np
import pytest
from command_line import called
from pictures import text_of
from project import posix, quick
from sweeps import bytes_of_results, drawn, interrupted, made, of_file, order, smoke, varied

import dem
from dem.base.files import lock
from dem.cli.show import watched
from dem.io.progress import span
from dem.report.status import status
from dem.sweep.estimate import effort
from dem.sweep.estimate import summary as dry_run
from dem.sweep.state import SweepState


@pytest.fixture
def stopped(folder):
    """A sweep of two cases with ten seeds, in batches of eight, that stopped after eleven runs, of which two failed."""
    order(fails={"100 2": "PackingError", "300 2": "OverlapError"})
    sweep = varied("a", "c", seed="1 to 10")
    return interrupted(drawn(sweep=sweep, batch=8, failures=0.9, observed=True), 11)


@quick
@posix
def test_what_is_said_of_a_sweep_under_way_is_what_the_store_holds(stopped):
    """By case, also of batches that have not ended; a run that a process holds is under way. What is said of all
    runs is asked of any sweep (store_states.py)."""
    runs = [line.split() for line in made()]
    assert len(runs) == 11
    left = next(run for run in stopped.block("drag").unique() if run.id not in np.array(runs))
    with lock(stopped.store.run_of(left.id, ".lock")):
        text = text_of(status(SweepState.of(Path("sweep.yaml"))))
    lines = [line.split() for line in text.splitlines()]
    (names,) = (line for line in lines if line[:1] == ["case"])
    for case, density in ("a", 100), ("c", 300):
        of_case = [run for run in runs if run[2] == f"{density}"]
        forces = [float(force) for _, force, _, seed in of_case if seed != "2"]
        (row,) = (dict(zip(names, line, strict=False)) for line in lines if line[:1] == [case])
        waiting = 10 - len(of_case) - (left.density == density)
        assert row["runs"] == "10" and int(row["done"]) == len(forces), text
        assert row["failed"] == "1" and int(row["waiting"]) == waiting, text
        assert float(row["drag"]) == pytest.approx(np.mean(forces), rel=1e-2), text
    assert "Runs under way: 1, waiting: 8." in text
    for words in ("1 failed: PackingError of 100 2", "1 failed: OverlapError of 300 2"):
        assert words in text
    # the lock is there, and nobody holds it
    assert "under way: 0, waiting: 9." in text_of(status(stopped))
    assert "11 to be made" in dry_run(stopped, 1, retry=True)


@quick
def test_damaged_files_are_left_by_who_reads_and_put_aside_by_who_makes_runs(stopped, capsys):
    """Whoever reads does not count them. Their other name is said once, and what they held is made again; their
    bytes are asked for in store_states.py."""
    damaged = [path for path in stopped.store.files() if path.suffix == ".npz"]
    for path in damaged:
        path.write_bytes(path.read_bytes()[:100])
    before = bytes_of_results()
    for words in (
        "status sweep.yaml",
        "sweep sweep.yaml --dry-run",
        "combine --config sweep.yaml --observable drag -o part.nc --partial",
    ):
        run = called(words)
        assert run.exit_code == 0, run.output
    with dem.open_results("part.nc") as part:
        assert part.attrs["partial"] == "8 of 20 runs"
    assert before == bytes_of_results()
    capsys.readouterr()
    of_file(Path("sweep.yaml"))
    lines, aside = capsys.readouterr().err.splitlines(), stopped.store.folder.rglob("*.damaged")
    aside = [path.with_suffix("") for path in aside]
    # three runs, of which one had failed, a checkpoint, and the beds that are needed again
    assert {*aside} <= {*damaged} and len(lines) == len(aside) and len(made()) == 11 + 3 + 9
    for path in aside:
        words = f"{path}: it is damaged, and kept as {path.name}.damaged; it is made again."
        assert any(line.endswith(words) for line in lines)


@quick
def test_a_time_is_said_in_parts_that_add_up_to_it():
    """Rounded down to its smallest part: seconds below an hour, then minutes."""
    sizes = {"h": 3600, "min": 60, "s": 1}
    for seconds in (1, 59, 60, 61, 719, 3599, 3600, 18600, 1000000):
        parts = re.findall(r"(\d+) (h|min|s)", span(seconds))
        total = sum(int(number) * sizes[unit] for number, unit in parts)
        assert total == seconds - (seconds % 60 if seconds >= 3600 else 0), span(seconds)
        assert all(int(number) < 60 for number, unit in parts if unit != "h")
    assert span(59.4) == "59 s"


def test_the_estimated_time_of_a_run_is_in_proportion_to_its_steps():
    """At any step fraction: stiffness bounds short steps, damping long ones."""
    ratios = []
    for fraction in (0.05, 0.3, 0.95):
        sweep = {"shape": "c1", "numerics.step_fraction": [fraction]}
        run = smoke(sweep=sweep).block("drag").first
        ratios.append(effort(run) / int(run.configuration.module.run(run)["steps"]))
    assert max(ratios) < 1.25 * min(ratios)


def test_watching_ends_when_nothing_is_left(monkeypatch):
    monkeypatch.setattr("time.sleep", lambda seconds: pytest.fail("it goes on"))
    watched(lambda: ("a table", False))
