"""Small sweeps that several tests share, made whole in a folder."""

from contextlib import chdir
from pathlib import Path

from typer.testing import CliRunner

from conftest import assert_not_blank
from dem.analysis.flow.collect import measure_batch, write_flow
from dem.figures.catalogue import FIGURES, draw, possible
from dem.sweep import batch as making
from dem.sweep.campaign import Campaign
from dem.sweep.config import parse
from dem.sweep.workers import Workers

SMOKE = Path(__file__).parent.parent / "config/smoke.yaml"


def of_file(file: Path) -> Campaign:
    """The sweep of a file, made in this process."""
    work = Campaign.of(file)
    work.make(Workers())
    return work


def assert_shown_and_drawn(study: str, path: Path) -> None:
    """The file of a study can be shown, and its figures drawn."""
    from studies.__main__ import app
    from studies.catalogue import figures

    run = CliRunner().invoke(app, [study, "info", str(path)])
    assert run.exit_code == 0, run.output
    for name in [name for name, each in figures().items() if each.file == study]:
        assert_not_blank(draw(name, path, path.parent, figures())[1])


def run_all(work: Campaign) -> None:
    """Make the runs of all blocks in this process, round by round, and combine their drag."""
    for name in work.sweep.blocks:
        while True:
            work.begin(name)
            for each in work.batches(name):
                if not work.store.file_of(each.id).is_file():
                    making.make(work.store, each.id)
            if not work.grow(name):
                break
        work.combine(name, "drag", work.first(name))


def made(folder: Path, flow: bool = False, **values) -> Campaign:
    """A sweep of config/smoke.yaml with other values, made in `folder`/results, with its figures.

    flow: whether flow.nc is made too, of the snapshots.
    """
    with chdir(folder):
        work = Campaign(parse({"extends": str(SMOKE), "results": "results", **values}))
        (block,) = work.sweep.blocks
        chunks = work.batches(block)
        work.begin(block)
        for each in chunks:
            making.make(work.store, each.id)
        for name in work.observables(block):
            work.combine(block, name, Path(f"results/{name}.nc"))
        if flow:
            for each in work.files(block):
                measure_batch(each, Path("results/flow") / each.name)
            write_flow(work, block, Path("results/flow.nc"))
            for name in possible(work.block(block)):
                if FIGURES[name].file == "flow":
                    draw(name, Path("results/flow.nc"), Path("results/figures"))
        draw("all", Path("results/drag.nc"), Path("results/figures"))
    return work
