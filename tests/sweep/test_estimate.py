"""What a dry run, the status and a partial file say of a sweep that is under way, and of the time that it takes."""

import re
from pathlib import Path

import numpy as np
import pytest
from pictures import text_of
from project import posix
from sweeps import drawn, interrupted, order, varied
from typer.testing import CliRunner

import dem
from dem.base.files import lock
from dem.cli.app import app
from dem.cli.show import watched
from dem.io.progress import span
from dem.report.status import status
from dem.sweep.config import parse
from dem.sweep.estimate import effort
from dem.sweep.estimate import summary as dry_run
from dem.sweep.state import SweepState


@pytest.fixture
def stopped(tmp_path, monkeypatch):
    """A sweep of two cases with ten seeds, in batches of eight, that stopped after eleven runs, of which two failed."""
    monkeypatch.chdir(tmp_path)
    order(fails={"100 2": "PackingError", "300 2": "OverlapError"})
    sweep = varied("a", "c", seed="1 to 10")
    return interrupted(drawn(sweep=sweep, batch=8, failures=0.9, observed=True), 11)


def rows(state):
    """The table of a sweep's status, by the name of the case, and the whole text."""
    text = text_of(status(state))
    (names,) = (line.split() for line in text.splitlines() if line.startswith("case "))
    lines = (line.split() for line in text.splitlines() if line.startswith(("a ", "c ")))
    return {line[0]: dict(zip(names, line, strict=False)) for line in lines}, text


@pytest.mark.quick
@posix
def test_what_is_said_of_a_sweep_under_way_is_what_the_store_holds(stopped):
    """By case and in all, also of batches that have not ended; a run that a process holds is under way. It
    changes no file."""
    runs = list(stopped.block("drag").unique())
    files = {path: path.read_bytes() for path in Path("results").rglob("*.n*")}
    store = stopped.store
    batches = [store.rows_of(batch.id, "drag") for batch in store.batches()]
    kept = {run.id: row for run in runs if (row := store.kept(run.id))}
    assert [len(rows) for rows in batches] == [8] and len(kept) == 3
    there = batches[0] | kept
    means = {  # bins of the window, of twelve
        run: row["drag"][4:10].mean() for run, row in there.items() if not row["failure"]
    }
    held = next(run for run in runs if run.id not in there)
    with lock(store.run_of(held.id, ".lock")):
        table, text = rows(SweepState.of(Path("sweep.yaml")))
    for case, density in {"a": 100.0, "c": 300.0}.items():
        of_case = [run.id for run in runs if run.density == density]
        drag = [means[run] for run in of_case if run in means]
        failed = sum(run in there and run not in means for run in of_case)
        waiting = len(of_case) - len(drag) - failed - (held.density == density)
        expected = {"runs": 10, "done": len(drag), "waiting": waiting, "failed": failed}
        assert {name: int(table[case].get(name, 0)) for name in expected} == expected, text
        assert float(table[case]["drag"]) == pytest.approx(np.mean(drag), rel=1e-2), text
    assert "Runs under way: 1, waiting: 8." in text
    for words in ("1 failed: PackingError of 100 2", "1 failed: OverlapError of 300 2"):
        assert words in text
    assert "under way: 0, waiting: 9." in rows(stopped)[1]  # the lock is there, and nobody holds it
    assert "20 runs (case 2, seed 10), 9 finished, 2 failed" in dry_run(stopped, 1)
    assert "9 to be made" in dry_run(stopped, 1) and "11 to be made" in dry_run(
        stopped, 1, retry=True
    )
    assert stopped.counts() == (11, 20)
    assert files == {path: path.read_bytes() for path in Path("results").rglob("*.n*")}


@pytest.mark.quick
def test_a_sweep_that_has_not_begun_waits_and_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    until = {"until": "10 %", "of": "force", "most": 120}
    state = SweepState.of(drawn(sweep=varied("a", "c", seed=until)))
    assert "waiting: 20." in rows(state)[1] and "takes 20 to 240 runs" in dry_run(state, 2)
    assert not Path("results").exists()


@pytest.mark.quick
def test_a_command_that_reads_does_not_count_damaged_runs_and_leaves_them(stopped):
    file = min(Path("results/store/runs").rglob("[!.]*[0-9a-f].npz"))
    file.write_bytes(file.read_bytes()[:100])
    files = {path: path.read_bytes() for path in Path("results").rglob("*.n*")}
    for words in (
        "status sweep.yaml",
        "sweep sweep.yaml --dry-run",
        "combine --config sweep.yaml --observable drag -o part.nc --partial",
    ):
        run = CliRunner().invoke(app, words.split())
        assert run.exit_code == 0, run.output
    with dem.open_results("part.nc") as part:
        assert part.attrs["partial"] == "10 of 20 runs"
    assert files == {path: path.read_bytes() for path in Path("results").rglob("*.n*")}


@pytest.mark.quick
def test_a_time_is_said_in_parts_that_add_up_to_it():
    """Rounded down to its smallest part: seconds below an hour, then minutes."""
    sizes = {"h": 3600, "min": 60, "s": 1}
    for seconds in (1, 59, 60, 61, 719, 3599, 3600, 3661, 18600, 86399, 90061, 1000000):
        parts = re.findall(r"(\d+) (h|min|s)", span(seconds))
        total = sum(int(number) * sizes[unit] for number, unit in parts)
        assert total == seconds - (seconds % 60 if seconds >= 3600 else 0), span(seconds)
        assert all(int(number) < 60 for number, unit in parts if unit != "h")
    assert [span(seconds) for seconds in (59.4, 60, 18600)] == ["59 s", "1 min 0 s", "5 h 10 min"]


def test_the_estimated_time_of_a_run_is_in_proportion_to_its_steps():
    """At any step fraction: stiffness bounds short steps, damping long ones."""
    ratios = []
    for fraction in (0.05, 0.3, 0.95):
        sweep = {"shape": "c1", "numerics.step_fraction": [fraction]}
        values = {"extends": "config/smoke.yaml", "results": "results/told", "sweep": sweep}
        run = parse(values, "a sweep").block("drag").first
        ratios.append(effort(run) / int(run.configuration.module.run(run)["steps"]))
    assert max(ratios) < 1.25 * min(ratios)


def test_watching_ends_when_nothing_is_left(monkeypatch):
    monkeypatch.setattr("time.sleep", lambda seconds: pytest.fail("it goes on"))
    watched(lambda: ("a table", False))
