"""Simple shear: the lid keeps its pressure, both stresses are the same at all heights, and the
friction of a bed comes out with an interval that holds it."""

import json
from functools import cache

import numpy as np
import pytest
import xarray as xr
from project import ROOT, needs_study
from sweeps import sheared_values

from dem.analysis.shear import AXIS, LEAST, rheology
from dem.base.errors import InputError, RunError
from dem.dynamics.simulation import Simulation
from dem.experiment.bed import make_bed
from dem.experiment.config import of_values
from dem.experiment.kinds import shear
from dem.figures.catalogue import FIGURES
from dem.figures.shear import plot
from dem.sweep.config import parse

PRESSURE = 1e5  # Pa


@cache
def sheared():
    """What a run of the small bed measures."""
    return shear.run(of_values(sheared_values()))


def test_the_lid_bears_the_pressure_that_is_asked_for():
    """In steady flow the lid does not rise, so the forces on it balance."""
    assert np.mean(sheared()["lid_normal_stress"]) == pytest.approx(PRESSURE, rel=0.01)


@pytest.mark.parametrize("stress", ["shear_stress", "normal_stress"])
def test_stress_in_the_middle_is_that_on_the_lid(stress):
    """Momentum that goes in at the lid goes through every height."""
    result = sheared()
    assert result[stress].mean() == pytest.approx(result[f"lid_{stress}"].mean(), rel=0.1)


def test_rough_walls_drag_the_bed_with_them():
    """The rate of shear in the middle is that of the walls, but for what slips next to them."""
    replicate = of_values(sheared_values())
    rate = shear.rate_of(replicate)
    assert 0.6 < sheared()["shear_rate"].mean() / rate < 1.2


def test_the_packing_fraction_of_a_slice_counts_the_discs_that_stick_out_of_it():
    """Slices of all heights hold together what the discs hold."""
    rng = np.random.default_rng(1)
    height, radius = rng.uniform(2.0, 8.0, 50), rng.uniform(0.5, 1.0, 50)
    edges = np.linspace(0.0, 10.0, 21)[:, None]
    slices = np.diff(shear._below(edges, height, radius).sum(axis=1))
    assert slices.sum() == pytest.approx(np.pi * np.sum(radius**2))
    one = shear._below(np.array([[3.0]]), np.array([3.0]), np.array([2.0]))
    assert one[0, 0] == pytest.approx(2.0 * np.pi)  # half of a disc


def test_the_inertial_number_is_a_ratio_of_two_times():
    """Sixteen times the pressure brings granules back four times as fast, at the same number."""
    slow, fast = (
        of_values(sheared_values(shear=sheared_values()["shear"] | {"pressure": p}))
        for p in (1e5, 16e5)
    )
    rates = [shear.rate_of(r) for r in (slow, fast)]
    assert rates[1] == pytest.approx(4.0 * rates[0])


def test_both_walls_go_all_the_way_along_the_bed():
    """No gap between held discs is wide enough for another disc."""
    replicate = of_values(sheared_values())
    scene, state = shear.make_cell(replicate, make_bed(replicate))
    for group in scene.held:
        x = np.sort(state.position[group.granules, 0] % 9e-3)
        gaps = np.diff(np.append(x, x[0] + 9e-3))
        assert gaps.max() < 2.0e-3


def test_a_granule_that_gets_out_is_told():
    replicate = of_values(sheared_values())
    scene, state = shear.make_cell(replicate, make_bed(replicate))
    free = int(np.flatnonzero(~scene.is_held)[0])
    state.position[free, 1] = state.position[:, 1].max() + 5e-3
    with pytest.raises(RunError, match=f"granule {free} got out through a gap"):
        shear._sample(Simulation(scene, state), 1e-7)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"periodic": "none"}, "periodic is none; the experiment shear needs x"),
        ({"gravity": 9.81}, "gravity is 9.81; the experiment shear needs 0"),
        ({"shear": None}, "shear is missing"),
        (
            {"shapes": {"disc": {"kind": "dumbbell", "diameter": 1e-3, "granules": 72}}},
            "shapes.disc.kind is dumbbell; the experiment shear needs disc",
        ),
        (
            {"cylinder": {"diameter": 2e-3, "velocity": 1.0, "start": 0.3, "stroke": 1e-3}},
            "cylinder is no section of the experiment shear; leave it out",
        ),
        ({"experiment": "drag"}, "cylinder is missing"),
    ],
)
def test_a_file_that_cannot_be_sheared_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        of_values(sheared_values(**change))


def test_values_of_another_experiment_cannot_vary():
    configuration = of_values(sheared_values()).configuration
    with pytest.raises(InputError, match="the experiment shear has no cylinder"):
        configuration.changed({"cylinder.velocity": 1.0}, "disc")


NUMBERS = np.array([0.01, 0.1])


def swept(friction, fraction=0.8, noise=0.02, seeds=3, strain=4, seed=0):
    """A file of runs whose beds have some friction (place, number)."""
    rng = np.random.default_rng(seed)
    friction = np.asarray(friction, float)
    samples = 10 * strain
    shape = (*friction.shape, seeds, samples)
    dims = "friction", AXIS, "seed", "shear_strain"

    def around(value):
        return dims, value * (1.0 + noise * rng.standard_normal(shape))

    unit = np.sqrt(2500.0 * 0.25 * np.pi * 1e-6 / PRESSURE)
    cell = {"pressure": PRESSURE, "strain": float(strain)}
    return xr.Dataset(
        {
            "lid_shear_stress": around(PRESSURE * friction[..., None, None]),
            "lid_normal_stress": around(PRESSURE),
            "shear_stress": around(PRESSURE * friction[..., None, None]),
            "normal_stress": around(PRESSURE),
            "shear_rate": around(0.9 * NUMBERS[:, None, None] / unit),
            "shear_fraction": around(fraction),
            "run_id": (dims[:-1], np.full(shape[:-1], "x")),
        },
        {
            "friction": [str(k) for k in range(len(friction))],
            AXIS: NUMBERS,
            "seed": np.arange(seeds),
            "diameter": 1e-3,
            "density": 2500.0,
            "shear_strain": 0.1 * np.arange(1, samples + 1),
        },
        {"configuration": json.dumps({"shear": cell})},
    )


def test_curves_tell_places_apart():
    curves = rheology(swept([[0.1, 0.2], [0.3, 0.5]], noise=1e-9))
    np.testing.assert_allclose(curves[("0",)].friction[:, 0], [0.1, 0.2])
    np.testing.assert_allclose(curves[("1",)].middle[:, 0], [0.3, 0.5])
    np.testing.assert_allclose(curves[("1",)].number, 0.9 * NUMBERS)


def test_intervals_hold_the_truth_as_often_as_they_say():
    """About 95 % do, also where runs differ by more than their samples: in one run, samples share what
    the bed began with."""
    hits, rng = [], np.random.default_rng(7)
    for seed in range(60):
        runs = swept([[0.3, 0.4]], seeds=4, seed=seed)
        of_a_bed = xr.DataArray(0.02 * rng.standard_normal((2, 4)), dims=(AXIS, "seed"))
        runs["shear_fraction"] = runs["shear_fraction"] + of_a_bed
        hits += [low < 0.8 < high for _, low, high in rheology(runs)[()].fraction]
    assert 0.9 <= np.mean(hits) <= 0.99


def test_a_single_run_has_a_mean_and_no_interval():
    runs = swept([[0.3, 0.4]], noise=1e-9)
    for one in (runs.isel(seed=[0]), runs.isel(seed=0)):
        mean, low, high = rheology(one)[()].friction.T
        np.testing.assert_allclose(mean, [0.3, 0.4])
        assert np.isnan([low, high]).all()


def test_a_run_that_failed_leaves_the_others():
    runs = swept([[0.3, 0.4]], seeds=4)
    failed = runs.where(runs["seed"] != 2)
    np.testing.assert_array_equal(
        rheology(failed)[()].friction, rheology(runs.isel(seed=[0, 1, 3]))[()].friction
    )


@pytest.mark.parametrize("name", ["shear_pressure", "density"])
def test_numbers_are_of_the_pressure_and_density_that_the_runs_have(name):
    """A place at four times the usual value asks for another rate, and not for one between both."""
    runs = swept([[0.1, 0.2], [0.3, 0.5]], noise=1e-9)
    usual = PRESSURE if name == "shear_pressure" else 2500.0
    faster = 2.0 if name == "shear_pressure" else 0.5
    curves = rheology(runs.assign_coords({name: ("friction", [usual, 4.0 * usual])}))
    np.testing.assert_allclose(curves[("0",)].rate[:, 0], 0.9)
    np.testing.assert_allclose(curves[("1",)].rate[:, 0], 0.9 / faster)
    share = 0.25 if name == "shear_pressure" else 1.0
    np.testing.assert_allclose(curves[("1",)].pressure[:, 0], share)


@needs_study("shear")
def test_runs_of_another_strain_are_no_runs_of_one_file():
    """Their samples would be at the strains of the first; a block has its own, under its own name."""
    file = {"extends": "studies/shear/sweep.yaml", "results": "results/strains"}
    with pytest.raises(InputError, match=r"varies shear\.strain, which runs of one block share"):
        parse(
            file | {"sweep": {"values": {"density": 2.5e3}, "shear.strain": [4, 8]}},
            str(ROOT / "x"),
        )
    sweep = {"values": {"density": 2.5e3, "shear.strain": 8.0}}
    labels = parse(file | {"sweep": sweep}, str(ROOT / "x")).block("drag").labels()
    assert labels["shear_strain_swept"][2] == 8.0


def test_points_that_differ_in_inertial_number_alone_are_its_axis():
    runs = swept([[0.1, 0.2]])
    points = runs.rename({AXIS: "point"}).assign_coords(point=[0, 1])
    points = points.assign_coords({AXIS: ("point", NUMBERS)})
    np.testing.assert_array_equal(rheology(points)[()].friction, rheology(runs)[()].friction)


def test_runs_of_one_inertial_number_are_refused():
    with pytest.raises(InputError, match=r"do not differ in shear\.inertial_number"):
        rheology(swept([[0.3, 0.4]]).isel({AXIS: 0}))


def test_the_figure_shows_each_friction():
    assert FIGURES["shear"].axes == LEAST
    figure = plot(swept([[0.1, 0.2], [0.3, 0.5]]))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert set(labels) == {"friction 0", "friction 1"}
