"""What goes wrong around a sweep: runs that fail, a folder that others use, clocks, Ctrl-C."""

import io
import os
import re
import signal
import subprocess
import sys
import time

import netCDF4
import numpy as np
import pytest
from conftest import CONFIG, assert_not_blank
from rich.console import Console
from test_stopping import smoke

from dem.analysis.flow.collect import collect, write_flow
from dem.analysis.statistics import change, summarise
from dem.base.errors import InputError, OverlapError, PackingError, RunError
from dem.experiment import drag
from dem.experiment.config import Replicate
from dem.figures import FLOW, draw
from dem.io.progress import TimeLeft, span
from dem.io.results_folder import hold, redate
from dem.report.build import build
from dem.report.info import summary
from dem.sweep.batch import batch, settled
from dem.sweep.combine import combine, open_combined
from dem.sweep.failures import sort_out


@pytest.fixture
def two_fail(monkeypatch):
    """The bed of seed 2, and the run of seed 3 at the higher density, fail; how often they are tried."""
    tried, make_bed, run = [], drag.make_bed, drag.run

    def bed(replicate):
        if replicate.seed == 2:
            tried.append(replicate.key)
            raise PackingError("seed 2 cannot be made.")
        return make_bed(replicate)

    def running(replicate, *rest, **more):
        if replicate.key == ("c1", "39000", 3):
            tried.append(replicate.key)
            raise OverlapError("granule 7 at step 12.")
        return run(replicate, *rest, **more)

    monkeypatch.setattr(drag, "make_bed", bed)
    monkeypatch.setattr(drag, "run", running)
    return tried


def discs(**changes):
    case = {"shape": "c1", "density": 3.9e3}
    return smoke(
        cases={"c1": case, "c12": case | {"density": 3.9e4}}, seeds=[1, 2, 3], batch=3, **changes
    )


def test_runs_that_fail_are_gaps_where_the_sweep_allows_them(tmp_path, two_fail):
    """They are tried once, drag.nc says why they are missing, and numbers are those of the others."""
    sweep = discs(failures=0.5)
    made, sentences = batch(sweep, "c1", 0, tmp_path)
    assert made == 3 and [s.split(":")[1].strip() for s in sentences] == ["PackingError", "PackingError", "OverlapError"]  # fmt: skip
    assert batch(sweep, "c1", 0, tmp_path) == (0, []) and len(two_fail) == 2
    files, failed = sort_out(sweep, tmp_path)
    assert (len(files), len(failed)) == (3, 3)
    combine(files, sweep, tmp_path / "drag.nc", failed=failed)
    with netCDF4.Dataset(tmp_path / "drag.nc") as file:
        flags = dict(
            zip(file["failure"].flag_meanings.split(), file["failure"].flag_values, strict=True)
        )
        none, packing, overlap = (flags[name] for name in ("none", "PackingError", "OverlapError"))
        np.testing.assert_array_equal(
            file["failure"][:], [[none, packing, none], [none, packing, overlap]]
        )
        gaps = np.isnan(np.ma.filled(file["drag"][:], np.nan)).all(axis=-1)
    np.testing.assert_array_equal(gaps, [[False, True, False], [False, True, True]])
    with open_combined(tmp_path / "drag.nc") as dataset:
        numbers = summarise(dataset)
        runs = numbers["run_mean"].sel(case="c1").values[[0, 2]]
        assert float(numbers["mean"].sel(case="c1")) == pytest.approx(runs.mean())
        pair = numbers["run_mean"].sel(seed=1).values  # the only seed with both
        assert change(numbers["run_mean"], "c1", "c12")[0] == pytest.approx(pair[1] / pair[0] - 1.0)
    flow = collect(files, sweep, failed=failed)
    np.testing.assert_array_equal(np.isnan(flow["mixing"]).all(axis=-1), gaps)
    write_flow(tmp_path / "flow.nc", sweep, flow)
    shows_no_gaps(tmp_path)


def shows_no_gaps(folder):
    """Figures, tables and the page of a sweep with failed runs hold numbers, and the count of runs."""
    drag, flow = folder / "drag.nc", folder / "flow.nc"
    for name in ("all", "figure09", "irregularity"):
        draw(name, flow if name in FLOW else drag, folder / "figures")
    for picture in (folder / "figures").glob("*.png"):
        assert_not_blank(picture)
    assert len(list((folder / "figures").glob("*.png"))) > 3
    build(drag, flow, CONFIG.parent / "README.md", folder / "report.html")
    page = re.sub(r"<script.*?</script>", "", (folder / "report.html").read_text(), flags=re.S)
    assert not re.search(r"\bnan\b", page) and re.search(r"\b3 runs\b", page)
    console = Console(width=160, file=io.StringIO())
    console.print(summary(drag))
    assert "3 of 6 runs: 2 PackingError, 1 OverlapError" in console.file.getvalue()
    assert not re.search(r"\bnan\b", console.file.getvalue())


def test_a_case_without_any_run_stops_a_sweep(tmp_path, two_fail):
    """There is nothing to show of it, however many failures the sweep allows."""
    case = {"shape": "c1", "density": 3.9e3}
    sweep = smoke(cases={"c1": case}, seeds=[2], batch=2, failures=0.9)
    batch(sweep, "c1", 0, tmp_path)
    files, failed = sort_out(sweep, tmp_path)
    with pytest.raises(RunError, match="c1 at 3900 kg/m3: none of its 1 replicates"):
        combine(files, sweep, tmp_path / "drag.nc", failed=failed)


def test_runs_that_fail_stop_a_sweep_that_does_not_allow_so_many(tmp_path, two_fail):
    """All of them are named; what could be made is kept."""
    with pytest.raises(
        RunError, match=r"(?s)seed2.nc: PackingError.*density39000/seed3.nc: Overlap"
    ):
        batch(discs(), "c1", 0, tmp_path)
    assert len(list(tmp_path.rglob("*.nc"))) == 3 and not list(tmp_path.rglob("*.failed"))
    sweep = discs(failures=0.4)
    batch(sweep, "c1", 0, tmp_path)
    files, failed = sort_out(sweep, tmp_path)
    with pytest.raises(RunError, match=r"3 of 6 replicates could not be made.*0.4 of them.*seed2"):
        combine(files, sweep, tmp_path / "drag.nc", failed=failed)
    assert not (tmp_path / "drag.nc").exists()


def test_a_run_that_failed_is_tried_again_when_something_changes(tmp_path, monkeypatch, two_fail):
    """Other values, or other sources, and the note of the failure is nothing."""
    sweep = discs(failures=0.5)
    batch(sweep, "c1", 0, tmp_path)
    replicate = sweep.replicate("c1", 3.9e3, 2)
    path = tmp_path / replicate.path
    assert settled(path, replicate)
    friction = {"granule": 0.1, "wall": 0.1, "cylinder": 0.1}
    rough = discs(failures=0.5, friction=friction)
    assert not settled(path, rough.replicate("c1", 3.9e3, 2))
    assert len(sort_out(rough, tmp_path)[1]) == 0
    monkeypatch.setattr(Replicate, "source_hash", "other")
    assert not settled(path, replicate)


def test_failures_need_batches():
    with pytest.raises(InputError, match=r"failures is 0.1; with batch 1 it must be 0"):
        smoke(failures=0.1)


def test_a_folder_is_held_until_its_process_ends(tmp_path):
    """However it ends: SIGKILL leaves no lock behind."""
    code = f"from dem.io.results_folder import hold; held = hold({str(tmp_path)!r}); print('held', flush=True); input()"
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "held\n"
    with pytest.raises(RunError, match="another run works in this folder; wait for it or stop it"):
        hold(tmp_path)
    process.kill()
    process.communicate()
    hold(tmp_path).release()


def test_files_from_the_future_are_dated_now_in_their_order(tmp_path):
    now, names = time.time(), ("drag.nc", "bed.nc", "replicate.nc")
    for name, ahead in zip(names, (-100.0, 3600.0, 7200.0), strict=True):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (now + ahead, now + ahead))
    count, ahead = redate(tmp_path)
    assert count == 2 and ahead == pytest.approx(7200.0, abs=5.0)
    stamps = [(tmp_path / name).stat().st_mtime for name in names]
    assert stamps == sorted(stamps) and stamps[-1] < time.time()
    assert redate(tmp_path) == (0, 0.0)


def test_time_left_of_a_steady_job():
    """A line each half minute, what was there at the start not counted; none in the end."""
    now = [0.0]
    time_left = TimeLeft(every=30.0, clock=lambda: now[0])
    said = []
    for second in range(101):  # one percent a second, from a half on
        now[0] = float(second)
        said.append(time_left.words(0.5 + 0.005 * second))
    assert [words for words in said if words] == ["65% done, 1 min 10 s left", "80% done, 40 s left", "95% done, 10 s left"]  # fmt: skip
    assert [span(s) for s in (59.4, 60, 3599, 3600, 90000)] == ["59 s", "1 min 0 s", "59 min 59 s", "1 h 0 min", "25 h 0 min"]  # fmt: skip


@pytest.mark.parametrize("verb", ["simulate", "pack"])
@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_command_says_one_sentence(tmp_path, verb, asked):
    """Of a job that ignores signals until it can answer, as the workflow starts its jobs."""
    command = [sys.executable, "-m", "dem", verb, "--config", CONFIG / "smoke.yaml", "--shape", "c1", "--seed", "1",
               "-o", tmp_path / "out.nc", *(["--density", "3900"] if verb == "simulate" else [])]  # fmt: skip
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(asked, signal.SIG_IGN),
    )  # fmt: skip
    while process.poll() is None:
        process.send_signal(asked)
        time.sleep(0.1)
    assert process.returncode == 128 + asked
    assert process.stderr.read() == "Interrupted; no half-written file is left.\n"
    assert not list(tmp_path.iterdir())
