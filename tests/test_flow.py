"""How beds move: measures with known answers, pictures, films, exports."""

from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr
from conftest import STIFF, assert_not_blank
from PIL import Image
from typer.testing import CliRunner

import dem
from dem.analysis.flow import measures
from dem.analysis.flow.collect import collect, write_flow
from dem.analysis.flow.motion import read_motion
from dem.analysis.flow.verdict import compared
from dem.cli.app import app
from dem.experiment import drag
from dem.figures.export import export
from dem.figures.film import encoder, film, picture
from dem.io.dataset import VARIABLES
from dem.report.info import summary
from dem.studies.config import load


@pytest.fixture(scope="module")
def grid():
    """A square grid of 100 points, 1 mm apart, a little disturbed."""
    place = 1e-3 * np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), axis=-1).reshape(-1, 2)
    return place + 1e-4 * np.random.default_rng(1).normal(size=place.shape)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two cases of the smoke sweep with one seed, as files, and that sweep."""
    sweep = load(Path(__file__).parent.parent / "config/smoke.yaml")
    sweep = sweep.model_copy(
        update={
            "seeds": (1,), "cases": {name: sweep.cases[name] for name in ("c1", "e3")},
            "record": sweep.record.model_copy(update={"snapshots": 13}),
        }
    )  # fmt: skip
    files = []
    for name, case in sweep.cases.items():
        replicate = sweep.replicate(case.shape, case.density, 1)
        files.append(tmp_path_factory.mktemp("runs") / f"{name}.nc")
        drag.write_replicate(files[-1], replicate, drag.run(replicate, drag.make_bed(replicate)))
    return sweep, files


def test_affine_motions_are_not_irregular(grid):
    """Shear, rotation and expansion leave D2min at zero; one granule that jumps does not."""
    moved = grid @ np.array([[1.1, 0.3], [-0.2, 0.9]]) + [5e-3, -2e-3]
    assert np.abs(measures.non_affine(grid, moved, 1e-3)).max() < 1e-20
    jumped = grid.copy()
    jumped[44] += [3e-4, 0.0]
    found = measures.non_affine(grid, jumped, 1e-3)
    assert found[44] > 0.02 and found[44] == found.max() and found[99] < 1e-20


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
    assert measures.lost({(0, 1), (1, 2), (2, 3), (3, 4)}, {(0, 1), (8, 9)}) == 0.75
    assert np.isnan(measures.lost(set(), {(0, 1)}))


@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_contact_forces_on_a_granule_at_rest_balance(small_bed, kind, fraction):
    """The normal forces on every granule of a packed bed add up to nothing."""
    small = small_bed(kind, fraction=fraction)
    found = dem.Simulation(small.scene(), small.state).contacts()
    net, push = np.zeros((60, 2)), found.force[:, None] * found.normal
    np.add.at(net, found.granule, -push)
    pairs = found.partner >= 0
    np.add.at(net, found.partner[pairs], push[pairs])
    assert len(found.force) > 60 and (found.force > 0.0).all()
    assert np.abs(net).max() < 1e-5 * found.force.max()
    assert set(found.partner[~pairs]) <= {-1, -2, -3, -4, -5} and (found.partner == -1).any()
    walls = found.partner == -2  # the left one: its contacts lie on it
    assert np.abs(found.point[walls, 0]).max() < 0.5e-3


def test_motion_is_what_was_recorded(runs):
    """Snapshots, geometry and drag of a file come back as they were written."""
    sweep, files = runs
    motion = read_motion(files[1])
    assert motion.replicate.label == "e3" and motion.position.shape == (13, 60, 2)
    assert motion.nearest(0.61e-3) == 6
    assert np.ptp(motion.cylinder_y) == pytest.approx(sweep.cylinder.stroke)
    areas = motion.outlines[:, 0]
    x, y = areas[..., 0], areas[..., 1]
    shoelace = 0.5 * np.abs((x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]).sum(axis=1))
    np.testing.assert_allclose(shoelace, np.pi / 4 * motion.diameters**2, rtol=0.01)


def test_flow_nc(runs, tmp_path):
    """Measures of every run and the snapshots of one a case; a missing or a foreign run is named."""
    sweep, files = runs
    values = collect(files[::-1], sweep)
    write_flow(tmp_path / "flow.nc", sweep, values)
    with xr.open_dataset(tmp_path / "flow.nc") as flow:
        assert flow["non_affine"].dims == ("case", "seed", "snapshot")
        assert float(flow["non_affine"].isel(snapshot=-1).min()) > 0.0
        assert (flow["mixing"].isel(snapshot=0) == 0.0).all()
        lost = flow["contacts_lost"].isel(snapshot=slice(6, None)).values
        assert ((lost >= 0.0) & (lost <= 1.0)).all() and lost.max() > 0.0
        motion = read_motion(files[0])
        np.testing.assert_array_equal(flow["bed_x"].sel(case="c1"), motion.position[..., 0])
    assert "Irregularity" in str(
        summary(tmp_path / "flow.nc").renderables[1]
    )  # one run: no verdict
    with pytest.raises(dem.InputError, match="none of the files"):
        collect(files[:1], sweep)
    with pytest.raises(dem.InputError, match="twice"):
        collect([files[0], files[0]], sweep)


def test_verdicts_of_known_flows():
    """Twice as irregular is found to be so, with an interval that covers it."""
    rng = np.random.default_rng(3)
    runs = np.array([[1.0], [2.0]]) * rng.normal(1.0, 0.1, (2, 40))
    dataset = xr.Dataset(
        {"mixing": (("case", "seed", "snapshot"), runs[..., None] * np.ones(4))},
        {
            "case": ["round", "long"],
            "shape": ("case", ["c1", "e3"]),
            "density": ("case", [1.0, 1.0]),
            "displacement": ("snapshot", [0.0, 1e-3, 2e-3, 9e-3]),
        },
        {"window_start": 1e-3, "window_stop": 5e-3},
    )
    found = compared(dataset, "mixing")
    assert abs(found.ratio - 2.0) < found.half < 0.2 and found.runs == 40
    assert compared(dataset.sel(case=["round"]), "mixing") is None


@pytest.mark.parametrize(("color", "forces"), [("speed", False), ("force", True), ("layer", True)])
def test_films_and_pictures(runs, tmp_path, color, forces):
    """A frame a snapshot, at 720p, in which granules are drawn and move; pictures by the name."""
    motion, seen = read_motion(runs[1][0]), []
    written = film(motion, tmp_path / "bed.gif", color, forces, seen.append)
    with Image.open(written) as frames:
        assert (frames.n_frames, frames.size) == (13, (1280, 720))
        first = np.asarray(frames.convert("RGB")).astype(int)
        frames.seek(12)
        last = np.asarray(frames.convert("RGB")).astype(int)
    assert (np.abs(last - first).max(axis=2) > 50).mean() > 0.01
    assert seen[-1] == 1.0 and not list(tmp_path.glob("*.part"))
    picture(motion, tmp_path / "bed.png", 1e-3, color, forces)
    with Image.open(tmp_path / "bed.png") as drawn:
        assert drawn.size == (1280, 720)
    assert_not_blank(tmp_path / "bed.png")


@pytest.mark.skipif(encoder() is None, reason="there is no ffmpeg")
def test_a_film_is_a_film(runs, tmp_path):
    """MP4 where there is an encoder."""
    written = film(read_motion(runs[1][0]), tmp_path / "bed.mp4", "cluster", False)
    assert written.suffix == ".mp4" and written.read_bytes()[4:8] == b"ftyp"


def test_export_for_paraview(runs, tmp_path):
    """Polygons with the granules' areas and numbers, a file a snapshot, and one that lists them."""
    motion = read_motion(runs[1][1])
    listed = export(motion, tmp_path / "vtk").read_text()
    assert listed.count("<DataSet") == 13
    mesh = meshio.read(tmp_path / "vtk/bed0012.vtu")
    corners = mesh.cells[0].data
    x, y = np.moveaxis(mesh.points[corners][..., :2], -1, 0)
    area = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    number = mesh.cell_data["granule"][0]
    assert number.tolist() == [*range(60), -1]
    np.testing.assert_allclose(area[:60], np.pi / 4 * motion.diameters**2, rtol=0.01)
    np.testing.assert_allclose(x[:60].mean(axis=1), motion.position[12, :, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["film", "RUN", "-o", "bed.avi"], "bed.avi"),
        (["film", "none.nc", "-o", "bed.mp4"], "none.nc"),
        (["film", "RUN", "-o", "bed.mp4", "--color", "mauve"], "mauve"),
        (["picture", "RUN", "-o", "bed.txt"], "bed.txt"),
        (["picture", "BED", "-o", "bed.png"], "snapshot_displacement"),
    ],
)
def test_bad_input_is_one_sentence(runs, tmp_path, monkeypatch, arguments, words):
    """Exit status 2, the value named, nothing written."""
    monkeypatch.chdir(tmp_path)
    replicate = runs[0].replicate("c1", 3.9e3, 1)
    drag.write_bed(tmp_path / "packed.nc", replicate, drag.make_bed(replicate))
    names = {"RUN": str(runs[1][0]), "BED": "packed.nc"}
    ran = CliRunner().invoke(app, [names.get(a, a) for a in arguments])
    assert ran.exit_code == 2 and words in ran.output and ran.output.count("\n") == 1
    assert [file.name for file in tmp_path.iterdir()] == ["packed.nc"]


def test_layout_of_replicates_has_all_that_motion_reads():
    """The names that pictures need are in the table of the files."""
    from dem.analysis.flow.motion import READ

    assert set(READ) <= set(VARIABLES)
