"""Pictures, films and exports of a run of a sweep: which run it is, and what is shown of it."""

import re
import shutil
from contextlib import suppress
from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr
from matplotlib import rc_context
from matplotlib.figure import Figure
from numpy.testing import assert_allclose, assert_array_equal
from pictures import assert_not_blank
from PIL import Image
from sweeps import make_sweep, smoke
from typer.testing import CliRunner

from dem.analysis.one_run import open_run, read_snapshots
from dem.base.errors import InputError
from dem.cli.app import app
from dem.experiment.granule_sizes import diameters_of
from dem.experiment.snapshots import Snapshots
from dem.figures.bed import draw, view_of
from dem.figures.export import export
from dem.figures.film import RC, figure_of, film, picture
from dem.figures.frames import of_motion

TOOK = 0.1e-3 / 2.0  # s between two snapshots
WORDS = ["shape=d1", "friction.granule=0.3", "box=wide"]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Results of a sweep over three axes, without snapshots."""
    folder = tmp_path_factory.mktemp("swept")
    boxes = {"wide": {"box_width": 10e-3, "shapes.c1.granules": 75}, "same": {"box_width": 8e-3}}
    sweep = {"shape": ["c1", "d1"], "friction.granule": [0.1, 0.3], "box": boxes, "seed": 1}
    make_sweep(folder, sweep=sweep, record={"observables": ["drag"]}, batch=4)
    return folder / "results"


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Results of two cases and two seeds, with snapshots a tenth of a millimetre apart."""
    folder = tmp_path_factory.mktemp("watched")
    sweep, few = {"case": ["c1", "d1"], "seed": [1, 2]}, {"c1": {"granules": 50}}
    make_sweep(folder, sweep=sweep, shapes=few, record={"snapshots": 13}, batch=1)
    return folder / "results"


def motion_of(watched, case):
    return read_snapshots(watched / "drag.nc", [f"case={case}", "seed=1"])


def test_a_run_is_found_by_its_values(swept, tmp_path):
    """By axes, by labels and by paths, in the combined file and in the file of its runs."""
    run, values = open_run(swept / "drag.nc", WORDS)
    assert (run.label, run.seed) == ("d1", 1)
    assert (run.configuration.friction.granule, run.configuration.box_width) == (0.3, 10e-3)
    with xr.open_dataset(swept / "drag.nc") as data:
        point = {"shape": "d1", "friction_granule": 0.3, "box": "wide", "seed": 1}
        assert_array_equal(values["drag"], data["drag"].sel(point))
    by_label = ["shape=d1", "friction_granule=0.3", "box_width=0.01"]
    found = set()
    for path in (swept / "drag.nc", *(swept / "store/batches").glob("*.nc")):
        with suppress(InputError):
            found.add(open_run(path, by_label)[0].id)
    assert found == {run.id}
    for words, refusal in (
        (["shape=d1"], "choose one, such as friction_granule=0.1 box="),
        ([], "it has 8 runs; choose one, such as shape=c1 "),
    ):
        with pytest.raises(InputError, match=re.escape(refusal)):
            open_run(swept / "drag.nc", words)
    with pytest.raises(InputError, match="add snapshots to record"):
        read_snapshots(swept / "drag.nc", WORDS)
    with pytest.raises(InputError, match="is in no folder store"):
        read_snapshots(Path(shutil.copy(swept / "drag.nc", tmp_path)), WORDS)


@pytest.mark.parametrize("case", ["c1", "d1"])
def test_a_motion_is_what_was_recorded(watched, case):
    """Snapshots and drag. The file of all beds holds the first seed, and gaps where a case has fewer
    granules than another."""
    motion = motion_of(watched, case)
    with xr.open_dataset(watched / "snapshots.nc") as beds:
        assert beds["seed"].values.tolist() == [1] and beds.sizes["granule"] == 60
        one = beds.sel(case=case, seed=1).dropna("granule", subset=["granule_diameter"])
        assert one.sizes["granule"] == (50 if case == "c1" else 60)
        assert_array_equal(motion.position, np.stack([one["granule_x"], one["granule_y"]], axis=-1))
        assert_array_equal(motion.angle, one["granule_angle"])
        assert_array_equal(motion.diameters, one["granule_diameter"])
    with xr.open_dataset(watched / "drag.nc") as data:
        assert_array_equal(motion.drag, data["drag"].sel(case=case, seed=1))
    assert motion.nearest(0.61e-3) == 6
    assert_allclose(motion.displacement, np.linspace(0.0, 1.2e-3, 13))


def test_a_picture_shows_a_snapshot_with_its_drag_and_says_which_run_it_is(watched):
    """Here as a run is found in the file of its batch."""
    for batch in (watched / "store/batches").glob("*.nc"):
        with suppress(InputError):
            motion = read_snapshots(batch, ["seed=1", "shape=c1", "friction.granule=0.3"])
    frames = of_motion(motion)
    assert frames.title == "c1, 3900 kg/m³, seed 1, friction.granule=0.3"
    with rc_context(RC):
        figure, show = figure_of(frames, "speed", False)
    show(7)
    bed, record, *_ = figure.axes
    assert bed.get_title(loc="left") == "0.70 mm"
    outlines = [path.vertices[:-1] for path in bed.collections[0].get_paths()]
    place = [0.5 * (outline.min(axis=0) + outline.max(axis=0)) for outline in outlines]
    assert_allclose(place, 1e3 * motion.position[7], atol=1e-2)
    speed = np.hypot(*(motion.position[7] - motion.position[6]).T) / TOOK
    assert_allclose(bed.collections[0].get_array(), speed, rtol=1e-9)
    curve, mark = record.lines
    assert_allclose(curve.get_xydata(), np.transpose([1e3 * motion.drag_displacement, motion.drag]))
    assert_allclose(mark.get_xdata(), 0.7)


@pytest.mark.parametrize(("color", "forces"), [("force", True), ("cluster", False)])
def test_films_and_pictures(watched, tmp_path, color, forces):
    """A frame a snapshot, at 720p, in which granules are drawn and move; pictures by the name."""
    motion, progress = motion_of(watched, "c1"), []
    written = film(motion, tmp_path / "bed.gif", color, forces, progress.append)
    with Image.open(written) as frames:
        assert (frames.n_frames, frames.size) == (13, (1280, 720))
        first = np.asarray(frames.convert("RGB")).astype(int)
        frames.seek(12)
        last = np.asarray(frames.convert("RGB")).astype(int)
    assert (np.abs(last - first).max(axis=2) > 50).mean() > 0.01
    assert progress[-1] == 1.0 and not list(tmp_path.glob("*.part"))
    picture(motion, tmp_path / "bed.png", 1e-3, color, forces)
    with Image.open(tmp_path / "bed.png") as image:
        assert image.size == (1280, 720)
    assert_not_blank(tmp_path / "bed.png")


@pytest.mark.parametrize("case", [pytest.param("c1", marks=pytest.mark.quick), "d1"])
def test_export_for_paraview(watched, tmp_path, case):
    """Polygons with the area of their granule, two a dumbbell; a file a snapshot, and one that lists them."""
    motion, parts = motion_of(watched, case), {"c1": 1, "d1": 2}[case]
    export(motion, tmp_path / "bed.pvd")
    snapshots, granules = motion.angle.shape
    listed = re.findall(r'timestep="(.*?)" file="(.*?)"', (tmp_path / "bed.pvd").read_text())
    assert_allclose([float(time) for time, _ in listed], motion.displacement, rtol=1e-6)
    files = [name for _, name in listed]
    assert sorted(files) == sorted(path.name for path in tmp_path.glob("*.vtu"))
    assert len(set(files)) == snapshots
    for k in (0, 5, snapshots - 1):
        mesh = meshio.read(tmp_path / files[k])
        polygons, (ring,), lines = (mesh.points[cells.data][..., :2] for cells in mesh.cells)
        body, solid, contact = mesh.cell_data["granule"]
        assert body.tolist() == np.repeat(range(granules), parts).tolist() and solid == [-1]
        x, y = np.moveaxis(polygons, -1, 0)
        area = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
        area = area.reshape(granules, parts).sum(axis=1)
        assert_allclose(area, np.pi / 4 * motion.diameters**2, rtol=0.01)
        middle = polygons.mean(axis=1).reshape(granules, parts, 2).mean(axis=1)
        assert_allclose(middle, motion.position[k], atol=0.02 * motion.diameters.max())
        diameter = motion.replicate.configuration.cylinder.diameter
        assert_allclose(np.ptp(ring, axis=0), diameter, rtol=1e-9)
        above = motion.solids(0)[0].position[1] + motion.displacement[k]
        assert_allclose(ring.mean(axis=0), [4e-3, above], atol=1e-6)
        # what granules went since the snapshot before, or will until the next, and the cylinder
        step = motion.position[max(k, 1)] - motion.position[max(k, 1) - 1]
        velocity = mesh.cell_data["velocity"]
        assert_allclose(velocity[0][::parts, :2] * TOOK, step, rtol=1e-6, atol=1e-12)
        assert_allclose(velocity[1], [[0.0, 2.0, 0.0]])
        contacts, force = motion.contacts(k), mesh.cell_data["force"]
        assert (contact == -2).all()
        assert_allclose(force[2], contacts.force)
        # each force acts on both bodies, and on walls, which have no polygon, alone
        acts = np.where(contacts.partner < -1, 1.0, 2.0)
        bodies = force[0][::parts].sum() + force[1].sum()
        assert bodies == pytest.approx(acts @ contacts.force)
        between = contacts.partner >= 0
        ends = np.stack([contacts.granule, contacts.partner], axis=1)[between]
        assert_allclose(lines[between], motion.position[k][ends], atol=1e-9)


def test_the_command_draws_a_run_of_a_combined_file_and_of_a_file_of_one_run(watched, tmp_path):
    batch = next((watched / "store/batches").glob("*.nc"))
    for number, words in enumerate(([batch], [watched / "drag.nc", "case=d1", "seed=2"])):
        output = tmp_path / f"bed{number}.png"
        result = CliRunner().invoke(app, ["draw", *map(str, words), "-o", str(output)])
        assert result.exit_code == 0, result.output
        assert_not_blank(output)


@pytest.mark.quick
def test_a_solid_at_rest_at_an_angle_is_drawn_at_this_angle():
    changes = {"cylinder.outline": "plate", "cylinder.angle": 0.5}
    run = smoke().changed(changes, "c1").replicate("c1", 3.9e3, 1)
    state = np.full((2, run.shape.granules, 2), 1e-3)
    way = np.array([0.0, 1e-3])
    motion = Snapshots(run, np.full(2, 8e-3), way, state, state[..., 0], diameters_of(run))
    frames, axes = of_motion(motion), Figure().subplots()
    draw(axes, frames, 1, view_of(frames))
    (outline,) = axes.collections[2].get_paths()
    _, _, axis = np.linalg.svd(outline.vertices - outline.vertices.mean(axis=0))
    assert abs(axis[0] @ [-np.sin(0.5), np.cos(0.5)]) < 1e-2  # its longest
