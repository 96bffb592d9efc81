"""Figures, films and files of a user's own result."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from numpy.testing import assert_allclose
from PIL import Image
from project import ROOT
from workflows import run

import dem
from dem.figures import bed, film
from dem.figures.frames import of_result

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


@cache
def result_of(name):
    return dem.simulate(dem.Scene(dem.Disc(RADIUS), SOFT, **SCENES[name]), STATE, 1e-4, frames=3)


@pytest.mark.parametrize(("frame", "time"), [(2, "66.6667 µs"), (-1, "100 µs")])
def test_a_disc_is_drawn_at_its_place_with_its_radius(frame, time):
    """In mm, and the cylinder where its velocity has brought it by then; all frames and the corner of the wedge
    are in view."""
    result = result_of("both")
    axes = dem.plot.bed(result, frame=frame, color="layer").axes[0]
    for i, outline in enumerate(axes.collections[0].get_paths()):
        offset = outline.vertices - 1e3 * result.position[frame, i]
        assert_allclose(np.hypot(*offset.T), 1e3 * RADIUS[i], rtol=1e-9)
    (ring,) = axes.collections[2].get_paths()
    center = [3.0, 6.0] + 1e3 * result.time[frame] * np.array([1.0, 2.0])
    assert_allclose(np.hypot(*(ring.vertices - center).T), 0.5, rtol=1e-9)
    assert (axes.get_xlabel(), axes.get_title(loc="left")) == ("x (mm)", f"t = {time}")
    low, high = 1e-3 * np.transpose([axes.get_xlim(), axes.get_ylim()])
    for place, reach in (
        (result.position, RADIUS[:, None]),
        (result.solid_position, 5e-4),
        (np.zeros(2), 0.0),
    ):
        assert (place - reach > low).all() and (place + reach < high).all()


def test_a_granule_that_is_not_there_is_not_drawn(tmp_path):
    """Nor does it change the view, the scale or the layers of others."""
    run = dem.Simulation(dem.Scene(dem.Disc([*RADIUS, 1e-3]), SOFT, **SCENES["both"]), dem.State(
        [*STATE.position, [np.nan] * 2], [*STATE.velocity, [0.0, 0.0]]
    ))  # fmt: skip
    run.remove_granules([0])
    result = result_of("both")._replace(scene=run.scene, simulation=run).continuation(1e-6)
    for color in ("layer", "speed", "force"):
        figure = dem.plot.bed(result, color=color, forces=True)
        gone, left, never = figure.axes[0].collections[0].get_paths()
        assert np.isnan([gone.vertices, never.vertices]).all() and np.isfinite(left.vertices).all()
        figure.savefig(tmp_path / "bed.png")
    low, high = figure.axes[0].get_ylim()
    assert np.isfinite(low) and high < 7.0


@pytest.mark.parametrize(
    "planes", [dem.box(4e-3, 3e-3), [[0.0, -1.0, 1e-3]], [[0.6, 0.8, 2e-3], [-0.6, -0.8, 1e-3]]]
)
def test_what_is_hatched_is_what_no_granule_can_enter(planes):
    """A point of the view is outside the space that is drawn where n.x > offset of some wall."""
    planes, view = np.array(planes), np.array([[-5e-3, -2e-3], [6e-3, 7e-3]])
    corners = bed.free_space(planes, view)
    points = np.random.default_rng(1).uniform(*view, (2000, 2))
    solid = (points @ planes[:, :2].T > planes[:, 2]).any(axis=1)
    assert 0 < solid.sum() < 2000
    assert (Outline(corners).contains_points(points) == ~solid).all()


@pytest.mark.parametrize(
    ("name", "end", "options"),
    [
        ("empty space", "gif", {"color": "force", "forces": True}),
        ("walls", "mp4", {"color": "layer"}),
        ("both", "gif", {"panel": None}),
    ],
)
def test_a_film_has_a_frame_per_frame_of_the_result(tmp_path, name, end, options):
    """Of any scene, with or without walls and solids, at 720p; granules move in it."""
    path, progress, result = tmp_path / f"discs.{end}", [], result_of(name)
    assert dem.film(result, str(path), progress=progress.append, **options) == path
    assert len(result.time) == len(progress) and progress[-1] == 1.0
    if end == "gif":
        with Image.open(path) as image:
            assert image.n_frames == len(progress) and sorted(image.size) == [720, 1280]
            first = np.array(image.convert("RGB"), int)
            image.seek(len(progress) - 1)
            change = np.array(image.convert("RGB"), int) - first
        assert (np.abs(change).max(axis=2) > 50).mean() > 0.01
    else:
        assert path.read_bytes()[4:8] == b"ftyp"
    assert list(tmp_path.iterdir()) == [path]


NAMES = {"F": ["horizontal", "vertical"], "T": ["anticlockwise"], "N": ["wall 0", "wall 1"]}


def test_forces_and_torques_are_drawn_against_time():
    """A step per interval: of each solid and of the walls; in the panel of a film of the solid that is asked for,
    or summed over all. Forces by their components, from left to right and upwards."""
    state = dem.State([[0.0, 3e-3], [1.4e-3, 6e-3]], angular_velocity=[3e3, -2e3])
    solids = [dem.Cylinder(1e-3, (1.45e-3, 3e-3)), dem.Cylinder(1e-3, (2.45e-3, 6e-3))]
    scene = dem.Scene(dem.Disc(RADIUS), SOFT, solids=solids, **SCENES["walls"])
    result = dem.simulate(scene, state, 1e-4, frames=3)
    force, torque = result.solid_force[1:], result.solid_torque[1:, :, None]
    rows = [
        ("Force on solid 0 (N)", force[:, 0]),
        ("Force on solid 1 (N)", force[:, 1]),
        ("Normal force on walls (N)", result.wall_force[1:]),
        ("Torque on solid 1 (N m)", torque[:, 1]),
        ("Force on 2 solids, summed (N)", force.sum(axis=1)),
    ]
    shown = dem.plot.forces(result).axes
    assert shown[2].get_xlabel() == "Time" and shown[2].xaxis.get_major_formatter()(2e-5) == "20 µs"
    for panel in (("torque", 1), ("force", None)):
        shown.append(Figure().subplots())
        of_result(result, *panel).record(shown[-1])
    for axes, (words, values) in zip(shown, rows, strict=True):
        assert_allclose([patch.get_data().values for patch in axes.patches], values.T)
        assert_allclose(axes.patches[0].get_data().edges, result.time)
        assert axes.get_ylabel() == words
        legend = [text.get_text() for text in axes.get_legend().get_texts()]
        assert legend == NAMES[words[0]]


@pytest.mark.parametrize("box", [(1e-2, 4e-2), (4e-2, 1e-2)])
def test_a_film_of_any_scene_shows_it_large_and_its_words_apart(box):
    """The bed takes the most of its film that its shape leaves, and no two words of an axis overlap."""
    scene = dem.Scene(dem.Disc([1e-4]), walls=dem.box(*box), solids=CYLINDER)
    frames = of_result(dem.simulate(scene, dem.State([[1e-3, 1e-3]]), 2e-3, frames=2))
    with rc_context(film.RC):
        figure, _ = film.figure_of(frames, "speed", False)
    largest = max((a.get_window_extent() for a in figure.axes), key=lambda a: a.width * a.height)
    assert (np.array(largest.size) > figure.bbox.size * [0.7, 0.55]).any()
    for axes in figure.axes:
        words = [label.get_window_extent() for label in axes.get_xticklabels()]
        assert all(a.x1 < b.x0 for a, b in pairwise(words) if b.width)


def test_without_an_encoder_a_film_is_refused(tmp_path, monkeypatch):
    """And what can be done is said; nothing is written."""

    def none():
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(film, "get_ffmpeg_exe", none)
    with pytest.raises(dem.InputError, match="no encoder of films on this computer; install ff"):
        dem.film(result_of("walls"), tmp_path / "discs.mp4")
    assert not list(tmp_path.iterdir())


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
    written = []
    for rc in "", MATPLOTLIBRC:
        (tmp_path / "matplotlibrc").write_text(rc)
        folder = tmp_path / f"figures{len(rc)}"
        folder.mkdir()
        run("-c", DRAWS, ROOT, folder, cwd=tmp_path)
        written.append({path.name: path.read_bytes() for path in folder.iterdir()})
    plain, other = written
    assert len(plain) == 8 and [name for name in plain if plain[name] != other.get(name)] == []
    assert b"/Type3" not in plain["bed.pdf"] and b"/FontFile2" in plain["bed.pdf"]
