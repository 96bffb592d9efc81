"""Laws of contacts: what holds under each, and what a new one must answer."""

import re
from dataclasses import replace

import numpy as np
import pytest
from beds import area_of, replicate
from collisions import APART, ELASTIC, compliance, stated_force
from numpy.testing import assert_allclose
from refusals.laws import cone
from twin import Twin
from workflows import run

import dem
from dem.base.source_hash import ROOT
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene
from dem.laws import LAWS as NAMES

# With the kernels of runs that resist rolling, which no law of springs has.
LAWS = {
    "hertz": {"law": dem.Hertz(), "rolling": dem.Rolling(0.4, 0.3, 0.5)},
    "linear": {"law": dem.Linear()},
    "stiff": {"law": dem.Linear(stiffness=1e6)},
    "line": {"law": dem.Line(), "rolling": dem.Rolling(0.4, 0.3, 0.5)},
}
STEEL = dem.Material(7.8e3, 2e11, 0.25, ELASTIC.restitution)
SMALL, LARGE, THICK = 1e-3, 2.5e-3, 1e-3  # m
PAGE = (ROOT / "docs/howto/law.md").read_text()


def pressed(law, partner, two, overlap, one=ELASTIC, velocity=(0.0, 0.0), spin=0.0, **options):
    """A disc that overlaps what is at its right: another disc, a wall or a round solid of another material, rigid
    where that is None. Returns the simulation, and the radii (m) of both."""
    around, both, radii, place = dict(APART), [one], [SMALL], [[overlap - SMALL, 0.0]]
    other = np.inf if partner == "wall" else LARGE
    if partner == "granule":
        both, radii, place = [one, two], [SMALL, LARGE], [*place, [LARGE, 0.0]]
    elif partner == "wall":
        around["walls"] = [dem.Wall([1.0, 0.0, 0.0], material=two)]
        around["solids"] = dem.Cylinder(SMALL, (-1.0, 0.0))
    else:
        around["solids"] = dem.Cylinder(2.0 * LARGE, (LARGE, 0.0), material=two)
    scene = dem.Scene(
        dem.Disc(radii), both, dem.Friction(9.0, 9.0, 9.0, stiffness=0.5),
        species=range(len(both)), thickness=THICK, **around, **LAWS[law],
    )  # fmt: skip
    rest = len(both) - 1
    state = dem.State(place, [velocity, *rest * [(0.0, 0.0)]], None, [spin, *rest * [0.0]])
    return dem.Simulation(scene, state, ledger=law == "line", **options), (SMALL, other)


PARTNERS = [
    ("granule", STEEL),
    ("wall", None),
    ("wall", STEEL),
    ("solid", None),
    ("solid", STEEL),
]


@pytest.mark.quick
@pytest.mark.parametrize(("partner", "two"), PARTNERS)
@pytest.mark.parametrize("law", LAWS)
def test_the_springs_of_a_contact_are_those_of_the_books(law, partner, two):
    """Between unlike materials and sizes. Normal: see `stated_force`. Tangential: 4 G*/E* times the normal stiffness,
    which is Mindlin's 8 G* sqrt(R* delta) under Hertz's law, times that of `Friction`. Rolling: 3 (mu_r R*)^2
    times the normal stiffness, and at most mu_r R* N. Both act on the partner as the disc drags it."""
    both = [ELASTIC, two]
    shear = 1.0 / sum(
        2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.young_modulus for m in both if m
    )
    ratio = 0.5 * 4.0 * shear * sum(map(compliance, both))
    for overlap in (1e-8, 1e-5):
        start, radii = pressed(law, partner, two, overlap, time_step=1e-9)
        (force,) = start.contacts().force
        elastic = start.scene.law
        stated, less = (
            stated_force(elastic, d, radii, both, THICK) for d in (overlap, (1.0 - 1e-5) * overlap)
        )
        assert_allclose(force, stated, rtol=1e-8)
        normal = (stated - less) / (1e-5 * overlap)
        slid, _ = pressed(law, partner, two, overlap, velocity=(0.0, 1e-2), time_step=1e-9)
        slid.advance(1e-9)
        assert_allclose(slid.contacts().tangential_force, ratio * normal * 1e-11, rtol=1e-3)
        if start.scene.rolling is None:
            continue
        arm = {"granule": 0.4, "wall": 0.3, "solid": 0.5}[partner] / np.sum(1.0 / np.array(radii))
        for spin, time in ((10.0, 1e-9), (1e5, 2e-7)):
            turned, _ = pressed(law, partner, two, overlap, spin=spin, time_step=1e-9)
            turned.advance(time)
            now = turned.contacts()
            moment = 3.0 * arm**2 * normal * spin * time if spin < 1e3 else arm * now.force[0]
            assert_allclose(now.rolling_moment, moment, rtol=1e-3)


def rebound(law, restitution, partner, two, speed, **options):
    """Speed of parting over that of approach, which is along the line of centres."""
    one = replace(ELASTIC, restitution=restitution)
    two = two and replace(two, restitution=0.8)
    run, _ = pressed(law, partner, two, -1e-6 * speed, one, (speed, 0.0), **options)
    while run.time < 6e-5 or len(run.contacts().granule):
        run.advance(6e-5)
    after = run.state.velocity[:, 0]
    return (after[-1] * (partner == "granule") - after[0]) / speed


@pytest.mark.quick
@pytest.mark.parametrize(("partner", "two"), PARTNERS)
@pytest.mark.parametrize(
    ("law", "restitution", "options", "close"),
    [(law, e, {}, 1e-2) for law in LAWS for e in (0.9, 0.1)]
    + [(law, 0.5, {"step_fraction": 0.02}, 3e-3) for law in LAWS]
    + [("hertz", 1e-3, {}, 4e-2)],
)
def test_restitution_is_as_asked(law, restitution, options, close, partner, two):
    """At any speed. Between two materials it is the geometric mean; a body without a material has no say."""
    asked = np.sqrt(0.8 * restitution) if two else restitution
    for speed in (0.1, 3.0):
        found = rebound(law, restitution, partner, two, speed, **options)
        assert found == pytest.approx(asked, rel=close)


@pytest.mark.quick
def test_elastic_collisions_at_the_default_step_err_by_a_tenth_of_a_per_cent():
    """The energy, in the root mean square over many collisions, and in the worst of them, as docs/scope.md says."""
    speeds = np.geomspace(0.1, 3.0, 30)
    gain = np.array([rebound("hertz", ELASTIC.restitution, "wall", None, v) for v in speeds])
    gain = gain**2 - 1.0
    assert np.sqrt((gain**2).mean()) < 0.002
    assert np.abs(gain).max() < 0.005


@pytest.mark.quick
def test_discs_in_plane_strain_go_on_smoothly_where_half_spaces_end():
    """Beyond an overlap of a/e^2, 0.54 of the radius at a rigid wall: there the force grows on without a jump, and its
    energy is its integral."""
    overlap = 0.5413 * SMALL * np.array([0.98, 0.985, 0.99, 0.994, 0.996, 1.0, 1.005, 1.01])
    runs = [pressed("line", "wall", None, d)[0] for d in overlap]
    force = np.array([run.contacts().force[0] for run in runs])
    energy = np.array([run.ledger().elastic_normal for run in runs])
    assert_allclose(np.diff(energy), 0.5 * (force[1:] + force[:-1]) * np.diff(overlap), rtol=1e-3)
    slope = np.diff(force) / np.diff(overlap)
    assert (np.diff(slope) > 0.0).all() and slope[-1] < 3.0 * slope[0]
    halves = [
        stated_force(dem.Line(), d, (SMALL, np.inf), (ELASTIC, None), THICK) for d in overlap[:4]
    ]
    assert_allclose(force[:4], halves, rtol=1e-8)


@pytest.mark.quick
@pytest.mark.parametrize("law", LAWS)
def test_the_critical_step_before_a_collision_is_that_of_the_stiffest_to_come(law):
    """It bounds those of all contacts that come, whichever of the granules are large, small, light or heavy."""
    radius, density = np.array([4e-3, 4e-3, 2e-4, 2e-4]), [100.0, 2e4]
    loose = {"rolling": dem.Rolling(0.0, 0.0, 0.0)} if law in ("hertz", "line") else {}
    for densities in (density, density[::-1]):
        scene = dem.Scene(
            dem.Disc(radius), [replace(ELASTIC, density=rho) for rho in densities], dem.Friction(),
            species=[0, 0, 1, 1], thickness=THICK, **APART, **LAWS[law] | loose,
        )  # fmt: skip
        x = np.array([-4e-3 - 5e-7, 4e-3 + 5e-7, 0.0199 - 5e-8, 0.0203 + 5e-8])
        speed = np.array([0.5, -0.5, 0.5, -0.5])
        start = dem.State(np.column_stack([x, 0.0 * x]), np.column_stack([speed, 0.0 * x]))
        run = dem.Simulation(scene, start, ledger=law == "line")
        before, least = run.diagnose().critical_time_step, np.inf
        for _ in range(60):
            run.advance(5e-7)
            if len(run.contacts().granule):
                least = min(least, run.diagnose().critical_time_step)
        assert np.isfinite(least) and before <= 1.01 * least


@pytest.mark.parametrize("law", ["linear", "linear of a stiffness", "line"])
def test_a_bed_bears_the_pressure_asked_for_under_any_law(law):
    """Force on the top wall over its area, by the forces of the model in plain numpy."""
    stiffness = {"contact.stiffness": 5e7} if "stiffness" in law else {}
    run = replicate(**{"contact.law": law.partition(" ")[0]} | stiffness)
    scene, state = make_scene(run, bed := make_bed(run)), bed.state
    with_top, without = (
        Twin(replace(scene, walls=walls), state).force[:, 1].sum()
        for walls in (scene.walls, scene.walls[:-1])
    )
    assert (without - with_top) / area_of(run) == pytest.approx(60e6, rel=1e-3)


# Laws of one's own


@pytest.mark.quick
@pytest.mark.parametrize("law", [*(row["law"] for row in LAWS.values()), cone("Blunt")], ids=str)
def test_check_law_accepts_what_keeps_its_promises(law):
    dem.check_law(law)


def test_each_law_of_the_package_is_asked_here():
    assert {type(row["law"]).__name__ for row in LAWS.values()} == set(NAMES.values())


OF_THE_PAGE = """
from dem.sweep.config import load

assert abs(after[1] - after[0] - 0.5) < 0.01
for file, laws in ("cones.yaml", 5 * [Cone]), ("axis.yaml", [dem.Hertz, dem.Linear, Cone]):
    assert [type(run.law) for run in load(file).block("drag").unique()] == laws
"""


def test_a_law_of_ones_own_by_the_page(tmp_path):
    """docs/howto/law.md, followed to the letter, in at most 25 lines. In a process of its own: that of the test
    of all pages imports another file of the same class."""
    code, use = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    (sweep,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)
    assert len([line for line in code.splitlines() if line.strip()]) <= 25
    axis = sweep.replace("1 to 5", "1, contact.law: [hertz, linear, cones.Cone]")
    for name, text in {"cones.py": code, "cones.yaml": sweep, "axis.yaml": axis}.items():
        (tmp_path / name).write_text(text)
    run("-c", use + OF_THE_PAGE, cwd=tmp_path, path=[tmp_path])
