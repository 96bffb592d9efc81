"""Pictures, films and exports of a run of a sweep: which run it is, and what is shown of it."""

import re
from contextlib import suppress

import meshio
import numpy as np
import pytest
import xarray as xr
from matplotlib import rc_context
from numpy.testing import assert_allclose, assert_array_equal
from pictures import boxes_shown
from project import quick
from sweeps import make_sweep

from dem.analysis.one_run import open_run, read_snapshots
from dem.base.errors import InputError
from dem.experiment.snapshots import snapshots_of
from dem.figures.export import export
from dem.figures.film import RC, figure_of
from dem.figures.frames import of_motion

TOOK = 0.1e-3 / 2.0  # s between two snapshots


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Results of two cases and two seeds, with snapshots a tenth of a millimetre apart."""
    folder = tmp_path_factory.mktemp("watched")
    sweep, few = {"case": ["c1", "d1"], "seed": [1, 2]}, {"c1": {"granules": 50}}
    make_sweep(folder, sweep=sweep, shapes=few, record={"snapshots": 13}, batch=1)
    return folder / "results"


def motion_of(watched, case):
    return read_snapshots(watched / "drag.nc", [f"case={case}", "seed=1"])


def test_a_run_is_found_by_its_values(tmp_path):
    """By axes, by labels and by paths, in the combined file and in the file of its runs."""
    boxes = {"wide": {"box_width": 10e-3, "shapes.c1.granules": 75}, "same": {"box_width": 8e-3}}
    sweep = {"shape": ["c1", "d1"], "friction.granule": [0.1, 0.3], "box": boxes, "seed": 1}
    make_sweep(tmp_path, sweep=sweep, record={"observables": ["drag"]}, batch=4)
    file, words = tmp_path / "results/drag.nc", ["shape=d1", "friction.granule=0.3", "box=wide"]
    run, values = open_run(file, words)
    assert (run.label, run.seed) == ("d1", 1)
    assert (run.configuration.friction.granule, run.configuration.box_width) == (0.3, 10e-3)
    point = {"shape": "d1", "friction_granule": 0.3, "box": "wide", "seed": 1}
    assert_array_equal(values["drag"], xr.load_dataset(file)["drag"].sel(point))
    by_label = ["shape=d1", "friction_granule=0.3", "box_width=0.01"]
    found = set()
    for path in (file, *file.parent.glob("store/batches/*.nc")):
        with suppress(InputError):
            found.add(open_run(path, by_label)[0].id)
    assert found == {run.id}
    with pytest.raises(InputError, match="add snapshots to record"):
        read_snapshots(file, words)


@pytest.mark.parametrize("case", ["c1", "d1"])
def test_a_motion_is_what_was_recorded(watched, case):
    """Snapshots and drag. The file of all beds holds the first seed, and gaps where a case has fewer
    granules than another."""
    motion = motion_of(watched, case)
    beds = xr.load_dataset(watched / "snapshots.nc")
    assert beds["seed"].values.tolist() == [1] and beds.sizes["granule"] == 60
    one = beds.sel(case=case, seed=1).dropna("granule", subset=["granule_diameter"])
    assert one.sizes["granule"] == (50 if case == "c1" else 60)
    assert_array_equal(motion.position, np.stack([one["granule_x"], one["granule_y"]], axis=-1))
    assert_array_equal(motion.angle, one["granule_angle"])
    assert_array_equal(motion.diameters, one["granule_diameter"])
    drag = xr.load_dataset(watched / "drag.nc")["drag"]
    assert_array_equal(motion.force[0], drag.sel(case=case, seed=1))
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
    place = boxes_shown(bed.collections[0]).mean(axis=1)
    assert_allclose(place, 1e3 * motion.position[7], atol=1e-2)
    speed = np.hypot(*(motion.position[7] - motion.position[6]).T) / TOOK
    assert_allclose(bed.collections[0].get_array(), speed, rtol=1e-9)
    curve, mark = record.lines
    moved = xr.load_dataset(watched / "drag.nc")["displacement"]
    assert_allclose(curve.get_xydata(), np.transpose([1e3 * moved, motion.force[0]]))
    assert_allclose(mark.get_xdata(), 0.7)


@quick
@pytest.mark.parametrize("case", ["c1", "d1"])
def test_export_for_paraview(watched, tmp_path, case):
    """Polygons with the area of their granule, two a dumbbell; a file a snapshot, and one that lists them."""
    motion, parts = motion_of(watched, case), 1 + (case == "d1")
    export(motion, tmp_path / "bed.pvd")
    snapshots, granules = motion.angle.shape
    listed = re.findall(r'timestep="(.*?)" file="(.*?)"', (tmp_path / "bed.pvd").read_text())
    assert_allclose([float(time) for time, _ in listed], motion.displacement, rtol=1e-6)
    files = [name for _, name in listed]
    assert sorted(files) == sorted(path.name for path in tmp_path.glob("*.vtu"))
    assert len(files) == snapshots
    for k in (0, 5, snapshots - 1):
        mesh = meshio.read(tmp_path / files[k])
        contacts, place = motion.contacts(k), motion.position[k]
        polygons, (ring,), lines = (mesh.points[cells.data][..., :2] for cells in mesh.cells)
        (body, solid, contact), velocity, force = map(
            mesh.cell_data.get, ("granule", "velocity", "force")
        )
        assert body.tolist() == np.repeat(range(granules), parts).tolist() and solid == [-1]
        z = polygons @ [1.0, 1.0j]
        area = 0.5 * (z.conj() * np.roll(z, -1, axis=1)).imag.reshape(granules, -1).sum(axis=1)
        assert_allclose(area, np.pi / 4 * motion.diameters**2, rtol=0.01)
        middle = polygons.reshape(granules, -1, 2).mean(axis=1)
        assert_allclose(middle, place, atol=0.02 * motion.diameters.max())
        diameter = motion.replicate.configuration.cylinder.diameter
        assert_allclose(np.ptp(ring, axis=0), diameter, rtol=1e-9)
        above = motion.solids(0)[0].position[1] + motion.displacement[k]
        assert_allclose(ring.mean(axis=0), [4e-3, above], atol=1e-6)
        # what granules went since the snapshot before, or will until the next, and the cylinder
        step = np.diff(motion.position, axis=0)[max(k, 1) - 1]
        assert_allclose(velocity[0][::parts, :2] * TOOK, step, rtol=1e-6, atol=1e-12)
        assert_allclose(velocity[1], [[0.0, 2.0, 0.0]])
        assert (contact == -2).all()
        assert_allclose(force[2], contacts.force)
        # each force acts on both bodies, and on walls, which have no polygon, alone
        acts = np.where(contacts.partner < -1, 1.0, 2.0)
        bodies = force[0][::parts].sum() + force[1].sum()
        assert bodies == pytest.approx(acts @ contacts.force)
        between = contacts.partner >= 0
        ends = np.stack([contacts.granule, contacts.partner], axis=1)[between]
        assert_allclose(lines[between], place[ends], atol=1e-9)


@quick
def test_a_solid_at_rest_at_an_angle_is_drawn_at_this_angle(watched):
    changes = {"cylinder.outline": "plate", "cylinder.aspect_ratio": 4.0, "cylinder.angle": 0.5}
    run, values = open_run(watched / "drag.nc", ["case=c1", "seed=1"])
    run = run.configuration.changed(changes, "c1").replicate("c1", 3.9e3, 1)
    with rc_context(RC):
        figure, _ = figure_of(of_motion(snapshots_of(run, values)), "speed", False)
    (outline,) = figure.axes[0].collections[2].get_paths()
    _, _, axis = np.linalg.svd(outline.vertices - outline.vertices.mean(axis=0))
    assert abs(axis[0] @ [-np.sin(0.5), np.cos(0.5)]) < 2e-2  # its longest
