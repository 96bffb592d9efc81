"""The workflow's promises, kept by a run of config/smoke.yaml in a copy of the repository."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from forked import SMOKE, environment, snakemake
from typer.testing import CliRunner

import dem
from conftest import assert_alone, assert_not_blank, posix
from dem.cli.app import app
from dem.figures.catalogue import FIGURES
from dem.sweep.config import load
from dem.sweep.state import SweepState

pytestmark = posix
ROOT = Path(__file__).parent.parent
NOT_COMPARED = {"run_time", "spent"}


def planned(folder, *arguments, configfile=SMOKE):
    """Number of jobs of each rule that a dry run announces."""
    run = snakemake(folder, *arguments, "-n", configfile=configfile)
    assert run.returncode == 0, run.stderr
    table = re.search(r"\njob +count\n-+ +-+\n(.*?)\ntotal", run.stdout + run.stderr, re.S)
    return {} if table is None else {k: int(n) for k, n in re.findall(r"(\w+) +(\d+)", table[1])}


def contents(path):
    with netCDF4.Dataset(path) as file:
        return {n: np.array(v[...]) for n, v in file.variables.items() if n not in NOT_COMPARED}


def runs_of(folder):
    """Every run of the store beside a folder of results: its variables, by shape, density and seed."""
    found = {}
    for path in (folder.parent / "store/batches").glob("*.nc"):
        values = contents(path)
        names = list(zip(*(values[n].tolist() for n in ("shape", "density", "seed")), strict=True))
        with netCDF4.Dataset(path) as file:
            of_run = {n for n in values if "run" in file[n].dimensions}
        for row, name in enumerate(names):
            found[name] = {n: values[n][row] for n in of_run}
    return found


def test_one_command_makes_all_results(finished):
    """One command leaves drag.nc, snapshots.nc, every run once and the figures."""
    results = finished / "results/smoke"
    assert len(runs_of(results)) == 5 * 2
    assert (results / "snapshots.nc").is_file()
    for figure in (
        "figure07",
        "figure08",
        "figure09",
        "figure12",
        "figure13",
        "figure14",
    ):
        assert (results / f"figures/{figure}.svg").is_file()
        assert_not_blank(results / f"figures/{figure}.png")
    assert not list(results.rglob("*.part"))


@pytest.fixture(scope="module")
def reported(finished):
    """The folder of results with Snakemake's own report and the page that links it."""
    results = finished / "results/smoke"
    for arguments in (("-j1", "--report", str(results / "provenance.html")), ("-j2", "report")):
        run = snakemake(finished, *arguments)
        assert run.returncode == 0, run.stdout + run.stderr
    return results


def test_the_report_of_snakemake_says_what_each_figure_shows(finished, reported):
    """In the words of its own module."""
    page = (reported / "provenance.html").read_text()
    drawn = FIGURES.keys() & {path.stem for path in (reported / "figures").glob("*.svg")}
    assert len(drawn) >= 6
    for name in drawn:
        caption = FIGURES[name].caption
        assert f'{{"figure": "{name}", "shows": "{caption}"}}' in page
    assert 'href="provenance.html"' in (reported / "report.html").read_text()
    assert planned(finished, "report") == {}


def test_reports_open_without_a_network(reported, browser):
    """The page of results and Snakemake's own report ask for no other file."""
    for name in ("provenance.html", "report.html"):
        browser.get((reported / name).as_uri())
        assert_alone(browser)


def test_claims_of_small_beds(claimed):
    """The study of claims, from its runs to a table and five figures; nothing is made twice."""
    results = claimed / "results/smoke"
    table = (results / "claims.txt").read_text()
    assert "dumbbells above discs" in table and "drag over that of c1" in table
    pictures = list((results / "figures").glob("claims_*.png"))
    assert len(pictures) == 5
    for picture in pictures:
        assert_not_blank(picture)
    with netCDF4.Dataset(results / "claims.nc") as file:
        parts = file["run_part"][:].tolist()
        assert parts.count("replicates") == 5 * 3 and parts.count("sensitivity") == 2 * 10
        failed = int(np.isnan(np.ma.filled(file["run_drag"][:], np.nan)).sum())
        assert failed <= len(parts) // 4
    assert planned(claimed, "claims") == {}


def test_a_configuration_of_the_command_line_replaces_that_of_the_paper(finished):
    """No key of the paper is left; without one, snakemake alone plans the paper."""
    made, asked = load(finished / "results/smoke/config.yaml"), load(finished / SMOKE)
    assert made.dump() == asked.dump()
    paper = SweepState.of(finished / "config/paper.yaml", finished)
    assert planned(finished, configfile=None)["batch"] == len(paper.batches("drag"))


def test_a_second_run_does_nothing(finished):
    """What is up to date is left alone."""
    assert planned(finished) == {}


def test_drag_is_that_of_the_runs(finished):
    """drag.nc holds, for each case and seed, the very numbers of the run."""
    results = finished / "results/smoke"
    runs = runs_of(results)
    with netCDF4.Dataset(results / "drag.nc") as file:
        assert file["drag"].dimensions == ("case", "seed", "displacement")
        assert list(file["case"][:]) == ["c1", "d1", "e0", "e3", "c12"]
        assert list(file["seed"][:]) == [1, 2]
        cases = zip(file["shape"][:], file["density"][:], strict=True)
        for case, (shape, density) in enumerate(cases):
            for k, seed in enumerate(file["seed"][:]):
                one = runs[shape, float(density), int(seed)]
                for name in ("drag", "transverse_force", "wall_force", "time_step"):
                    np.testing.assert_array_equal(file[name][case, k], one[name])


def test_bits_do_not_depend_on_chunks_or_processes(finished, tmp_path):
    """The last run of a chunk has the same bits in its own chunk and store, one process at a time."""
    folder = tmp_path / "alone"
    shutil.copytree(finished, folder, ignore=shutil.ignore_patterns("results", ".snakemake"))
    text = (folder / SMOKE).read_text().replace("case: all", "case: [c1, e3]")
    text = text.replace("seed: [1, 2]", "seed: 2") + "\nbatch: 1\n"
    (folder / "config/alone.yaml").write_text(text)
    assert planned(folder, configfile="config/alone.yaml")["batch"] == 2
    run = snakemake(folder, "results/smoke/drag.nc", "-j1", configfile="config/alone.yaml")
    assert run.returncode == 0, run.stderr
    one, two = (runs_of(each / "results/smoke") for each in (finished, folder))
    assert len(two) == 2
    for name, values in two.items():
        for variable in values.keys() - NOT_COMPARED:
            np.testing.assert_array_equal(values[variable], one[name][variable], err_msg=variable)


def test_another_sweep_takes_what_is_there(finished):
    """Batches of the store are taken: another file, folder, order and size of batches of the same runs."""
    text = (
        "extends: config/smoke.yaml\nresults: results/again\nbatch: 1\nsweep: {case: [c12, c1]}\n"
    )
    (finished / "config/again.yaml").write_text(text)
    chunks = {
        path: path.stat().st_mtime_ns for path in (finished / "results/store/batches").iterdir()
    }
    run = snakemake(finished, "results/again/drag.nc", "-j2", configfile="config/again.yaml")
    assert run.returncode == 0, run.stderr
    assert chunks == {path: path.stat().st_mtime_ns for path in chunks}
    assert planned(finished) == {}
    one, two = (contents(finished / f"results/{name}/drag.nc") for name in ("smoke", "again"))
    np.testing.assert_array_equal(two["drag"], one["drag"][[4, 0]][:, :1])


def test_what_is_forced_is_made_again(finished, tmp_path):
    """One file, the jobs of a rule, or all, with the same bits; the same command without it finds them."""
    folder = tmp_path / "forced"
    shutil.copytree(finished, folder, symlinks=True)
    before = contents(folder / "results/smoke/drag.nc")
    files = {
        path: path.stat().st_mtime_ns for path in (folder / "results/store/batches").glob("*.nc")
    }
    own = SweepState.of(folder / SMOKE, folder).files("drag")  # others are of studies
    one = own[0]
    run = snakemake(folder, "-j2", "-f", str(one.relative_to(folder)))
    assert run.returncode == 0, run.stderr
    assert [path for path, at in files.items() if path.stat().st_mtime_ns > at] == [one]
    assert planned(folder, "results/smoke/drag.nc", "-R", "combine") == {"combine": 1}
    run = snakemake(folder, "results/smoke/drag.nc", "-j2", "-F")
    assert run.returncode == 0, run.stderr
    assert {path for path, at in files.items() if path.stat().st_mtime_ns > at} == set(own)
    for name, values in contents(folder / "results/smoke/drag.nc").items():
        np.testing.assert_array_equal(values, before[name], err_msg=name)
    assert planned(folder, "results/smoke/drag.nc") == {}


@pytest.mark.parametrize("change", ["an edit", "a missing file"])
def test_one_job_draws_only_the_figures_that_changed(finished, tmp_path, change):
    """One process for all, which leaves those that the same code drew of the same results."""
    folder = tmp_path / "edited"
    shutil.copytree(finished, folder, ignore=shutil.ignore_patterns("store"))
    figures = folder / "results/smoke/figures"
    if change == "an edit":
        with (folder / "dem/figures/figure13.py").open("a") as module:
            module.write("\nEDITED = True\n")
    else:
        (figures / "figure13.svg").unlink()
    drawn = {path: path.stat().st_ino for path in figures.iterdir()}
    targets = [str(path.relative_to(folder)) for path in figures.glob("*.png")]
    assert planned(folder, *targets) == {"figures_results_smoke": 1}
    run = snakemake(folder, "-j2", *targets)
    assert run.returncode == 0, run.stdout + run.stderr
    replaced = {path.stem for path in figures.iterdir() if path.stat().st_ino != drawn.get(path)}
    assert replaced == {"figure13"}
    assert planned(folder, *targets) == {}


def test_jobs_run_the_python_of_snakemake(finished, tmp_path):
    """Called by its path, with nothing on PATH and another package named dem before this one."""
    other = tmp_path / "dem"
    other.mkdir()
    (other / "__init__.py").write_text("raise SystemExit('another dem')")
    figure = finished / "results/smoke/figures/figure13.svg"
    before = figure.stat().st_mtime_ns
    command = [
        Path(sys.executable).with_name("snakemake"),
        "-j1",
        "-f",
        str(figure.relative_to(finished)),
        "--configfile",
        SMOKE,
    ]
    run = subprocess.run(
        command,
        cwd=finished,
        text=True,
        capture_output=True,
        env=os.environ | {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(tmp_path)},
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert figure.stat().st_mtime_ns > before


def test_a_killed_run_is_taken_up_again(finished):
    """After SIGKILL in the middle the same command finishes, with the bits of an undisturbed run."""
    (finished / "config/killed.yaml").write_text(
        "extends: config/smoke.yaml\nresults: results/killed\npacking: {size_spread: 0.19}\n"
        "sweep: {case: [c1, d1], seed: [1, 2]}\n"
    )
    target = "results/killed/drag.nc"  # figures are drawn elsewhere
    command = [
        sys.executable,
        "-m",
        "snakemake",
        target,
        "-j2",
        "--configfile",
        "config/killed.yaml",
    ]
    victim = subprocess.Popen(
        command,
        cwd=finished,
        env=environment(finished),
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    results = finished / "results/killed"
    for _ in range(600):
        if list((finished / "results/store/runs").rglob("*.npz")) or victim.poll() is not None:
            break
        time.sleep(0.1)
    os.killpg(victim.pid, signal.SIGKILL)
    victim.wait()
    assert not (results / "drag.nc").exists()
    kept = {
        path: path.stat().st_mtime_ns for path in (finished / "results/store/runs").rglob("*.npz")
    }
    run = snakemake(finished, target, "-j2", configfile="config/killed.yaml")
    assert run.returncode == 0, run.stderr
    assert kept and not list((finished / "results/store/runs").rglob("*.npz"))
    one = contents(results / "drag.nc")
    sweep = load(finished / "config/killed.yaml")
    for point, run in list(sweep.block("drag").runs.items())[::3]:
        alone = dem.run_experiment(run.values())
        np.testing.assert_array_equal(one["drag"][point], alone["drag"].values)


def test_what_jobs_finish_after_snakemake_is_killed_is_kept(finished):
    """They go on without it; the next start takes their batches as they are."""
    (finished / "config/alone.yaml").write_text(
        "extends: config/smoke.yaml\nresults: results/alone\npacking: {size_spread: 0.18}\n"
        "sweep: {case: [c1, d1], seed: [1]}\nbatch: 1\n"
    )
    target, batches = "results/alone/drag.nc", finished / "results/store/batches"
    before = set(batches.glob("*.nc"))
    victim = subprocess.Popen(
        [sys.executable, "-m", "snakemake", target, "-j2", "--configfile", "config/alone.yaml"],
        cwd=finished,
        env=environment(finished),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    logs = finished / "results/alone/logs/batches"
    while not list(logs.glob("*.log")):  # until a job has begun
        assert victim.poll() is None
        time.sleep(0.05)
    victim.kill()
    victim.wait()
    victim.stderr.read()  # until its jobs have ended, which have it too
    kept = {path: path.stat().st_mtime_ns for path in set(batches.glob("*.nc")) - before}
    run = snakemake(finished, target, "-j2", configfile="config/alone.yaml")
    assert run.returncode == 0, run.stderr
    assert kept and kept == {path: path.stat().st_mtime_ns for path in kept}


@pytest.fixture(scope="module")
def own(finished, tmp_path_factory):
    """A copy with a small sweep of runs that are there, in results/own."""
    folder = tmp_path_factory.mktemp("own") / "copy"
    shutil.copytree(finished, folder, symlinks=True)
    text = "extends: config/smoke.yaml\ntitle: one\nresults: results/own\nsweep: {case: [c1, c12], seed: [1, 2]}\n"
    (folder / OWN).write_text(text)
    run = snakemake(folder, "results/own/drag.nc", "-j2", configfile=OWN)
    assert run.returncode == 0, run.stderr
    return folder


OWN = "config/own.yaml"


def test_a_job_that_fails_leaves_what_was_good(own):
    """A damaged batch is named, and the next start tries again until it is mended."""
    result, target = own / "results/own/drag.nc", "results/own/drag.nc"
    (run, *_) = contents(result)["run_id"].ravel()
    paths = (own / "results/store/batches").glob("*.nc")
    chunk = next(path for path in paths if run in contents(path)["run_id"])
    kept = chunk.read_bytes()
    file = own / OWN
    text = file.read_text()
    chunk.write_bytes(kept[:20000])
    file.write_text(text.replace("title: one", "title: changed"))
    for _ in range(2):
        run = snakemake(own, target, "-j2", configfile=OWN)
        assert run.returncode == 1 and "its content is not what was written" in run.stderr
    chunk.write_bytes(kept)
    assert planned(own, target, configfile=OWN) == {"combine": 1}
    assert snakemake(own, target, "-j2", configfile=OWN).returncode == 0
    with netCDF4.Dataset(result) as one:
        assert (one.title, one.sweep_file) == ("changed", OWN)
    assert planned(own, target, configfile=OWN) == {}
    file.write_text(text)


def test_another_sweep_of_a_folder_is_refused(own):
    """Also in a dry run, and where values of the command line make it one; nothing is written."""
    (own / "config/other.yaml").write_text(
        (own / OWN).read_text().replace("seed: [1, 2]", "seed: 1")
    )
    before = {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}
    for words, file in (
        (["-n"], "config/other.yaml"),
        (["-j1"], "config/other.yaml"),
        (["-j1", "--config", "title=two"], OWN),
    ):
        run = snakemake(own, "results/own/drag.nc", *words, configfile=file)
        assert (
            run.returncode == 1 and "has the results of config/own.yaml" in run.stdout + run.stderr
        ), words
    assert before == {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}
    (own / OWN).write_text((own / OWN).read_text().replace("seed: [1, 2]", "seed: [2, 3]"))
    run = snakemake(own, "results/own/drag.nc", "-n", configfile=OWN)
    assert run.returncode == 0


def test_a_wrong_configuration_writes_nothing(copy, monkeypatch):
    """One sentence with key and value: before Snakemake's own lines, and all that dem sweep says."""
    text = (copy / SMOKE).read_text().replace("results/smoke", "results/wrong")
    (copy / "config/wrong.yaml").write_text(text.replace("wall: 0.3", "wall: -0.3"))
    run = snakemake(copy, "-j1", configfile="config/wrong.yaml")
    assert run.returncode == 1
    sentence = "config/wrong.yaml: friction.wall is -0.3; it must be at least 0.\n"
    assert 0 < run.stderr.index(sentence) < run.stderr.index("  File ")
    monkeypatch.chdir(copy)
    alone = CliRunner().invoke(app, ["sweep", "config/wrong.yaml"])
    assert (alone.exit_code, alone.stdout, alone.stderr) == (2, "", sentence)
    assert not (copy / "results/wrong").exists()


MODULES = """
module one:
    snakefile: "{0}/Snakefile"
    config: {{"extends": "{0}/config/smoke.yaml", "results": "results/one", "sweep": {{"case": ["c1"], "seed": [1, 2]}}}}
    prefix: "a"

module two:
    snakefile: "{0}/Snakefile"
    config: {{"extends": "{0}/config/smoke.yaml", "results": "results/two", "sweep": {{"case": ["d1"], "seed": 1}}}}
    prefix: "b"

use rule * from one as one_*
use rule * from two as two_*

rule both:
    default_target: True
    input: "a/results/one/drag.nc", "b/results/two/figures/figure13.svg"
"""


def test_a_workflow_uses_two_sweeps_as_modules(finished, tmp_path):
    """From another working folder, with Snakemake's own defaults; nothing is made twice, and reported."""
    (tmp_path / "Snakefile").write_text(MODULES.format(finished))
    for options, words in (
        (["-j2"], "steps (100%) done"),
        (["-j2"], "Nothing to be done"),
        (["--report", "report.html"], "Report created"),
    ):
        run = subprocess.run(
            [sys.executable, "-m", "snakemake", *options],
            cwd=tmp_path,
            text=True,
            capture_output=True,
            env=environment(finished),
        )
        assert run.returncode == 0 and words in run.stdout + run.stderr, run.stdout + run.stderr
    assert FIGURES["figure13"].caption in (tmp_path / "report.html").read_text()
    one, whole = (
        contents(path / "drag.nc")
        for path in (tmp_path / "a/results/one", finished / "results/smoke")
    )
    np.testing.assert_array_equal(one["drag"][0], whole["drag"][0])
    assert_not_blank(tmp_path / "b/results/two/figures/figure13.png")


def test_the_workflow_is_drawn_and_linted(finished):
    """By --dag a box a job, by --rulegraph a box a rule; --lint asks for no more than conda or containers."""
    batches = {}
    for option in ("--dag", "--rulegraph"):
        drawn = snakemake(finished, "results/smoke/drag.nc", option)
        assert drawn.returncode == 0 and "digraph" in drawn.stdout, drawn.stderr
        names = dict(re.findall(r'(\d+)\[label = "(\w+)', drawn.stdout))
        arrows = [(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", drawn.stdout)]
        assert set(arrows) == {("batch", "combine")}
        batches[option] = len(arrows)
    assert batches == {"--dag": 3, "--rulegraph": 1}
    said = snakemake(finished, "--lint").stderr
    complaints = re.findall(r"(?m)^ +\* (.*)", said)
    assert set(complaints) <= {"Specify a conda environment or container for each rule.:"}, said


def test_files_follow_the_cf_conventions(finished):
    """Every kind of netCDF file passes the checker for CF-1.11, in the classic model, which other programs read."""
    results = finished / "results/smoke"
    paths = [
        next(results.glob(name)) for name in ("drag.nc", "snapshots.nc", "../store/batches/*.nc")
    ]
    for path in paths:
        with netCDF4.Dataset(path) as file:
            assert file.data_model == "NETCDF4_CLASSIC"
    run = subprocess.run(
        ["compliance-checker", "--test=cf:1.11", *map(str, paths)],
        text=True,
        capture_output=True,
        env=environment(finished),
    )
    assert run.returncode == 0, run.stdout
