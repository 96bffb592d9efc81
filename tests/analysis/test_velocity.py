"""Drag against velocity: the law finds what made the drag, and its intervals hold it."""

import json

import numpy as np
import pytest
from pictures import text_of
from project import ROOT, needs_study
from sweeps import dataset_of

from dem.analysis.velocity import AXIS, LEAST, inertial_number, rates
from dem.base.errors import InputError
from dem.figures.catalogue import FIGURES, draw, possible
from dem.figures.velocity import plot
from dem.report.info import summary
from dem.sweep.config import parse

VELOCITY = np.array([0.03, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0])


def swept(drag, velocity=VELOCITY, density=4000.0):
    """A file of runs with some drag (friction, velocity, seed) in N, the same along the stroke."""
    drag = np.asarray(drag, float)
    runs = dataset_of(drag, {"friction": [str(i) for i in range(len(drag))], AXIS: velocity})
    runs = runs.assign(packing_pressure=(runs["run_id"].dims, np.full(drag.shape, 1e7)))
    configuration = json.dumps({"cylinder": {"diameter": 3e-3}})
    runs = runs.assign_attrs({AXIS: 2.0, "configuration": configuration})
    return runs.assign_coords(diameter=1e-3, density=density).expand_dims("shape")


def made_up(limit, growth, exponent, beds=6, scatter=0.1, noise=0.03, seed=1):
    """Drag (velocity, seed): each bed has a level of its own, and each run some noise."""
    rng = np.random.default_rng(seed)
    level = 1.0 + scatter * rng.standard_normal(beds)
    wobble = 1.0 + noise * rng.standard_normal((len(VELOCITY), beds))
    return (limit + growth * VELOCITY[:, None] ** exponent) * level * wobble


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_law_finds_what_made_the_drag(exponent):
    """A yield force of 1000 N and a part that grows as a power of velocity, 40 N at 1 m/s."""
    result = rates(swept([made_up(1000.0, 40.0, exponent, scatter=0.0, noise=0.0)]))
    law = result.laws[()]
    assert law.limit[0] == pytest.approx(1000.0, rel=1e-9)
    assert law.exponent[0] == pytest.approx(exponent)
    assert law.rise[0] == pytest.approx(0.04) and law.drag(1.0)[0] == pytest.approx(1040.0)


def test_a_drag_without_rate_is_its_own_limit():
    """Where only noise differs between velocities, no rise is found at any."""
    result = rates(swept([made_up(1000.0, 0.0, 1.0)]))
    for velocity in VELOCITY[:-2]:
        law = result.laws[()]
        above = result.interval(law.rise * velocity**law.exponent)
        assert above.low < 0.0 < above.high and abs(above.value) < 0.05


def test_intervals_hold_the_truth_as_often_as_they_say():
    """Of the limits of many sweeps of five beds about 95 % of the intervals hold the true one."""
    hits = []
    for seed in range(120):
        result = rates(swept([made_up(1000.0, 40.0, 1.0, beds=5, seed=seed)]))
        limit = result.interval(result.laws[()].limit)
        hits.append(limit.low < 1000.0 < limit.high)
    assert 0.88 <= np.mean(hits) <= 0.99


def test_beds_are_their_own_control():
    """What beds have in common with and without friction cancels in the ratio of both."""
    bed = made_up(1000.0, 40.0, 1.0, scatter=0.3, noise=0.001)
    result = rates(swept([0.5 * bed, bed]))
    smooth, rough = (law.limit for law in result.laws.values())
    alone, ratio = result.interval(rough), result.interval(smooth / rough)
    assert alone.high - alone.low > 0.2 * alone.value
    assert ratio.low == pytest.approx(0.5) and ratio.high == pytest.approx(0.5)


def test_a_bed_with_a_run_that_failed_does_not_count():
    """Else the beds at one velocity would be others than at the next."""
    drag = np.array([made_up(1000.0, 40.0, 1.0)] * 2)
    whole = rates(swept(drag[..., 1:]))
    drag[1, 3, 0] = np.nan
    result = rates(swept(drag))
    assert result.beds == whole.beds == 5
    for point, means in result.means.items():
        np.testing.assert_allclose(means[0], whole.means[point][0])


@pytest.mark.parametrize(
    ("drag", "words"),
    [
        (np.ones((1, 3, 5)), "it has 3 velocities"),
        (np.ones((1, 7, 2)), "2 beds that were drawn at all of them; a fit takes 4 and 3"),
    ],
)
def test_too_little_for_a_law_is_refused(drag, words):
    with pytest.raises(InputError, match=words):
        rates(swept(drag, VELOCITY[: drag.shape[1]]))
    with pytest.raises(InputError, match=r"do not differ in cylinder\.velocity"):
        rates(swept(drag, VELOCITY[: drag.shape[1]]).isel({AXIS: 0}))


@pytest.mark.parametrize(
    ("name", "values", "factors"),
    [
        ("density", [4e3, 1.6e4], (1.0, 2.0)),  # four times as dense come back half as fast
        (
            "cylinder_diameter",
            [3e-3, 6e-3],
            (1.0, 0.5),
        ),  # of twice the size, half the rate of shear
    ],
)
def test_the_inertial_number_is_a_ratio_of_two_times(name, values, factors):
    """Of the values that the runs have, not the file; where they differ, no axis is shared."""
    runs = swept([made_up(1000.0, 40.0, 1.0)] * 2).drop_vars(name, errors="ignore")
    reference = inertial_number(swept([made_up(1000.0, 40.0, 1.0)]))
    for value, factor in zip(values, factors, strict=True):
        number = inertial_number(runs.assign_coords({name: value}))
        assert number == pytest.approx(factor * reference)
    assert inertial_number(runs.assign_coords({name: ("friction", values)})) is None


def over_points(runs, **more):
    """The same runs as points of a design, which may differ in more values."""
    points = runs.rename({AXIS: "point"}).assign_coords(point=range(runs.sizes[AXIS]))
    return points.assign_coords({AXIS: ("point", runs[AXIS].values), **more})


def test_points_that_differ_in_velocity_alone_are_its_axis(tmp_path):
    """A design over velocity is a sweep of it; of points that differ in more, no law is drawn."""
    runs = swept([made_up(1000.0, 40.0, 1.0)])
    runs = runs.assign_coords(shape=["c1"]).assign(displacement_bounds=("bound", [0.0, 3e-3]))
    points = over_points(runs)
    assert rates(points).laws[()].limit[0] == rates(runs).laws[()].limit[0]
    points.to_netcdf(tmp_path / "drag.nc")
    assert len(draw("velocity", tmp_path / "drag.nc", tmp_path)) == 2
    over_points(runs, gravity=("point", VELOCITY)).to_netcdf(tmp_path / "more.nc")
    with pytest.raises(
        InputError, match="cylinder_velocity varies over point together with gravity;"
    ):
        draw("velocity", tmp_path / "more.nc", tmp_path)


@needs_study("velocity")
@pytest.mark.parametrize(
    ("more", "drawn"), [({}, True), ({"gravity": {"low": 0, "high": 9}}, False)]
)
def test_the_workflow_draws_velocity_of_points_too(more, drawn):
    over = {"cylinder.velocity": {"low": 0.1, "high": 10.0, "scale": "log"}, **more}
    point = {"design": "sobol", "points": 8, "over": over}
    values = {"extends": "studies/velocity/sweep.yaml", "results": "results/points"}
    sweep = parse(
        values | {"sweep": {"shape": "c1", "point": point, "seed": "1 to 3"}}, str(ROOT / "x")
    )
    assert ("velocity" in possible(sweep.block("drag"))) == drawn


@needs_study("velocity")
def test_info_tells_the_velocities_of_the_runs():
    """Not that of the file, where velocity varies."""
    shown = text_of(summary(ROOT / "studies/velocity/velocity.nc"))
    assert "cylinder at 0.125 to 32 m/s" in shown


@pytest.mark.parametrize(("velocity", "marked"), [(2.0, True), (3.0, False)])
def test_the_velocity_of_the_file_is_marked_where_runs_have_it(velocity, marked):
    runs = swept([made_up(1000.0, 40.0, 1.0)])
    cylinder = {"diameter": 3e-3, "velocity": velocity}
    figure = plot(runs.assign_attrs(configuration=json.dumps({"cylinder": cylinder})))
    assert (f"grey line: {velocity:g} m/s" in figure.get_suptitle()) == marked


def test_the_figure_shows_each_friction_and_the_inertial_number():
    assert FIGURES["velocity"].axes == LEAST
    figure = plot(swept([made_up(500.0, 40.0, 1.0), made_up(1000.0, 40.0, 1.0)]))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert [label.partition(":")[0] for label in labels] == ["friction 0", "friction 1"]
    assert figure.axes[0].child_axes[0].get_xlabel() == "Inertial number"
