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
from pictures import assert_alone, assert_not_blank
from project import posix
from sweeps import contents, differing
from workflows import SMOKE, completed, edited, environment, planned, snakemake

import dem
from dem.figures.catalogue import FIGURES
from dem.sweep.config import load
from dem.sweep.state import SweepState

pytestmark = posix


REDRAW = ("--profile", "profiles/figures", "figures")  # and no other option behind them


def test_one_command_makes_all_results(checkout_with_claims):
    """Every run once, combined files and figures; of the study of claims a table and figures too. Nothing is made
    twice."""
    results = checkout_with_claims / "results/smoke"
    batches = map(contents, (checkout_with_claims / "results/store/batches").glob("*.nc"))
    runs = [run for batch in batches for run in batch["run_id"].tolist()]
    assert len(runs) == len(set(runs))
    assert {*contents(results / "drag.nc")["run_id"].ravel()} <= {*runs}
    assert (results / "snapshots.nc").is_file() and not list(results.rglob("*.part"))
    assert "drag higher in dumbbells than discs" in (results / "claims.txt").read_text()
    of_claims = [*results.glob("figures/claims_*.png")]
    numbers = "07", "08", "09", "12", "13", "14"
    for picture in [*of_claims, *(results / f"figures/figure{number}.png" for number in numbers)]:
        assert picture.with_suffix(".svg").is_file()
        assert_not_blank(picture)
    assert len(of_claims) == 5 and planned(checkout_with_claims, "claims") == {}


def test_reports_say_what_each_figure_shows_and_open_without_a_network(checkout, request):
    """Snakemake's own, in the list of figures and beside each in the words of its own module, and the page of
    results, which links it."""
    results = checkout / "results/smoke"
    for arguments in (("-j1", "--report", str(results / "provenance.html")), ("-j2", "report")):
        completed(checkout, *arguments)
    page = (results / "provenance.html").read_text()
    drawn = FIGURES.keys() & {path.stem for path in (results / "figures").glob("*.svg")}
    assert len(drawn) >= 6
    for name in drawn:
        assert f"<p>{FIGURES[name].caption}, drawn from" in page
    assert 'href="provenance.html"' in (results / "report.html").read_text()
    assert planned(checkout, "report") == {}
    browser = request.getfixturevalue("browser")  # skipped where there is none
    for name in ("provenance.html", "report.html"):
        browser.get((results / name).as_uri())
        assert_alone(browser)


def stamps(paths):
    """When files were written."""
    return {path: path.stat().st_mtime_ns for path in paths if path.is_file()}


REORDERED = """
extends: config/smoke.yaml
results: results/again
batch: 1
sweep: {case: [c12, c1]}
"""


def test_what_is_there_is_planned_drawn_and_taken_and_not_made(checkout):
    """By the same sweep, by none that the command line names, which is the paper, and by another one of
    the same runs, in other batches, another order and another folder."""
    sweep = load(checkout / SMOKE)
    assert load(checkout / "results/smoke/config.yaml").dump() == sweep.dump()
    assert planned(checkout) == {}
    if (checkout / "studies/accuracy").is_dir():  # whose sweep nothing here asks for
        with edited(checkout, [("studies/accuracy/smoke.yaml", "wrong: [")]):
            assert planned(checkout) == {}
    paper = SweepState.of(checkout / "config/paper.yaml", checkout)
    assert planned(checkout, configfile=None)["batch"] == len(paper.batches("drag"))
    output = snakemake(checkout, "--lint").stderr
    complaints = {*re.findall(r"(?m)^ +\* (.*)", output)}
    assert complaints <= {"Specify a conda environment or container for each rule.:"}, output
    (checkout / "config/again.yaml").write_text(REORDERED)
    batches = stamps((checkout / "results/store/batches").iterdir())
    completed(checkout, "results/again/drag.nc", "-j2", configfile="config/again.yaml")
    assert batches == stamps((checkout / "results/store/batches").iterdir())
    assert planned(checkout) == {}
    one, two = (contents(checkout / f"results/{name}/drag.nc") for name in ("smoke", "again"))
    np.testing.assert_array_equal(two["drag"][:, 0], one["drag"][[4, 0], 0])


def test_what_is_asked_for_is_made_again_with_the_same_bits(checkout, tmp_path):
    """One batch, by the Python of Snakemake, which is called by its path with nothing on PATH and another
    package named dem before this one. All figures, where kernels are newer than the results too, by no other
    process, and nothing is simulated."""
    folder = tmp_path / "forced"
    shutil.copytree(checkout, folder, symlinks=True)
    results = folder / "results/smoke"
    batch, *others = SweepState.of(folder / SMOKE, folder).files("drag")
    combined, times = [results / f"{name}.nc" for name in ("drag", "snapshots")], stamps(others)
    original = [contents(path) for path in (batch, *combined)]
    (tmp_path / "dem").mkdir()
    (tmp_path / "dem/__init__.py").write_text("raise SystemExit('another dem')")
    words = "-j1", "-f", str(batch.relative_to(folder)), "--configfile", SMOKE
    run = subprocess.run(
        [Path(sys.executable).with_name("snakemake"), *words],
        cwd=folder,
        text=True,
        capture_output=True,
        env=os.environ | {"PATH": "/usr/bin:/bin", "PYTHONPATH": str(tmp_path)},
    )
    assert run.returncode == 0, run.stdout + run.stderr
    targets = [str(path.relative_to(folder)) for path in combined]
    assert planned(folder, *targets) == {"combine": 2}
    completed(folder, "-j1", *targets)
    assert times == stamps(others)
    for path, values in zip((batch, *combined), original, strict=True):
        assert differing(contents(path), values) == []
    for name in ("dem/contacts/response.py", "dem/figures/style.py"):
        with (folder / name).open("a") as code:
            code.write("\nEDITED = True\n")
    data, figures = stamps(results.rglob("*.nc")), stamps((results / "figures").iterdir())
    assert planned(folder)["batch"] == 3 and len(figures) >= 16
    assert planned(folder, *REDRAW) == {"figure": len(figures) // 2, "figures": 1}
    (folder / "sitecustomize.py").write_text("open('started', 'w')")  # Python begins with it
    # the dry run names them all; to draw a few of them, as if they were all, is enough
    completed(folder, "-j2", "--batch", "figures=1/8", *REDRAW)
    new = stamps((results / "figures").iterdir())
    assert 2 <= sum(new[path] > at for path, at in figures.items()) < len(figures)
    assert data == stamps(results.rglob("*.nc")) and not (folder / "started").exists()


KILLED = """
extends: config/smoke.yaml
results: results/killed
packing: {size_spread: 0.19}
sweep: {case: [c1, d1], seed: [1, 2]}
"""


def test_a_workflow_goes_on_after_a_kill_and_a_damaged_batch(checkout):
    """The same command finishes, with the bits of runs alone. A damaged batch is named, and the next start
    tries again until it is mended."""
    file, target = checkout / "config/killed.yaml", "results/killed/drag.nc"
    words = {"configfile": "config/killed.yaml"}
    result, runs = checkout / target, checkout / "results/store/runs"
    file.write_text(KILLED)
    victim = subprocess.Popen(
        [sys.executable, "-m", "snakemake", target, "-j2", "--configfile", words["configfile"]],
        cwd=checkout,
        env=environment(checkout),
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while not list(runs.rglob("*.npz")):
        assert victim.poll() is None
        time.sleep(0.05)
    os.killpg(victim.pid, signal.SIGKILL)
    victim.wait()
    assert not result.exists() and list(runs.rglob("*.npz"))
    completed(checkout, target, "-j2", **words)
    assert not list(runs.rglob("*.npz"))
    dataset = contents(result)
    for point, run in list(load(file).block("drag").runs.items())[::3]:
        alone = dem.run_experiment(run.values())
        np.testing.assert_array_equal(dataset["drag"][point], alone["drag"].values)

    batch = SweepState.of(file, checkout).files("drag")[0]
    content = batch.read_bytes()
    batch.write_bytes(content[:20000])
    run = snakemake(checkout, target, "-j2", "--forcerun", "combine", **words)
    assert run.returncode == 1 and "its content cannot be used" in run.stderr
    batch.write_bytes(content)
    completed(checkout, target, "-j2", **words)
    assert planned(checkout, target, **words) == {}


def test_a_wrong_configuration_writes_nothing(copy):
    """One sentence with key and value, before Snakemake's own lines."""
    text = (copy / SMOKE).read_text().replace("results/smoke", "results/wrong")
    (copy / "config/wrong.yaml").write_text(text.replace("wall: 0.3", "wall: -0.3"))
    run = snakemake(copy, "-j1", configfile="config/wrong.yaml")
    sentence = "config/wrong.yaml: friction.wall is -0.3; it must be at least 0.\n"
    assert run.returncode == 1
    assert 0 < run.stderr.index(sentence) < run.stderr.index("  File ")
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


def test_a_workflow_uses_two_sweeps_as_modules(checkout, tmp_path):
    """From another working folder, with Snakemake's own defaults; nothing is made twice."""
    (tmp_path / "Snakefile").write_text(MODULES.format(checkout))
    for words in "steps (100%) done", "Nothing to be done":
        assert words in completed(tmp_path, "-j2", configfile=None, sources=checkout)
    one, whole = (
        contents(path / "drag.nc")
        for path in (tmp_path / "a/results/one", checkout / "results/smoke")
    )
    np.testing.assert_array_equal(one["drag"][0], whole["drag"][0])
    assert_not_blank(tmp_path / "b/results/two/figures/figure13.png")


def test_files_follow_the_cf_conventions(checkout):
    """Every kind of netCDF file passes the checker for CF-1.11, in the classic model, which other programs read."""
    names = "smoke/drag.nc", "smoke/snapshots.nc", "store/batches/*.nc"
    paths = [next((checkout / "results").glob(name)) for name in names]
    for path in paths:
        with netCDF4.Dataset(path) as file:
            assert file.data_model == "NETCDF4_CLASSIC"
    run = subprocess.run(
        ["compliance-checker", "--test=cf:1.11", *map(str, paths)],
        text=True,
        capture_output=True,
        env=environment(checkout),
    )
    assert run.returncode == 0, run.stdout
