"""Figures, films and files of a user's own result."""

import os
import subprocess
import sys
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from numpy.testing import assert_allclose
from PIL import Image
from project import ROOT

import dem
from dem.figures import bed, film
from dem.figures.frames import of_result

SNAPSHOTS = ROOT / "docs/data/snapshots.nc"

SOFT = dem.Material(young_modulus=1e6)  # so that a contact lasts for all frames
RADIUS = np.array([1e-3, 0.6e-3])
STATE = dem.State([[0.0, 3e-3], [1.4e-3, 3.75e-3]], velocity=[[0.5, 0.0], [-0.5, -0.2]])
SLOPE = np.sqrt(0.5)
WEDGE = [[-SLOPE, -SLOPE, 0.0], [SLOPE, -SLOPE, 0.0]]
CYLINDER = dem.Cylinder(1e-3, (3e-3, 6e-3), (1.0, 2.0))
SCENES = {
    "empty space": {},
    "walls": {"walls": WEDGE, "friction": dem.Friction(), "gravity": (0.0, 0.0)},
    "both": {"walls": WEDGE, "solids": CYLINDER},
}


@pytest.fixture(scope="module")
def results():
    return {
        name: dem.simulate(dem.Scene(dem.Disc(RADIUS), SOFT, **parts), STATE, 1e-4, frames=3)
        for name, parts in SCENES.items()
    }


@cache
def of_two_solids():
    """Two discs that turn and push a cylinder each."""
    rough = {"friction": dem.Friction(), "walls": WEDGE, "gravity": (0.0, 0.0)}
    state = dem.State([[0.0, 3e-3], [1.4e-3, 6e-3]], angular_velocity=[3e3, -2e3])
    solids = [dem.Cylinder(1e-3, (1.45e-3, 3e-3)), dem.Cylinder(1e-3, (2.45e-3, 6e-3))]
    return dem.simulate(
        dem.Scene(dem.Disc(RADIUS), SOFT, solids=solids, **rough), state, 1e-4, frames=3
    )


def verts(collection):
    return [path.vertices for path in collection.get_paths()]


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("color", ["force", "speed", "layer"])
def test_any_scene_is_drawn(results, tmp_path, name, color):
    """With or without walls and solids; the figure can be saved."""
    figure = dem.plot.bed(results[name], color=color, forces=True)
    figure.savefig(tmp_path / "bed.png")
    assert figure.axes[0].get_xlabel() == "x (mm)"
    assert figure.axes[0].get_title(loc="left") == "t = 100 µs"


@pytest.mark.parametrize("frame", [0, 2, -1])
def test_a_disc_is_drawn_at_its_place_with_its_radius(results, frame):
    """In mm, and the cylinder where its velocity has brought it by then."""
    result = results["both"]
    axes = dem.plot.bed(result, frame=frame, color="layer").axes[0]
    for i, outline in enumerate(verts(axes.collections[0])):
        offset = outline - 1e3 * result.position[frame, i]
        assert_allclose(np.linalg.norm(offset, axis=1), 1e3 * RADIUS[i], rtol=1e-9)
    (ring,) = verts(axes.collections[2])
    center = [3.0, 6.0] + 1e3 * result.time[frame] * np.array([1.0, 2.0])
    assert_allclose(center, 1e3 * result.solid_position[frame, 0])
    assert_allclose(np.linalg.norm(ring - center, axis=1), 0.5, rtol=1e-9)


@pytest.mark.parametrize(
    "planes",
    [
        WEDGE,
        dem.box(4e-3, 3e-3),
        [[0.0, -1.0, 1e-3]],
        [[0.6, 0.8, 2e-3], [-0.6, -0.8, 1e-3]],
    ],
)
def test_what_is_hatched_is_what_no_granule_can_enter(planes):
    """A point of the view is outside the space that is drawn where n.x > offset of some wall."""
    planes, view = np.array(planes), np.array([[-5e-3, -2e-3], [6e-3, 7e-3]])
    corners = bed.free_space(planes, view)
    points = np.random.default_rng(1).uniform(*view, (2000, 2))
    solid = (points @ planes[:, :2].T > planes[:, 2]).any(axis=1)
    assert 0 < solid.sum() < 2000
    assert (Outline(corners).contains_points(points) == ~solid).all()


def test_all_frames_are_in_view(results):
    """Granules and solids from first to last, and the corner of the wedge."""
    result = results["both"]
    low, high = bed.view_of(of_result(result))
    reach = RADIUS[:, None]
    assert (result.position - reach > low).all() and (result.position + reach < high).all()
    distance = abs(result.solid_position[:, 0] - 0.5 * (low + high))
    assert (distance + 5e-4 < 0.5 * (high - low)).all()
    assert (low < 0.0).all() and (high > 0.0).all()


def test_contacts_of_a_frame_are_of_its_own_time(results):
    """Two discs that collide overlap by what their places at that time say."""
    result = results["empty space"]
    gaps = np.linalg.norm(result.position[:, 1] - result.position[:, 0], axis=1) - RADIUS.sum()
    assert (gaps < 0.0).all() and len(set(gaps)) == len(gaps)
    for frame, gap in enumerate(gaps):
        assert_allclose(result.contacts(frame).overlap, [-gap], rtol=1e-9)


@pytest.mark.parametrize(("name", "panel"), [*((name, "force") for name in SCENES), ("both", None)])
def test_a_film_has_a_frame_per_frame_of_the_result(results, tmp_path, name, panel):
    path, progress = tmp_path / "discs.gif", []
    assert dem.film(results[name], str(path), progress=progress.append, panel=panel) == path
    with Image.open(path) as image:
        assert image.n_frames == len(results[name].time) == len(progress)
    assert progress[-1] == 1.0 and [path.name for path in tmp_path.iterdir()] == ["discs.gif"]


def test_a_film_is_an_mp4(results, tmp_path):
    written = dem.film(results["both"], tmp_path / "discs.mp4", color="force", forces=True)
    assert written == tmp_path / "discs.mp4" and written.read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize("panel", ["force", "torque"])
@pytest.mark.parametrize("solid", [None, 0, 1])
def test_the_panel_of_a_film_is_of_the_solid_that_is_asked_for(panel, solid):
    """Or the sum over all of them; the force by its components, from left to right and upwards."""
    result = of_two_solids()
    axes = Figure().subplots()
    of_result(result, panel, solid).record(axes)
    values = getattr(result, f"solid_{panel}")[1:]
    expected = values.sum(axis=1) if solid is None else values[:, solid]
    drawn = [patch.get_data().values for patch in axes.patches]
    assert_allclose(drawn, np.atleast_2d(expected.T))
    on = "2 solids, summed" if solid is None else f"solid {solid}"
    assert axes.get_ylabel().startswith(f"{panel.capitalize()} on {on} (N")
    names = ["horizontal", "vertical"] if panel == "force" else ["anticlockwise"]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == names


@pytest.mark.parametrize(("width", "height"), [(1.0, 1.0), (1.0, 4.0), (4.0, 1.0)])
def test_a_film_of_any_scene_shows_it_large_and_its_words_apart(width, height):
    """The bed takes the most of its film that its shape leaves, and no two words of an axis overlap."""
    scene = dem.Scene(dem.Disc([1e-4]), walls=dem.box(width * 1e-2, height * 1e-2), solids=CYLINDER)
    frames = of_result(dem.simulate(scene, dem.State([[1e-3, 1e-3]]), 2e-3, frames=2))
    with rc_context(film.RC):
        figure, _ = film.figure_of(frames, "speed", False)
    boxes = [axes.get_window_extent() for axes in figure.axes]
    bed, whole = max(boxes, key=lambda box: box.width * box.height), figure.bbox
    assert bed.height > 0.55 * whole.height or bed.width > 0.7 * whole.width
    for axes in figure.axes:
        words = [label.get_window_extent() for label in axes.get_xticklabels()]
        assert all(a.x1 < b.x0 for a, b in pairwise(words) if b.width)


def test_without_an_encoder_a_film_is_refused(results, tmp_path, monkeypatch):
    """And what can be done is said; nothing is written."""

    def none():
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(film, "get_ffmpeg_exe", none)
    with pytest.raises(dem.InputError, match="no encoder of films on this computer; install ff"):
        dem.film(results["walls"], tmp_path / "discs.mp4")
    assert not list(tmp_path.iterdir())


def test_forces_are_drawn_against_time(results):
    """A step per interval, in the order of the walls."""
    result = results["both"]
    solid, walls = dem.plot.forces(result).axes
    assert walls.get_xlabel() == "Time" and solid.get_ylabel().endswith("(N)")
    assert walls.xaxis.get_major_formatter()(2e-5) == "20 µs"
    steps = [patch.get_data() for patch in walls.patches]
    assert_allclose([step.values for step in steps], result.wall_force[1:].T)
    assert_allclose(steps[0].edges, result.time)
    drawn = [patch.get_data().values for patch in solid.patches]
    assert_allclose(drawn, result.solid_force[1:, 0].T)
    names = [text.get_text() for text in walls.get_legend().get_texts()]
    assert names == [f"wall {number}" for number in range(2)]


@pytest.mark.parametrize("name", SCENES)
def test_a_file_holds_the_dataset(results, tmp_path, name):
    """Written whole, and read back the same; it says where solids and walls are."""
    path = results[name].to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(path) as read:
        xr.testing.assert_identical(read.load(), results[name].to_dataset())
        assert read.sizes.get("solid", 0) == ("solids" in SCENES[name])
        assert read.sizes.get("wall", 0) == len(SCENES[name].get("walls", ()))
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["run.mp4", "run.gif", "run.nc"])
def test_a_folder_and_a_file_of_another_kind_are_kept(results, tmp_path, name):
    """A path that is a folder, or whose suffix is another one, is refused and stays."""
    result, folder, notes = results["walls"], tmp_path / name, tmp_path / "notes.md"
    folder.mkdir()
    notes.write_text("notes")
    for path, words in (
        (folder, "must be a file"),
        (notes, "must be the path of a file that ends"),
    ):
        with pytest.raises(dem.InputError, match=words):
            result.to_netcdf(path) if name.endswith(".nc") else dem.film(result, path)
    assert not list(folder.iterdir()) and notes.read_text() == "notes"


MATPLOTLIBRC = """
text.usetex: True
lines.linewidth: 5
lines.marker: x
figure.facecolor: black
savefig.facecolor: black
axes.facecolor: black
savefig.format: pdf
savefig.bbox: tight
axes.formatter.use_mathtext: True
animation.bitrate: 10
path.sketch: 1, 100, 2
"""
DRAWS = """
import sys, xarray, dem
from pathlib import Path
from dem.figures.catalogue import draw
from dem.figures.film import picture
from dem.figures.snapshots import motion_of
from dem.figures.style import save

root, folder = map(Path, sys.argv[1:])
draw("figure07", root / "docs/data/drag.nc", folder)
with xarray.open_dataset(root / "docs/data/snapshots.nc") as dataset:
    motion = motion_of(dataset, "c1")
for end in ("pdf", "svg", "png"):
    picture(motion, folder / f"bed.{end}", None, "layer", False)
scene = dem.Scene(dem.Disc([1e-3]), walls=[[0, -1, 0]], friction=dem.Friction(), gravity=(0, -9.81))
result = dem.simulate(scene, dem.State([[0, 1.01e-3]]), duration=1e-4, frames=2)
dem.film(result, folder / "film.gif")
save(dem.plot.forces(result), folder / "forces")
"""


def test_no_matplotlibrc_and_no_date_changes_a_byte(tmp_path):
    """Of figures, pictures and films. A PDF has its letters as TrueType, which journals ask for."""
    folders = [tmp_path / name for name in ("plain", "other")]
    (tmp_path / "matplotlibrc").write_text(MATPLOTLIBRC)
    for folder in folders:
        folder.mkdir()
        rc = {"MATPLOTLIBRC": str(tmp_path / "matplotlibrc")} if folder == folders[1] else {}
        words = [sys.executable, "-c", DRAWS, SNAPSHOTS.parent.parent.parent, folder]
        subprocess.run(words, env=os.environ | rc, check=True)
    plain, other = ({p.name: p.read_bytes() for p in folder.iterdir()} for folder in folders)
    assert len(plain) == 8 and [name for name in plain if plain[name] != other.get(name)] == []
    assert b"/Type3" not in plain["bed.pdf"] and b"/FontFile2" in plain["bed.pdf"]
