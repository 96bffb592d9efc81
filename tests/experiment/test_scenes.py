"""Scenes from sweep files: solids bear what lies on them, move as phases say, and no granule is lost."""

import json
import time
from functools import cache

import numpy as np
import pytest
import xarray as xr
from project import CONFIG
from sweeps import Killed

import dem
from dem.analysis.one_run import read_snapshots, replicate_at
from dem.base.yaml_file import text_of
from dem.experiment import run_checkpoint
from dem.experiment.bed import make_bed
from dem.experiment.observables.scene import inside, surface
from dem.experiment.scene import make_scene
from dem.figures.bed import view_of
from dem.figures.export import export
from dem.figures.frames import of_motion
from dem.figures.scene import plot
from dem.sweep.batch_job import write_one
from dem.sweep.config import described, load

pytestmark = pytest.mark.quick
FILES = sorted((CONFIG / "scenes").glob("*.yaml"))
SMALL = {"shapes.disc.granules": 12, "box_width": 8e-3, "packing.height": 12e-3, "packing.region": [0, 4e-3, 8e-3, 12e-3],
         "record.bins": 4, "record.snapshots": 3, "record.region": [0, 0, 8e-3, 12e-3], "friction.wall": 0.0, "phases": {}}  # fmt: skip
FLOOR = {
    "outline": "plate",
    "diameter": 7.9e-3,
    "thickness": 5e-4,
    "x": 4e-3,
    "y": 2e-3,
    "friction": 0.3,
}
HELD, TIME = {"fill": {"until": "rest"}, "hold": {"time": 4e-3}}, 4e-3


def run_of(seed=1, **changes):
    """A dozen discs above a plate across the box."""
    values = SMALL | {"solids": {"floor": FLOOR}, "phases": HELD} | changes
    return (
        load(CONFIG / "scenes/column.yaml").changed(values, "disc").replicate("disc", 2500.0, seed)
    )


def fed(**changes):
    """A dozen discs that fall past a plate out of the box, and come again above with two new ones."""
    sinks = {"below": {"region": [None, None, None, 2e-3], "to": "above"}}
    above = {"region": [1e-3, 9e-3, 7e-3, 11.5e-3], "count": 2, "velocity_y": -0.2, "rate": 500.0}
    given = {"sinks": sinks, "sources": {"above": above}, "exchange_interval": 1.1e-3}
    solids, phases = (
        {"floor": FLOOR | {"diameter": 2e-3}},
        {"fall": {"time": 2e-2}, "on": {"time": 3e-2}},
    )
    return run_of(solids=solids, phases=phases, **given | changes)


@cache
def held():
    run = run_of(**{"record.observables": ["scene", "stress"]})
    return run, run.configuration.module.run(run)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_scene_of_the_project_is_short_and_can_be_made(path):
    """Its granules begin apart from each other, and no solid is in another."""
    assert len(path.read_text().splitlines()) <= 25
    sweep = load(path)
    for run in sweep.block(next(iter(sweep.blocks))).unique():
        rows = run.configuration.changed(
            {"packing.preparation": "lattice", "packing.friction": 0.0, "rolling": None}, "disc"
        )
        same = rows.replicate("disc", run.density, run.seed)
        bed = make_bed(same.bed_description)
        contacts = dem.Simulation(make_scene(same, bed), bed.state).contacts()
        assert (
            not len(contacts.force)
            and len(make_scene(same, bed).solids) == run.configuration.solid_count
        )


def test_a_solid_bears_the_weight_that_lies_on_it():
    run, values = held()
    mass = np.pi / 4.0 * run.diameters**2 @ np.full(12, 2500.0 * run.thickness)
    np.testing.assert_allclose(values["solid_force_y"][0], -9.81 * mass, rtol=1e-2)
    assert abs(values["solid_force_x"]).max() < 0.02 * 9.81 * mass


def test_a_scene_records_other_observables_beside_its_own():
    """The stress of a bed at rest is that of the weight: over the area, mass times height above the floor."""
    run, values = held()
    height, mass = values["granule_y"][-1] - 2.25e-3, np.pi / 4.0 * run.diameters**2 * 2500.0
    weight = 9.81 * mass @ height / (8e-3 * 12e-3)  # a thickness is in both
    assert values["stress_yy"][-1] == pytest.approx(weight, rel=0.05)


def test_no_granule_is_lost():
    run, values = held()
    assert run.configuration.module.axes["cell"].shape == values["surface_height"].shape[1:]
    assert (values["region_granules"] == 12).all()
    top = values["granule_y"] + 0.5 * values["granule_diameter"]
    np.testing.assert_allclose(values["surface_height"].max(axis=1), top.max(axis=1), rtol=0.02)


def test_a_solid_moves_as_the_phases_say_and_goes_on_where_none_names_it():
    """About its pivot; velocity and spin are those of the last phase that gave them."""
    paddle = FLOOR | {"diameter": 2e-3, "x": 5e-3, "pivot_x": 4e-3, "angle": 0.3, "direction": 0.0}
    turn, back = {"spin": 50.0, "velocity": 0.1}, {"velocity": -0.1}
    phases = {"turn": turn, "on": {}, "back": back}
    phases = {name: {"time": TIME, "motion": {"paddle": motion}} for name, motion in phases.items()}
    run = run_of(solids={"paddle": paddle}, phases=phases)
    solid = run.bed_description.solids[0].solid(0.0)
    ring = solid.placed(solid.position, solid.angle)
    np.testing.assert_allclose(ring.min(axis=0) + ring.max(axis=0), [10e-3, 4e-3], rtol=1e-3)
    values = run.configuration.module.run(run)
    time = np.array([0.0, 0.5, 1.0]) * TIME
    np.testing.assert_allclose(
        values["solid_angle"][:, 0], 0.3 + 50.0 * (2.0 * TIME + time), rtol=1e-9
    )
    np.testing.assert_allclose(values["solid_x"][:, 0], 4e-3 + 0.1 * (2.0 * TIME - time), rtol=1e-9)
    np.testing.assert_allclose(values["solid_y"][:, 0], 2e-3, rtol=1e-12)


def test_the_order_of_phases_makes_another_run_and_that_of_solids_none():
    pair = {"a": FLOOR | {"diameter": 1e-3, "x": 2e-3}, "b": FLOOR | {"diameter": 1e-3, "x": 6e-3}}
    two = {"one": {"time": 1e-3}, "two": {"time": 1e-3}}
    first = run_of(solids=pair, phases=two)
    turned, swapped = (dict(reversed(table.items())) for table in (pair, two))
    assert run_of(solids=turned, phases=two).id == first.id
    assert run_of(solids=pair, phases=swapped).id != first.id


def test_the_bed_of_a_scene_depends_on_where_solids_are_and_not_on_their_motion():
    first = run_of()
    assert run_of(solids={"floor": FLOOR | {"spin": 3.0}}).bed_id == first.bed_id
    assert run_of(solids={"floor": FLOOR | {"y": 2.1e-3}}).bed_id != first.bed_id


def test_a_granule_beyond_a_periodic_side_is_in_the_box_on_the_other():
    """In its region, and under the surface of the cells that it reaches into, on both sides."""
    position, radius, sides = np.array([[8.9, 2.0], [4.0, 1.0]]), np.array([1.5, 0.5]), (8.0, None)
    assert inside(position, (0.0, 0.0, 2.0, 3.0), sides).tolist() == [True, False]
    heights = surface(position, radius, 8.0, 4, sides)
    np.testing.assert_allclose(
        heights, [3.5, 2.0 + np.sqrt(1.5**2 - 1.1**2), 1.5, 2.0 + np.sqrt(1.5**2 - 0.9**2)]
    )


def test_a_picture_is_of_the_values_of_its_point():
    """Also along an axis of named points, whose values are no dimensions."""
    run = run_of()
    values = dict(run.coordinates, solids_floor_x=4.02e-3, solids_floor_friction="null")
    one = xr.Dataset(coords={name: ((), value) for name, value in values.items()})
    file = xr.Dataset(attrs={"configuration": json.dumps(run.configuration.values())})
    drawn = replicate_at(file, one).configuration.solids["floor"]
    assert (drawn.x, drawn.friction) == (4.02e-3, None)


def test_a_picture_of_a_scene_has_its_solids_where_they_are_and_nothing_behind_walls(tmp_path):
    """Contacts are found though the gate went through the lid."""
    gate = FLOOR | {"outline": "circle", "diameter": 1e-3, "thickness": None, "x": 4e-3, "y": 11e-3}
    run = run_of(
        solids={"floor": FLOOR, "gate": gate | {"velocity": 2.0}},
        phases=HELD | {"hold": {"time": 1e-2}},
    )
    write_one(tmp_path / "run.nc", run, run.configuration.module.run(run))
    with pytest.raises(dem.InputError, match="it holds single runs; dem draw shows them"):
        plot(xr.load_dataset(tmp_path / "run.nc"))
    motion = read_snapshots(tmp_path / "run.nc")
    frames = of_motion(motion)
    assert len(motion.contacts(-1).force) and motion.solids(-1)[1].position[1] > 20e-3
    assert motion.place[0, 0].tolist() == [4e-3, 2e-3] and frames.marks[-1] == 1e-2
    (left, bottom), (right, top) = view_of(frames)
    assert left < 0.0 < 8e-3 < right < 9e-3 and bottom < 0.0 < 12e-3 < top < 13e-3


def test_regions_and_rows_vary_and_files_have_them_again(folder):
    """Along an axis, and in a group beside a single number, also where all else than the points is impossible."""
    regions = (0.0, 4e-3, 8e-3, 8e-3), (0.0, 5e-3, 8e-3, 9e-3)
    pushes = ((0.0, 0.1), (1.0, 0.2)), 0.3
    peg = {"outline": "circle", "diameter": 1e-3, "x": 4e-3, "y": 2e-3}
    changes = {"solids": {"peg": peg}, "phases": {"on": {"time": 1e-3}}, "periodic": "x"}
    values = run_of(**changes).configuration.values()
    values["solids"]["peg"]["y"] = -5e-3  # below the floor
    group = {
        f"push {k}": {"solids.peg.force_y": force, "solids.peg.y": 2e-3 + 1e-4 * k}
        for k, force in enumerate(pushes)
    }
    axes = {"shape": "disc", "density": 2500.0, "packing.region": list(regions), "push": group}
    text = text_of(values | {"results": "results/rows", "sweep": axes})
    (folder / "rows.yaml").write_text(text)
    runs = dem.run_sweep("rows.yaml").squeeze("shape").isel(density=0, seed=0)
    for k, region in enumerate(regions):
        for j, force in enumerate(pushes):
            c = replicate_at(runs, runs.isel(packing_region=k, push=j)).configuration
            assert (c.packing.region, c.solids["peg"].force_y) == (region, force)


@pytest.mark.parametrize("removed", [["gate"], ["floor", "gate"]])
def test_a_figure_of_a_scene_has_no_curve_of_a_solid_that_is_gone(folder, removed):
    """And no panel for it where all are; nor has a film."""
    gate = FLOOR | {"diameter": 1e-3, "y": 4e-3}
    last = {"time": 1e-3, "motion": {name: {"removed": True} for name in removed}}
    changes = {"solids": {"floor": FLOOR, "gate": gate}, "phases": {"on": last}}
    values = run_of(**changes).configuration.values() | {"results": "results/gone"}
    text = text_of(values | {"sweep": {"shape": "disc", "density": 2500.0, "seed": 1}})
    (folder / "gone.yaml").write_text(text)
    data = dem.run_sweep("gone.yaml")
    beds, *curves = plot(data).subfigs
    left = ["floor"] * (removed == ["gate"])
    for axes in (axes for part in curves for axes in part.axes):
        assert [line.get_label() for line in axes.lines] == left
    assert len(beds.axes) == 3 and len(curves) == len(left)
    record = of_motion(read_snapshots("results/gone/scene.nc")).record
    assert (record is not None) == bool(left)


TURNED = {"cylinder.outline": "plate", "cylinder.aspect_ratio": 4.3, "cylinder.angle": 0.3, "cylinder.spin": 9.0,
          "record.observables": ["drag", "snapshots", "stress"]}  # fmt: skip
PAIR = {
    "cylinder.diameter": 1e-3,
    "second": {"diameter": 1e-3, "gap": 3e-4, "bearing": 0.7, "spin": "free"},
}
SETTLED = {
    "gravity": 9.81,
    "packing.preparation": "settled",
    "packing.fraction": 0.6,
    "cylinder.direction": 0.1,
}
SHORT = {
    "cylinder.stroke": 4e-5,
    "record.window": [0.0, 4e-5],
    "record.bins": 4,
    "record.snapshots": 3,
}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        TURNED,
        PAIR,
        SETTLED,
        {"packing.pressure": 3e5, "packing.fraction": None, "periodic": "x"},
    ],
)
def test_a_run_that_is_described_as_a_scene_gives_the_same_bits(tmp_path, changes):
    sweep, path = load(CONFIG / "smoke.yaml"), tmp_path / "same.yaml"
    run = sweep.changed(SHORT | changes, "c1").replicate("c1", 3900.0, 1)
    path.write_text(text_of(described(run)))
    (same,) = load(path).block("drag").unique()
    assert same.configuration.experiment == "scene" and same.bed_id == run.bed_id
    one, other = (each.configuration.module.run(each) for each in (run, same))
    force = np.stack([other["solid_force_x"][0], other["solid_force_y"][0]], axis=1)
    np.testing.assert_array_equal(one["drag"], -(force @ run.configuration.cylinder.ahead))
    for name in one.keys() & {"granule_x", "granule_angle", "stress_yy", "steps", "top_y"}:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


@pytest.mark.parametrize("study", ["onset/sweep", "shear/sweep", "claims/smoke"])
def test_a_run_of_another_experiment_is_described_by_its_own_values(tmp_path, study):
    sweep, path = load(CONFIG.parent / f"studies/{study}.yaml"), tmp_path / "same.yaml"
    for name in sweep.blocks:
        run = next(iter(sweep.block(name).unique()))
        path.write_text(text_of(described(run)))
        (same,) = load(path).block("drag").unique()
        drawn = run.configuration.experiment == "drag"  # jamming may have a cylinder too
        assert same.bed_id == run.bed_id and (drawn or same.id == run.id)
        assert (same.configuration.experiment == "scene") == drawn


def test_a_scene_goes_on_from_a_checkpoint_of_any_phase_with_the_same_bits(tmp_path, monkeypatch):
    """Solids move as they did, and a phase that was cut short ends when it should."""
    paddle = FLOOR | {"diameter": 2e-3, "x": 5e-3, "y": 1e-3}
    turn, back = {"spin": 50.0, "velocity": 0.1, "direction": 0.1}, {"velocity": -0.1}
    phases = {"turn": {"time": TIME, "motion": {"paddle": turn}}, "fill": {"until": "rest"}}
    phases["back"] = {"time": TIME, "motion": {"paddle": back}}
    replicate = run_of(solids={"floor": FLOOR, "paddle": paddle}, phases=phases)
    # in the first, the second and the last phase
    assert_goes_on(replicate, tmp_path, monkeypatch, lambda count: [3, 21, count - 1])


def test_a_scene_goes_on_with_the_granules_that_were_there_and_those_that_waited(
    tmp_path, monkeypatch
):
    """Stopped between moments at which they go and come, in a phase that is recorded and in one that is not."""
    values = assert_goes_on(fed(), tmp_path, monkeypatch, lambda count: [3, 11, count - 1])
    assert values["sink_granules"].any() and np.isnan(values["granule_x"]).any()


def assert_goes_on(replicate, tmp_path, monkeypatch, stops_of):
    """A run that is stopped where it writes a checkpoint of some numbers, of so many, is the same; returns it."""
    path, clock = tmp_path / "run.npz", time.monotonic
    monkeypatch.setattr("time.monotonic", lambda: 1e6 * clock())  # it saves itself once a minute
    run, write, writes = replicate.configuration.module.run, run_checkpoint.write_arrays, []

    def counted(path, arrays):
        write(path, arrays)
        writes.append(path)
        if len(writes) in stops:
            raise Killed

    monkeypatch.setattr(run_checkpoint, "write_arrays", counted)
    stops = ()
    whole = run(replicate, checkpoint=path)
    stops = stops_of(len(writes))
    path.unlink(), writes.clear()
    for _ in stops:
        with pytest.raises(Killed):
            run(replicate, checkpoint=path)
    resumed = run(replicate, checkpoint=path)
    for name in whole.keys() - {"run_time"}:
        np.testing.assert_array_equal(whole[name], resumed[name], err_msg=name)
    return whole


PADDLE = FLOOR | {"outline": "circle", "diameter": 1e-3, "thickness": None, "y": 1e-3}


def test_a_force_and_a_torque_move_a_solid_as_a_body_of_its_mass():
    """From the velocity that it has."""
    mass, force, torque = 1e-5, 1e-4, 1e-11
    push = {"force_x": force, "torque": torque}
    phases = {"wait": {"time": TIME}, "push": {"time": TIME, "motion": {"paddle": push}}}
    paddle = PADDLE | {"mass": mass, "velocity": 0.05, "direction": 0.0}
    run = run_of(solids={"paddle": paddle}, phases=phases, periodic="x")
    values, time = run.configuration.module.run(run), np.array([0.0, 0.5, 1.0]) * TIME
    x = 4e-3 + 0.05 * (TIME + time) + 0.5 * force / mass * time**2
    np.testing.assert_allclose(values["solid_x"][:, 0], x, rtol=1e-6)
    turn = 0.5 * torque / (0.5 * mass * 0.5e-3**2) * time**2
    np.testing.assert_allclose(values["solid_angle"][:, 0], turn, rtol=1e-3)


def test_a_spring_pulls_a_solid_and_its_weight_lets_it_fall():
    """Its end goes on a path, and a force along y rises up to the weight."""
    mass, spring, v = 1e-5, 1.0, 0.05
    path = [[0.0, v, 0.0, 0.0], [1.0, v, 0.0, 0.0]]
    lift = [[0.0, 0.0], [2.0 * TIME, 2.0 * 9.81 * mass]]
    pull = {"path": path, "spring_x": spring, "force_y": lift}
    phases = {"wait": {"time": TIME}, "pull": {"time": TIME, "motion": {"paddle": pull}}}
    paddle = PADDLE | {"mass": mass, "weight": True}
    run = run_of(solids={"paddle": paddle}, phases=phases, periodic="x")
    values, time = run.configuration.module.run(run), np.array([0.0, 0.5, 1.0]) * TIME
    w = np.sqrt(spring / mass)
    way = v * time - v / w * np.sin(w * time)
    np.testing.assert_allclose(values["solid_x"][:, 0] - 4e-3, way, rtol=1e-4, atol=1e-12)
    fall = 9.81 * (0.5 * time**2 - time**3 / (6.0 * TIME))
    np.testing.assert_allclose(1e-3 - values["solid_y"][:, 0], fall, rtol=1e-4, atol=1e-12)


def test_a_body_of_parts_hangs_at_the_centre_of_their_areas():
    """Two balls whose areas are as one to four, apart, turned with the body about its pivot."""
    balls = {
        "small": {"outline": "circle", "diameter": 5e-4, "x": 1e-3},
        "large": {"outline": "circle", "diameter": 1e-3, "x": -1e-3},
    }
    body = {"x": 4e-3, "y": 2.5e-3, "pivot_y": 3e-3, "angle": 0.5 * np.pi, "parts": balls}
    run = run_of(solids={"body": body | {"mass": 1e-5, "weight": True, "spin": "free"}})
    (solid,) = make_scene(run, make_bed(run.bed_description)).solids
    np.testing.assert_allclose(solid.spin.weight, [0.0, -9.81e-5])
    np.testing.assert_allclose(solid.spin.centre, [-0.5e-3 - 0.6e-3, 0.0], atol=1e-7)
    area = 1.25 * np.pi * 0.25e-6
    assert solid.area == pytest.approx(area, rel=1e-3)


def test_a_solid_goes_on_a_path_and_what_lay_on_one_that_is_removed_falls(tmp_path):
    path = [[0.0, 0.1, 0.0, 7.0], [TIME, 0.3, 0.0, 7.0]]
    motion = {"paddle": {"path": path}, "floor": {"removed": True}}
    phases = {"fill": {"until": "rest"}, "go": {"time": TIME, "motion": motion}}
    run = run_of(solids={"floor": FLOOR, "paddle": PADDLE}, phases=phases)
    values = run.configuration.module.run(run)
    moved = np.array([0.0, 0.15, 0.4]) * 0.5 * TIME
    np.testing.assert_allclose(values["solid_x"][:, 1], 4e-3 + moved, rtol=1e-6)
    np.testing.assert_allclose(values["solid_angle"][-1, 1], 7.0 * TIME, rtol=1e-6)
    fall = values["granule_y"].mean(axis=1)
    assert fall[0] - fall[2] == pytest.approx(0.5 * 9.81 * TIME**2, rel=0.02)
    assert np.isnan(values["solid_x"][:, 0]).all() and not values["solid_force_y"][0, 1:].any()
    write_one(tmp_path / "run.nc", run, values)
    motion = read_snapshots(tmp_path / "run.nc")
    (left,) = motion.solids(-1)
    assert left.position[0] == values["solid_x"][-1, 1]
    export(motion, tmp_path / "run.pvd")
