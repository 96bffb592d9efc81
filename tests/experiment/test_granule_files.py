"""Beds from files: granules begin where the file says, and runs are known by that."""

import shutil

import numpy as np
import pytest
import xarray as xr
from command_line import called
from project import CONFIG
from sweeps import of_file

import dem
from dem.analysis.one_run import replicate_at
from dem.experiment.bed import make_bed, shaped
from dem.sweep.config import load

pytestmark = pytest.mark.quick

SWEEP = f"""
extends: {CONFIG}/sand.yaml
results: results
box_width: 8.0e-3
packing: {{height: 12.0e-3, region: [0.0, 4.0e-3, 8.0e-3, 12.0e-3]}}
shapes: {{disc: {{granules: 12}}}}
solids: {{floor: {{outline: plate, diameter: 7.9e-3, thickness: 5.0e-4, x: 4.0e-3, y: 2.0e-3}}}}
phases: {{fall: {{time: 4.0e-3}}}}
record: {{bins: 4, snapshots: 3}}
sweep: {{case: disc, seed: [1, 2]}}
"""
FROM_FILE = """
extends: first.yaml
results: results/second
packing: {preparation: file, region: null, file: NAME}
sweep: {case: disc, seed: [1]}
"""
DUMP = """ITEM: TIMESTEP
{step}
ITEM: NUMBER OF ATOMS
{count}
ITEM: BOX BOUNDS ff ff pp
-1.0000000000000000e-03 7.0000000000000001e-03
0.0000000000000000e+00 1.2000000000000000e-02
-5.0000000000000001e-04 5.0000000000000001e-04
ITEM: ATOMS id element c_KE xs y radius angle
"""


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A folder with a sweep of a bed that falls, and the last snapshot of its second run."""
    folder = tmp_path_factory.mktemp("first")
    (folder / "first.yaml").write_text(SWEEP)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        of_file(folder / "first.yaml")
    with xr.open_dataset(folder / "results/scene.nc") as file:
        last = file.isel(case=0, snapshot=-1).sel(seed=2).load()
    names = "granule_x", "granule_y", "granule_angle", "granule_diameter"
    return folder, np.column_stack([last[name] for name in names])


@pytest.fixture
def folder(first, tmp_path, monkeypatch):
    """A folder of one's own with that sweep, its results, and the snapshot as a CSV file."""
    shutil.copytree(first[0], tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "bed.csv", first[1])
    return tmp_path


def write_csv(path, rows, names="x,y,angle,diameter"):
    np.savetxt(path, rows, delimiter=",", header=names, comments="", fmt="%.17g")


def run_of(folder, name, more=""):
    """The run of a sweep that begins with a file, and has more lines."""
    (folder / "second.yaml").write_text(FROM_FILE.replace("NAME", name) + more)
    return load(folder / "second.yaml").replicate("disc", 2500.0, 1)


def test_a_scene_begins_with_the_granules_of_its_file(folder, first):
    run_of(folder, "bed.csv")
    result = called("sweep second.yaml -j 1")
    assert result.exit_code == 0, result.output
    with xr.open_dataset("results/second/scene.nc") as file:
        start = file.isel(case=0, seed=0, snapshot=0)
        names = "granule_x", "granule_y", "granule_angle", "granule_diameter"
        np.testing.assert_array_equal(np.column_stack([start[n] for n in names]), first[1])


def test_a_run_in_python_begins_with_a_file_of_the_working_folder(folder, first):
    packing = {"preparation": "file", "region": None, "file": "bed.csv"}
    run = dem.run_experiment({"extends": "first.yaml", "shape": "disc", "packing": packing})
    np.testing.assert_array_equal(run["granule_x"][0], first[1][:, 0])


def test_results_need_the_file_no_more(folder):
    """A sweep goes on from its resolved configuration, and a scene is drawn."""
    run = run_of(folder, "bed.csv")
    of_file(folder / "second.yaml")
    (folder / "bed.csv").unlink()
    resolved = load(folder / "results/second/config.yaml")
    assert resolved.replicate("disc", 2500.0, 1).id == run.id
    with xr.open_dataset("results/second/scene.nc") as file:
        assert replicate_at(file, file.isel(case=0, seed=0)).bed_id == run.bed_id
    with pytest.raises(dem.InputError, match=r"packing\.file is 'bed\.csv'; it cannot be read"):
        load(folder / "second.yaml")


def test_a_bed_is_the_same_in_three_formats(folder, first):
    """The last frame of a dump, whose granules are in any order and have texts, in a box that begins elsewhere."""
    x, y, angle, diameter = first[1].T
    with (folder / "bed.dump").open("w") as file:
        for step, order in enumerate([np.arange(12), np.random.default_rng(1).permutation(12)]):
            file.write(DUMP.format(step=step, count=12))
            rows = [np.arange(12), 1 + 0 * x, (x + 1e-3) / 8e-3 + 1 - step, y, diameter / 2, angle]
            np.savetxt(file, np.column_stack(rows)[order], fmt="%d Si%d 0.1" + 4 * " %.17g")
    csv, nc, dump = (
        run_of(folder, name) for name in ("bed.csv", "results/scene.nc seed=2", "bed.dump")
    )
    assert (csv.id, csv.bed_id) == (nc.id, nc.bed_id)
    beds = [make_bed(run.bed_description) for run in (csv, dump)]
    np.testing.assert_allclose(beds[1].position, beds[0].position, rtol=1e-12)
    np.testing.assert_array_equal(beds[1].angle, beds[0].angle)
    np.testing.assert_array_equal(dump.diameters, csv.diameters)


def test_a_run_is_known_by_what_is_in_its_file(folder, first):
    """Not by its name, its time, or how numbers are written; but by each number."""
    run = run_of(folder, "bed.csv")
    rows = [[f"{value:.25e}" for value in row] for row in first[1]]
    names = "# a bed\nx, y, angle, diameter"
    np.savetxt(folder / "other.csv", rows, "%s", ", ", header=names, comments="")
    same = run_of(folder, "other.csv")
    assert (same.id, same.bed_id) == (run.id, run.bed_id)
    for column in range(4):
        rows = first[1].copy()
        rows[5, column] *= 1.0 + 1e-9
        write_csv(folder / "bed.csv", rows)
        edited = run_of(folder, "bed.csv")
        assert edited.id != run.id and edited.bed_id != run.bed_id


def test_sizes_of_a_file_are_those_of_the_granules(folder, first):
    """Wherever they are read; without them, the seed draws sizes."""
    run = run_of(folder, "bed.csv")
    areas = shaped(run.bed_description, run.diameters).area
    np.testing.assert_allclose(areas, np.pi / 4.0 * first[1][:, 3] ** 2, rtol=1e-12)
    write_csv(folder / "bed.csv", first[1][:, :2], "x,y")
    drawn = run_of(folder, "bed.csv")
    other = drawn.configuration.replicate("disc", 2500.0, 2)
    assert (drawn.diameters != other.diameters).all()
    assert (make_bed(drawn.bed_description).angle == 0.0).all()


def test_granules_beyond_a_periodic_side_are_in_the_box(folder, first):
    """As results have them, whose places are not wrapped."""
    write_csv(folder / "bed.csv", first[1] + [8e-3, 0.0, 0.0, 0.0])
    sides = "periodic: x\nsolids: {floor: {diameter: 4.0e-3}}"
    bed = make_bed(run_of(folder, "bed.csv", sides).bed_description)
    np.testing.assert_allclose(bed.position, first[1][:, :2], rtol=0.0, atol=1e-15)
    with pytest.raises(dem.InputError, match=r"it must be from 0 to 0\.008 m, in the box"):
        run_of(folder, "bed.csv")


@pytest.mark.parametrize(
    ("place", "other"),
    [
        ((4e-3, 2e-3), "solids.floor"),
        ((7.3e-3, 2.9e-3), "granule"),
        ((4e-3, 11.9e-3), "the top wall"),
    ],
)
def test_granules_that_are_too_deep_in_others_end_the_run(folder, first, place, other):
    """Before its first step, with the limit of numerics.max_overlap, and names of the sweep file."""
    rows = first[1].copy()
    apart = np.meshgrid([1e-3, 3e-3, 5e-3, 7e-3], [3e-3, 5e-3, 7e-3])
    rows[:, :2] = np.transpose(apart).reshape(-1, 2)
    rows[0, :2] = place
    write_csv(folder / "bed.csv", rows)
    run = run_of(folder, "bed.csv", "numerics: {max_overlap: 0.3}")
    with pytest.raises(dem.OverlapError, match=f"overlaps {other}.* at step 0"):
        run.configuration.module.run(run)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x,z\n1,2", "its column 'z' is none of x, y, angle, diameter"),
        ("x,angle\n1,2", "its column y is missing"),
        ("x,y,x\n1,2,3", "its column 'x' is twice there"),
        ("x,y\n", "it has no granules"),
        ("x,y\n1,2\n3", "its granule 2 has 1 values; its columns are x, y"),
        ("x,y\n1,a", "y of its granule 1 is 'a'; it must be a number"),
        ("x,y\n1,nan", "y of its granule 1 is 'nan'; it must be a number"),
        ("x,y,diameter\n1,2,0", "is '0'; it must be a number of at least 1e-12"),
        ("ITEM: UNITS\nlj\n" + DUMP, "its units are lj; they must be si"),
        ("ITEM: NUMBER OF ATOMS\n1", "its last frame is no frame of a text dump"),
        (DUMP.format(step=0, count=2) + "1 1 0.5 0.1 0.1 0", "must have 2 lines of 7 values"),
    ],
)
def test_a_file_that_is_no_bed_is_refused_in_one_sentence(folder, text, words):
    (folder / "bed.csv").write_text(text)
    with pytest.raises(dem.InputError) as error:
        run_of(folder, "bed.csv")
    sentence = str(error.value)
    assert "packing.file is 'bed.csv'; " in sentence and words in sentence
    assert sentence.endswith(".") and "\n" not in sentence


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("results/scene.nc", "it has 2 runs; choose one, such as seed=1"),
        ("results/scene.nc seed=3", "there is no run with seed=3; seed is 1, 2"),
        ("bed.csv seed=1", "seed=1 chooses a run of a file of results; leave it out"),
    ],
)
def test_a_run_of_a_file_of_results_is_chosen_by_words(folder, name, words):
    with pytest.raises(dem.InputError, match=words):
        run_of(folder, name)


def test_seeds_that_change_nothing_are_refused(folder):
    run_of(folder, "bed.csv")
    text = (folder / "second.yaml").read_text()
    (folder / "second.yaml").write_text(text.replace("seed: [1]", "seed: 1 to 3"))
    with pytest.raises(dem.InputError, match=r"sweep\.seed has 3 seeds, and packing\.file"):
        load(folder / "second.yaml")
