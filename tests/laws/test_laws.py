"""Laws of contacts: what holds under each, and what a new one must answer."""

import re
from collections import defaultdict
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from collisions import APART, ELASTIC, compliance, stated_force
from numpy.testing import assert_allclose
from refusals.laws import CONE, cone
from workflows import run

import dem
from dem.base.source_hash import ROOT
from dem.contacts.layout import layout_of
from dem.dynamics.kinds import kernels
from dem.dynamics.step import advance
from dem.laws import LAWS as NAMES
from dem.laws.protocol import answer

STICKY = dem.Cohesive(pull_off=2e-2, range=2e-6)
LAWS = {name: getattr(dem, law)() for name, law in NAMES.items() if law != "Cohesive"}
LAWS["stiff"] = dem.Linear(stiffness=1e6)
STEEL = dem.Material(7.8e3, 2e11, 0.25, ELASTIC.restitution)
SMALL, LARGE, THICK = 1e-3, 2.5e-3, 1e-3  # m
ROLLING = dem.Rolling(0.4, 0.3, 0.5)


def options_of(law, rolling=ROLLING):
    """So that kernels are those of scenes.py: runs under Hertz's law and of lines resist rolling."""
    return {"law": law, "rolling": None if isinstance(law, dem.Linear | dem.Cohesive) else rolling}


PAGE = (ROOT / "docs/howto/law.md").read_text()


def pressed(law, partner, two, overlap, one=ELASTIC, velocity=(0.0, 0.0), spin=0.0, **options):
    """A disc that overlaps what is at its right: another disc, a wall or a round solid of another material, rigid
    where that is None. Returns the simulation, and the radii (m) of both."""
    wall, body = dem.Wall([1.0, 0.0, 0.0], material=two), dem.Cylinder(SMALL, (-1.0, 0.0))
    if partner == "solid":
        body = dem.Cylinder(2.0 * LARGE, (LARGE, 0.0), material=two)
    changes = {"granule": {}, "wall": {"walls": [wall], "solids": body}, "solid": {"solids": body}}
    count = slice(2 if partner == "granule" else 1)
    scene = dem.Scene(
        dem.Disc([SMALL, LARGE][count]), [one, two][count], dem.Friction(9.0, 9.0, 9.0, stiffness=0.5),
        species=[0, 1][count], thickness=THICK, **APART | changes[partner] | options_of(law),
    )  # fmt: skip
    place, speed = [[overlap - SMALL, 0.0], [LARGE, 0.0]][count], [velocity, (0.0, 0.0)][count]
    state = dem.State(place, speed, None, [spin, 0.0][count])
    run = dem.Simulation(scene, state, ledger=isinstance(law, dem.Line), **options)
    return run, (SMALL, np.inf if partner == "wall" else LARGE)


EACH_LAW = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
PARTNERS = [("granule", STEEL), ("wall", None), ("wall", STEEL), ("solid", None), ("solid", STEEL)]
EACH_PARTNER = pytest.mark.parametrize(("partner", "two"), PARTNERS)


@pytest.mark.quick
@EACH_PARTNER
@EACH_LAW
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
        stated, less = (
            stated_force(law, d, radii, both, THICK) for d in (overlap, (1.0 - 1e-5) * overlap)
        )
        assert_allclose(force, stated, rtol=1e-8)
        normal = (stated - less) / (1e-5 * overlap)
        slid, _ = pressed(law, partner, two, overlap, velocity=(0.0, 1e-2), time_step=1e-9)
        slid.advance(1e-9)
        assert_allclose(slid.contacts().tangential_force, ratio * normal * 1e-11, rtol=1e-3)
        arm = getattr(ROLLING, partner) / np.sum(1.0 / np.array(radii))
        for spin, time in ((10.0, 1e-9), (1e5, 2e-7)) if start.scene.rolling else ():
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
@EACH_PARTNER
@pytest.mark.parametrize("restitution", [0.9, 0.5, 0.1, 1e-3])
@EACH_LAW
def test_restitution_is_as_asked(law, restitution, partner, two):
    """At any speed. Between two materials it is the geometric mean; a body without a material has no say."""
    asked = np.sqrt(0.8 * restitution) if two else restitution
    for speed in (0.1, 3.0):
        for close, options in ((1e-2, {}), (3e-3, {"step_fraction": 0.02})):
            found = rebound(law, restitution, partner, two, speed, **options)
            assert found == pytest.approx(asked, rel=close)


@pytest.mark.quick
def test_elastic_collisions_at_the_default_step_err_by_a_tenth_of_a_per_cent():
    """The energy, in the root mean square over many collisions, and in the worst of them, as docs/scope.md says."""
    speeds = np.geomspace(0.1, 3.0, 30)
    gain = np.array([rebound(dem.Hertz(), ELASTIC.restitution, "wall", None, v) for v in speeds])
    gain = gain**2 - 1.0
    assert np.sqrt((gain**2).mean()) < 0.002
    assert np.abs(gain).max() < 0.005


@pytest.mark.quick
def test_discs_in_plane_strain_go_on_smoothly_where_half_spaces_end():
    """Beyond an overlap of a/e^2, 0.54 of the radius at a rigid wall: there the force grows on without a jump, and its
    energy is its integral."""
    overlap = 0.5413 * SMALL * np.array([0.98, 0.985, 0.99, 0.994, 0.996, 1.0, 1.005, 1.01])
    runs = [pressed(dem.Line(), "wall", None, d)[0] for d in overlap]
    force = np.array([run.contacts().force[0] for run in runs])
    energy = np.array([run.ledger().elastic_normal for run in runs])
    assert_allclose(np.diff(energy), 0.5 * (force[1:] + force[:-1]) * np.diff(overlap), rtol=1e-3)
    slope = np.diff(force) / np.diff(overlap)
    assert (np.diff(slope) > 0.0).all() and slope[-1] < 3.0 * slope[0]


@pytest.mark.quick
@EACH_LAW
def test_the_critical_step_before_a_collision_is_that_of_the_stiffest_to_come(law):
    """It bounds those of all contacts that come, whichever of the granules are large, small, light or heavy."""
    radius, loose = np.array([4e-3, 4e-3, 2e-4, 2e-4]), dem.Rolling(0.0, 0.0, 0.0)
    around = APART | {"species": [0, 0, 1, 1], "thickness": THICK} | options_of(law, loose)
    x = np.array([-4e-3 - 5e-7, 4e-3 + 5e-7, 0.0199 - 5e-8, 0.0203 + 5e-8])
    speed = np.resize([0.5, -0.5], 4)
    start = dem.State(np.outer(x, [1.0, 0.0]), np.outer(speed, [1.0, 0.0]))
    for densities in ((100.0, 2e4), (2e4, 100.0)):
        materials = [replace(ELASTIC, density=density) for density in densities]
        scene = dem.Scene(dem.Disc(radius), materials, dem.Friction(), **around)
        run = dem.Simulation(scene, start, ledger=isinstance(law, dem.Line))
        before, least = run.diagnose().critical_time_step, np.inf
        for _ in range(60):
            run.advance(5e-7)
            if len(run.contacts().granule):
                least = min(least, run.diagnose().critical_time_step)
        assert np.isfinite(least) and before <= 1.01 * least


# Cohesion


@pytest.mark.quick
def test_a_disc_hangs_where_the_pull_off_force_exceeds_its_weight():
    for share, hangs in (0.98, True), (1.02, False):
        scene = dem.Scene(
            dem.Disc([SMALL]), dem.Material(restitution=0.5), dem.Friction(),
            walls=[[0.0, 1.0, 0.0]], law=STICKY,
        )  # fmt: skip
        scene = replace(scene, gravity=(0.0, -share * STICKY.pull_off / scene.mass[0]))
        run = dem.Simulation(scene, dem.State([[0.0, 1e-8 - SMALL]]))
        run.advance(2e-3)
        assert (run.state.position[0, 1] > -SMALL - STICKY.range) == hangs


@pytest.mark.quick
def test_discs_attract_across_gaps_wider_than_the_skin_of_the_lists():
    scene = dem.Scene(
        dem.Disc(2 * [SMALL]), ELASTIC, dem.Friction(), law=STICKY._replace(range=SMALL)
    )
    run = dem.Simulation(scene, dem.State([[0.0, 0.0], [2.5 * SMALL, 0.0]]))
    assert_allclose(run.contacts().force, [-0.5 * STICKY.pull_off])


@pytest.mark.quick
def test_discs_that_cling_part_at_the_speed_of_their_bond():
    """The bond has the energy F_0 (d / 2 + 3/5 delta_0), where the overlap delta_0 is that at rest."""
    scene = dem.Scene(dem.Disc(2 * [SMALL]), ELASTIC, dem.Friction(), law=STICKY)
    both = dem.Hertz(), 1e-6, 2 * [SMALL], 2 * [ELASTIC], 1.0
    rest = 1e-6 * (STICKY.pull_off / stated_force(*both)) ** (2.0 / 3.0)
    bond = STICKY.pull_off * (0.5 * STICKY.range + 0.6 * rest)
    away = np.array([[-1.0, 0.0], [1.0, 0.0]])
    for share, part in (0.99, False), (1.01, True):
        speed = share * np.sqrt(bond / scene.mass[0])  # of each
        run = dem.Simulation(scene, dem.State((SMALL - 0.5 * rest) * away, speed * away))
        run.advance(4e-3)
        assert (len(run.contacts().granule) == 0) == part


@pytest.mark.quick
def test_cohesion_adds_to_the_force_that_friction_bears():
    """Between a disc that slides along a wall, spins, and bears no load: mu times the pull-off force."""
    scene = dem.Scene(
        dem.Disc([SMALL]), dem.Material(restitution=0.5), dem.Friction(wall=0.3),
        walls=[[0.0, -1.0, 0.0]], law=STICKY,
    )  # fmt: skip
    run = dem.Simulation(scene, dem.State([[0.0, SMALL]], [[0.0, 0.0]], None, [1e3]))
    run.advance(1e-3)
    now = run.contacts()
    assert_allclose(now.force, [0.0], atol=1e-3 * STICKY.pull_off)
    assert_allclose(now.tangential_force, [0.3 * STICKY.pull_off], rtol=1e-3)
    impulse = run.state.velocity[0, 0] * scene.mass[0]
    assert_allclose(impulse, -0.3 * STICKY.pull_off * run.time, rtol=3e-2)


@pytest.mark.quick
def test_a_column_stands_by_cohesion_and_spreads_without():
    x, y = np.meshgrid(SMALL * np.arange(1, 8, 2), SMALL * np.arange(1, 16, 2))
    state = dem.State(np.column_stack([(x + 2e-5 * (y > 5 * SMALL)).ravel(), y.ravel()]))
    width = []
    for law in (STICKY, STICKY._replace(pull_off=1e-9)):
        scene = dem.Scene(
            dem.Disc(32 * [SMALL]), dem.Material(2500.0, 1e7, 0.3, 0.3), dem.Friction(),
            walls=[[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], thickness=1e-3, gravity=(0.0, -9.81), law=law,
        )  # fmt: skip
        width.append(np.ptp(dem.simulate(scene, state, 0.2).state.position[:, 0]))
    assert width[0] < 1.2 * 6 * SMALL and width[1] > 2.0 * 6 * SMALL


# Laws of one's own


@pytest.mark.quick
@pytest.mark.parametrize("law", [*LAWS.values(), STICKY, cone()], ids=str)
def test_check_law_accepts_what_keeps_its_promises(law):
    dem.check_law(law)


class Scaled(NamedTuple):
    """A law with a number of its own."""

    factor: float
    modulus = dem.Hertz.modulus


answer(Scaled, *CONE.values())


@pytest.mark.quick
def test_no_kernel_takes_a_number_for_the_integer_that_it_was_compiled_for():
    """It would cut off what is behind the point, without a word."""
    disc, flags = dem.Disc([SMALL]), defaultdict(bool)
    given = advance, flags, layout_of(flags, 1, 1), disc, disc
    one, two = (kernels(*given, Scaled(factor))[2:] for factor in (1, 1.5))
    assert not set(one) & set(two)


OF_THE_PAGE = """
from dem.sweep.config import load

assert abs(after[1] - after[0] - 0.5) < 0.01
for file, laws in ("cones.yaml", 5 * ["Cone"]), ("axis.yaml", ["Hertz", "Linear", "Cone"]):
    assert [type(run.law).__name__ for run in load(file).block("drag").unique()] == laws
"""


def test_a_law_of_ones_own_by_the_page(tmp_path):
    """docs/howto/law.md, followed to the letter. In a process of its own: that of the test
    of all pages imports another file of the same class."""
    code, use = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    (sweep,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)
    axis = sweep.replace("1 to 5", "1, contact.law: [hertz, linear, cones.Cone]")
    for name, text in {"cones.py": code, "cones.yaml": sweep, "axis.yaml": axis}.items():
        (tmp_path / name).write_text(text)
    run("-c", use + OF_THE_PAGE, cwd=tmp_path, path=[tmp_path])
