"""Laws of contacts: what holds under each, and what a new one must answer."""

import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from beds import area_of, replicate
from collisions import ROUGH, approach, followed, head_on, leaving
from scipy.special import lambertw
from twin import Twin
from workflows import run

import dem
from dem.base.source_hash import ROOT
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene
from dem.laws import LAWS as NAMES
from dem.laws import protocol

# That of lines with what the energy of a bed that resists rolling needs too, so that one kernel serves.
LAWS = {
    "hertz": {"law": dem.Hertz()},
    "linear": {"law": dem.Linear()},
    "line": {"law": dem.Line(), "rolling": dem.Rolling()},
}
THIN = {"thickness": 1e-3, **ROUGH}
PAGE = (ROOT / "docs/howto/law.md").read_text()


@pytest.mark.parametrize("restitution", [1.0 - 1e-12, 0.9, 0.5, 0.3, 0.2, 0.1])
@pytest.mark.parametrize("law", LAWS)
def test_restitution_is_as_asked_for_at_the_default_step(law, restitution):
    """In the mean over collisions that begin anywhere within many steps, to 0.3 %."""
    size, gap, material = np.full((200, 2), 1e-3), np.linspace(1e-7, 1e-5, 200), dem.Material()
    material = replace(material, restitution=restitution)
    scene, state = head_on(size, np.ones(200), gap, material=material, **LAWS[law], **THIN)
    result = dem.simulate(scene, state, 4e-5, ledger=law == "line").state
    assert -approach(result.velocity).mean() == pytest.approx(restitution, rel=3e-3)


@pytest.mark.parametrize("law", ["linear", "line"])
def test_restitution_is_as_asked_for_at_any_speed(law):
    """Whatever the speed and the sizes. Hertz's law is in test_collision.py."""
    size, speed = np.array([[1.0, 1.0], [1.0, 1.0], [0.5, 2.0]]) * 1e-3, np.array([0.05, 5.0, 1.0])
    material = dem.Material(restitution=0.5)
    scene, state = head_on(size, speed, material=material, **LAWS[law], **THIN)
    result = dem.simulate(scene, state, 2e-5, step_fraction=0.005, ledger=law == "line").state
    np.testing.assert_allclose(-approach(result.velocity) / speed, 0.5, rtol=3e-3)


def test_a_linear_collision_lasts_half_a_period():
    """pi sqrt(m*/k), for the stiffness that is given."""
    law, elastic = dem.Linear(stiffness=1e7), dem.Material(restitution=1.0 - 1e-12)
    scene, state = head_on([[1e-3, 1e-3]], [1.0], material=elastic, law=law, **THIN)
    duration = np.pi * np.sqrt(0.5 * scene.mass[0] / 1e7)
    time, overlap, _ = followed(scene, state, 1.2 * duration, 600)
    assert leaving(time, overlap[:, 0]) == pytest.approx(duration, rel=1e-3)


def test_the_ledger_balances_under_a_law_of_lines():
    """An oblique impact with friction, rolling resistance and a dashpot, to 3e-4 of its energy."""
    scene, state = head_on([[1e-3, 1e-3]], [1.0], **LAWS["line"], **THIN)
    state.velocity[:, 1] = 0.2, -0.2
    run = dem.Simulation(scene, state, ledger=True, step_fraction=0.05)
    run.advance(4e-6)
    assert min(run.ledger().damped, run.ledger().slid) > 0.0
    assert run.ledger().residual < 3e-4


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


def test_discs_in_plane_strain_follow_johnson():
    """Overlap, energy and stiffness for a force, as Contact Mechanics, 5.6 has them for both bodies; and the
    force for an overlap. Beyond the range of the half-space all goes on smoothly."""
    law, k, a = dem.Line(), 2.3e7, 8e-3
    overlap = a * np.exp(-2.0) * np.append(np.geomspace(1e-9, 0.99, 200), [0.996, 1.5])
    measure = np.array([protocol.measure(law, d, a) for d in overlap])
    pairs = [*zip(overlap, measure, strict=True)]
    force = np.array([protocol.force(law, k, *pair) for pair in pairs])
    energy = np.array([protocol.energy(law, k, *pair) for pair in pairs])
    p = force[:200] / k
    np.testing.assert_allclose(p * (np.log(a / p) - 1.0), overlap[:200], rtol=1e-12)
    np.testing.assert_allclose(p, -overlap[:200] / lambertw(-np.e * overlap[:200] / a, -1).real)
    np.testing.assert_allclose(energy[:200], 0.5 * k * p**2 * (np.log(a / p) - 1.5), rtol=1e-12)
    np.testing.assert_allclose(measure[:200], 1.0 / (np.log(a / p) - 2.0), rtol=1e-6)
    for d, m, f in zip(overlap, measure, force, strict=True):
        ends = [(1.0 + s) * d for s in (1e-5, -1e-5)]
        ends = [(end, protocol.measure(law, end, a)) for end in ends]
        rise, work = (np.subtract(*[f(law, k, *end) for end in ends]) for f in FUNCTIONS)
        assert rise == pytest.approx(2e-5 * d * protocol.slope(law, k, m), rel=1e-6)
        assert work == pytest.approx(2e-5 * d * f, rel=1e-6)


FUNCTIONS = protocol.force, protocol.energy


# Laws of one's own

CONE = {
    "measure": lambda law, overlap, length: overlap,
    "force": lambda law, stiffness, overlap, measured: stiffness * overlap**2,
    "energy": lambda law, stiffness, overlap, measured: stiffness * overlap**3 / 3.0,
    "stiffness": lambda law, modulus, radius: modulus / radius,
    "slope": lambda law, stiffness, measured: 2.0 * stiffness * measured,
}
BROKEN = {
    "sign": (
        {"force": lambda law, k, d, m: -k * d**2},
        "force does not grow with the overlap beyond 1e-09 m",
    ),
    "touch": ({"measure": lambda law, d, length: d + 1e-9}, "measure is 1e-09 at an overlap"),
    "depth": ({"force": lambda law, k, d, m: k * d**2 * (1 - 2.5e3 * d)}, "force does not grow"),
    "jump": (
        {"force": lambda law, k, d, m: k * (d**2 + (0.0 if d < 1e-4 else 1e-9))},
        "slope is not dF/d.* beyond 9.*e-05 m, or force or slope jumps there",
    ),
    "slope": ({"slope": lambda law, k, m: k * m}, "slope is not dF/d"),
    "energy": ({"energy": lambda law, k, d, m: 0.4 * k * d**3}, "force is not dU/d"),
    "damping": ({"root": lambda law, d, m: m**0.5}, "dashpot times root is not 2 dy/d"),
    "mean": (
        {"mean_root": lambda law, d, h, length: (1.5 * max(d, 0.0)) ** 0.5},
        "mean_root is not the mean",
    ),
    "scale": (
        {"stiffness": lambda law, modulus, radius: modulus},
        "forces grow by 4 where .* by scale it is 2",
    ),
    "bounds": ({"stiffest": lambda law, modulus, radius, d: 0.0}, "stiffest is below slope"),
}


def cone(name, changes):
    """A law whose force grows with the square of the overlap, with some answers changed."""
    law = type(name, (NamedTuple(name, []),), {"modulus": lambda law, young, thick: young * thick})
    functions = CONE | changes
    for question, function in functions.items():
        function.__name__ = question
    protocol.answer(law, *functions.values())
    return law()


@pytest.mark.parametrize("name", [*NAMES, "stiff"])
def test_check_law_accepts_those_of_the_package(name):
    dem.check_law(dem.Linear(stiffness=1e6) if name == "stiff" else LAWS[name]["law"])


@pytest.mark.parametrize("name", BROKEN)
def test_check_law_names_the_promise_that_a_law_breaks(name):
    changes, words = BROKEN[name]
    with pytest.raises(dem.InputError, match=f"Broken{name}: {words}"):
        dem.check_law(cone(f"Broken{name}", changes))


@pytest.mark.parametrize("check", [dem.check_law, lambda law: dem.Scene(dem.Disc([1.0]), law=law)])
def test_what_is_no_law_is_refused(check):
    with pytest.raises(
        dem.InputError, match=r"law.* must be a law of contacts, such as dem.Hertz\(\)"
    ):
        check("hertz")


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


def test_a_law_is_part_of_what_a_run_and_its_bed_are():
    """hertz is what runs are without it; a stiffness changes a run, and a bed under a pressure."""
    plain, hertz, linear, stiff = (
        replicate(**{f"contact.{key}": value for key, value in contact.items()})
        for contact in (
            {},
            {"law": "hertz"},
            {"law": "linear"},
            {"law": "linear", "stiffness": 1e7},
        )
    )
    assert (hertz.id, hertz.bed_id) == (plain.id, plain.bed_id)
    assert len({run.id for run in (plain, linear, stiff)}) == 3
    assert len({run.bed_id for run in (plain, linear, stiff)}) == 3
    with pytest.raises(dem.InputError, match="N/m and law hertz; leave it out"):
        replicate(**{"contact.stiffness": 1e7})
