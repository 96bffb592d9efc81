"""How beds move: measures with known answers, pictures, films, exports."""

import re
import shutil

import meshio
import numpy as np
import pytest
import xarray as xr
from beds import STIFF
from matplotlib.figure import Figure
from pictures import assert_not_blank
from PIL import Image
from sweeps import make_sweep
from typer.testing import CliRunner

import dem
from dem.analysis.one_run import open_run, read_snapshots
from dem.base.errors import InputError
from dem.cli.app import app
from dem.experiment.granule_sizes import diameters_of
from dem.experiment.intruders import width_of
from dem.experiment.observables import flow as measures
from dem.experiment.snapshots import Snapshots
from dem.figures.bed import draw, view_of
from dem.figures.export import export
from dem.figures.film import film, picture
from dem.figures.frames import of_motion
from dem.sweep.config import load


@pytest.fixture(scope="module")
def grid():
    """A square grid of 100 points, 1 mm apart, a little disturbed."""
    point = 1e-3 * np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), axis=-1).reshape(-1, 2)
    return point + 1e-4 * np.random.default_rng(1).normal(size=point.shape)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of two cases of the smoke sweep with one seed."""
    folder = tmp_path_factory.mktemp("runs")
    record = {"snapshots": 13, "observables": ["drag", "flow", "snapshots"]}
    make_sweep(folder, sweep={"case": ["c1", "e3"], "seed": [1, 2]}, record=record)
    return folder / "results"


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Results of a sweep over three axes."""
    folder = tmp_path_factory.mktemp("swept")
    make_sweep(
        folder,
        sweep={
            "shape": ["c1", "d1"],
            "friction.granule": [0.1, 0.3],
            "box": {
                "wide": {"box_width": 10e-3, "shapes.c1.granules": 75},
                "same": {"box_width": 8e-3},
            },
            "seed": "1 to 2",
        },
    )
    return folder / "results"


@pytest.fixture
def motion(results):
    """The run of discs."""
    return read_snapshots(results / "drag.nc", ["case=c1", "seed=1"])


def test_affine_motions_are_not_irregular(grid):
    """Shear, rotation and expansion leave D2min at zero; one granule that jumps does not."""
    image = grid @ np.array([[1.1, 0.3], [-0.2, 0.9]]) + [5e-3, -2e-3]
    assert np.abs(measures.non_affine(grid, image, 1e-3)).max() < 1e-20
    jumped = grid.copy()
    jumped[44] += [3e-4, 0.0]
    d2min = measures.non_affine(grid, jumped, 1e-3)
    assert d2min[44] > 0.02 and d2min[44] == d2min.max() and d2min[99] < 1e-20


def test_a_bed_that_moves_as_one_does_not_fluctuate(grid):
    """Translation has no fluctuation, however far; a jump is measured in full, less its neighbours'."""
    assert measures.fluctuation(grid, grid + [1.0, 2.0], 1e-3).max() < 1e-12
    jumped = grid.copy()
    jumped[44] += [3e-4, 0.0]
    assert measures.fluctuation(grid, jumped, 1e-3)[44] == pytest.approx(3e-4, rel=1e-9)


def test_layers_that_do_not_mix(grid):
    """Layers that slide as blocks far apart mix no more; shuffled granules mix to the share of chance."""
    layers = measures.layers_of(grid, 10e-3)
    start = measures.mixing(layers, grid, 1e-3)
    assert measures.mixing(layers, grid + [1.0, 0.0], 1e-3) == start
    shuffled = np.random.default_rng(2).permutation(layers)
    counts = np.bincount(layers) / len(layers)
    assert start < 0.7 < measures.mixing(shuffled, grid, 1e-3)
    assert measures.mixing(shuffled, grid, 1e-3) == pytest.approx(1.0 - (counts**2).sum(), abs=0.08)


def test_lost_contacts_are_a_share_of_those_before():
    """A share of those before, whatever is new."""
    assert measures.lost(np.array([1, 12, 23, 34]), np.array([1, 89])) == 0.75
    assert np.isnan(measures.lost(np.array([]), np.array([1])))


@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_contact_forces_on_a_granule_at_rest_balance(small_bed, kind, fraction):
    """The normal forces on every granule of a packed bed add up to nothing."""
    small = small_bed(kind, fraction=fraction)
    contacts = dem.Simulation(small.scene(), small.state).contacts()
    net, push = np.zeros((60, 2)), contacts.force[:, None] * contacts.normal
    np.add.at(net, contacts.granule, -push)
    pairs = contacts.partner >= 0
    np.add.at(net, contacts.partner[pairs], push[pairs])
    assert len(contacts.force) > 60 and (contacts.force > 0.0).all()
    assert np.abs(net).max() < 1e-5 * contacts.force.max()
    assert set(contacts.partner[~pairs]) <= {-1, -2, -3, -4, -5} and (contacts.partner == -1).any()
    walls = contacts.partner == -2  # the left one: its contacts lie on it
    assert np.abs(contacts.point[walls, 0]).max() < 0.5e-3


def test_motion_is_what_was_recorded(results):
    """Snapshots, geometry and drag of a run come back as they were written."""
    motion = read_snapshots(results / "drag.nc", ["case=e3", "seed=1"])
    configuration = motion.replicate.configuration
    assert motion.replicate.label == "e3" and motion.position.shape == (13, 60, 2)
    assert motion.nearest(0.61e-3) == 6
    assert np.ptp(motion.displacement) == pytest.approx(configuration.cylinder.stroke)
    areas = motion.outlines[:, 0]
    x, y = areas[..., 0], areas[..., 1]
    shoelace = 0.5 * np.abs((x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]).sum(axis=1))
    np.testing.assert_allclose(shoelace, np.pi / 4 * motion.diameters**2, rtol=0.01)
    with xr.open_dataset(results / "drag.nc") as data:
        np.testing.assert_array_equal(motion.drag, data["drag"].sel(case="e3", seed=1))


def test_recorded_measures_are_those_of_the_snapshots(results, motion):
    """To the bit, over the axes of the sweep."""
    with xr.open_dataset(results / "flow.nc") as flow:
        assert flow["non_affine"].dims == ("case", "seed", "snapshot")
        assert float(flow["non_affine"].isel(snapshot=-1).min()) > 0.0
        assert (flow["mixing"].isel(snapshot=0) == 0.0).all()
        lost = flow["contacts_lost"].isel(snapshot=slice(6, None)).values
        assert ((lost >= 0.0) & (lost <= 1.0)).all() and lost.max() > 0.0
        for name, expected in measures.measures(motion).items():
            np.testing.assert_array_equal(flow[name].sel(case="c1", seed=1), expected)


def test_beds_of_the_first_seed_of_each_case_are_in_one_file(results, motion):
    """Where a case has fewer granules than another, the rest is missing."""
    with xr.open_dataset(results / "snapshots.nc") as beds:
        assert beds["granule_x"].dims == ("case", "seed", "snapshot", "granule")
        assert beds["seed"].values.tolist() == [1]
        one = beds.sel(case="c1", seed=1)
        np.testing.assert_array_equal(one["granule_x"], motion.position[..., 0])
        np.testing.assert_array_equal(one["granule_diameter"], motion.diameters)


def test_a_run_is_found_by_its_values(swept):
    """By axes, by labels and by paths, in the combined file and in the file of its runs."""
    words = ["shape=d1", "friction.granule=0.3", "box=wide", "seed=2"]
    replicate, values = open_run(swept / "drag.nc", words)
    configuration = replicate.configuration
    assert (replicate.label, replicate.seed) == ("d1", 2)
    assert (configuration.friction.granule, configuration.box_width) == (0.3, 10e-3)
    with xr.open_dataset(swept / "drag.nc") as data:
        point = {"shape": "d1", "friction_granule": 0.3, "box": "wide", "seed": 2}
        np.testing.assert_array_equal(values["drag"], data["drag"].sel(point))
    assert of_motion(read_snapshots(swept / "drag.nc", words)).title == (
        "d1, 3900 kg/m³, seed 2, friction.granule=0.3, box=wide"
    )  # as a picture of it says
    by_label = ["shape=d1", "friction_granule=0.3", "box_width=0.01", "seed=2"]
    assert open_run(swept / "drag.nc", by_label)[0].id == replicate.id
    for chunk in (swept / "store/batches").glob("*.nc"):
        try:
            run = open_run(chunk, [*words[:2], "box_width=0.01", "seed=2"])[0]
        except InputError:
            continue
        assert run.id == replicate.id
        break
    else:
        raise AssertionError("no file holds the run")


@pytest.mark.parametrize(
    ("select", "words"),
    [
        (["shape=d1", "seed=1"], "choose one, such as friction_granule=0.1 box="),
        ([], "it has 16 runs; choose one, such as shape=c1 friction_granule=0.1 box="),
        (
            ["frction.granule=0.1"],
            "its runs have no value named frction.granule; the nearest is fr",
        ),
        (["friction.granule=0.2"], "friction.granule=0.2; friction_granule is 0.1, 0.3"),
        (["shape=e3"], "no run with shape=e3; shape is c1, d1"),
        (["seed=one"], "no run with seed=one; seed is 1, 2"),
        (["d1"], "'d1' selects no run; write NAME=VALUE"),
    ],
)
def test_a_wrong_selection_is_one_sentence(swept, select, words):
    with pytest.raises(InputError, match=re.escape(words)) as error:
        open_run(swept / "drag.nc", select)
    assert "\n" not in str(error.value)


def test_a_run_that_is_gone_or_was_not_watched_is_named(swept, tmp_path):
    """A copy without its chunks; a run in none of them; runs without snapshots."""
    shutil.copy(swept / "drag.nc", tmp_path / "drag.nc")
    words = ["shape=d1", "friction.granule=0.3", "box=wide", "seed=2"]
    with pytest.raises(InputError, match="is in no folder store"):
        read_snapshots(tmp_path / "drag.nc", words)
    make_sweep(tmp_path, sweep={"case": ["c1"], "seed": 1}, record={"observables": ["drag"]})
    with pytest.raises(InputError, match="add snapshots to record"):
        read_snapshots(tmp_path / "results/drag.nc", [])


@pytest.mark.parametrize(("color", "forces"), [("force", True), ("cluster", False)])
def test_films_and_pictures(motion, tmp_path, color, forces):
    """A frame a snapshot, at 720p, in which granules are drawn and move; pictures by the name."""
    progress = []
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


@pytest.mark.parametrize(("data", "run"), [("results", "case=e3 seed=1"), ("swept", "d1")])
def test_export_for_paraview(request, tmp_path, data, run):
    """Polygons with the area of their granule, two a dumbbell; a file a snapshot, and one that lists them."""
    folder = request.getfixturevalue(data)
    select = (
        run.split()
        if "=" in run
        else [f"shape={run}", "friction.granule=0.3", "box=same", "seed=1"]
    )
    motion = read_snapshots(folder / "drag.nc", select)
    export(motion, tmp_path / "vtk/bed.pvd")
    snapshots, granules = motion.angle.shape
    assert (tmp_path / "vtk/bed.pvd").read_text().count("<DataSet") == snapshots
    mesh = meshio.read(tmp_path / f"vtk/bed{snapshots - 1:04d}.vtu")
    polygons, (ring,), lines = (mesh.points[cells.data][..., :2] for cells in mesh.cells)
    x, y = np.moveaxis(polygons, -1, 0)
    area = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    body = mesh.cell_data["granule"][0]
    parts = len(body) // granules
    assert body.tolist() == np.repeat(range(granules), parts).tolist()
    assert mesh.cell_data["granule"][1] == [-1]
    values = {
        name: np.append(parted[0][::parts], parted[1], axis=0)
        for name, parted in mesh.cell_data.items()
    }
    area = area.reshape(granules, parts).sum(axis=1)
    np.testing.assert_allclose(area, np.pi / 4 * motion.diameters**2, rtol=0.01)
    middle = polygons.mean(axis=1).reshape(granules, parts, 2).mean(axis=1)
    np.testing.assert_allclose(middle, motion.position[-1], atol=0.02 * motion.diameters.max())
    cylinder = motion.replicate.configuration.cylinder
    np.testing.assert_allclose(np.ptp(ring, axis=0), cylinder.diameter, rtol=1e-9)
    # what the granules went since the snapshot before, and the cylinder at its velocity
    time = np.diff(motion.displacement)[-1] / cylinder.velocity
    step = np.append(
        np.diff(motion.position[-2:], axis=0)[0], [[0.0, np.diff(motion.displacement)[-1]]], axis=0
    )
    np.testing.assert_allclose(values["velocity"][:, :2] * time, step, rtol=1e-6, atol=1e-12)
    contacts = motion.contacts(snapshots - 1)
    assert (mesh.cell_data["granule"][2] == -2).all() and len(lines) == len(contacts.force)
    np.testing.assert_allclose(mesh.cell_data["force"][2], contacts.force)
    # each force acts on both bodies, and on walls, which have no polygon, alone
    on_walls = contacts.force[contacts.partner < -1].sum()
    assert values["force"].sum() + on_walls == pytest.approx(2.0 * contacts.force.sum())
    between = contacts.partner >= 0
    ends = motion.position[-1][np.stack([contacts.granule, contacts.partner], axis=1)[between]]
    np.testing.assert_allclose(lines[between], ends, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["draw", "none.nc", "-o", "bed.mp4"], "none.nc"),
        (["draw", "DRAG", "case=c1", "seed=1", "-o", "bed.mp4", "--color", "mauve"], "mauve"),
        (["draw", "DRAG", "-o", "bed.png"], "case=c1"),
        (["draw", "BED", "-o", "vtk.pvd"], "holds no runs"),
    ],
)
def test_bad_input_is_one_sentence(results, tmp_path, monkeypatch, arguments, words):
    """Exit status 2, the value named, nothing written."""
    monkeypatch.chdir(tmp_path)
    xr.Dataset({"x": 1.0}).to_netcdf("bed.nc")
    names = {"DRAG": str(results / "drag.nc"), "BED": "bed.nc"}
    result = CliRunner().invoke(app, [names.get(a, a) for a in arguments])
    assert result.exit_code == 2 and words in result.output and result.output.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["bed.nc"]


def test_a_run_of_one_file_is_filmed_by_its_name_alone(results, tmp_path):
    """Verbs take the file of a single run, and drag.nc with what selects one."""
    make_sweep(tmp_path, sweep={"case": ["c1"], "seed": 1}, batch=1)
    (chunk,) = (tmp_path / "results/store/batches").glob("*.nc")
    for number, words in enumerate(([chunk], [results / "drag.nc", "case=e3", "seed=1"])):
        output = tmp_path / f"bed{number}.png"
        result = CliRunner().invoke(app, ["draw", *map(str, words), "-o", str(output)])
        assert result.exit_code == 0, result.output
        assert_not_blank(output)


def test_a_solid_at_rest_at_an_angle_is_drawn_at_this_angle():
    """As a plate that is drawn without turning."""
    sweep = load("config/smoke.yaml")
    changes = {"cylinder.outline": "plate", "cylinder.angle": 0.5}
    run = sweep.changed(changes, "c1").replicate("c1", 3.9e3, 1)
    state = np.full((2, run.shape.granules, 2), 1e-3)
    motion = Snapshots(
        run,
        np.full(2, 8e-3),
        np.array([0.0, 1e-3]),
        state,
        state[..., 0],
        diameters_of(run),
    )
    axes, frames = Figure().subplots(), of_motion(motion)
    draw(axes, frames, 1, view_of(frames))
    (outline,) = axes.collections[2].get_paths()
    width, height = np.ptp(outline.vertices, axis=0)
    rounded = 1e3 * width_of(run.configuration.cylinder)  # of both ends
    assert height - rounded == pytest.approx(np.tan(0.5) * (width - rounded), rel=1e-2)
