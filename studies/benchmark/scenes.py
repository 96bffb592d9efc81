"""What is timed: beds of the sweep, and scenes that lack one thing or another."""

from dataclasses import replace
from typing import NamedTuple

from dem.base.errors import InputError
from dem.dynamics.simulation import STEP_FRACTION, Simulation
from dem.experiment.bed import make_bed
from dem.experiment.bed_description import NOMINAL
from dem.experiment.replicate import Replicate
from dem.experiment.scene import make_scene
from dem.scene import Scene, State
from dem.sweep.config import Sweep
from studies.common.results import first_seed

ASPECT_RATIO = 1.25  # of the ellipses, or the nearest to it in the sweep
LOADED = {"ellipse": 0.90}  # least packing fraction: those of the paper are below jamming
FULL = "discs: friction, damping, walls, cylinder"


class Case(NamedTuple):
    """A scene, the state it starts from (at rest), and a time step (s)."""

    scene: Scene
    state: State
    time_step: float


def make_case(scene: Scene, state: State) -> Case:
    """With the time step that a run would begin with."""
    critical = Simulation(scene, state).diagnose().critical_time_step
    return Case(scene, state, STEP_FRACTION * critical)


def packed(sweep: Sweep, label: str, seed: int) -> Case:
    """A bed of one of the sweep's shapes, which carries load, with the cylinder in it."""
    least = LOADED.get(sweep.shapes[label].kind, 0.0)
    fraction = max(sweep.packing.fraction or NOMINAL, least)
    loaded = sweep.changed({"packing.fraction": fraction}, label)
    replicate = Replicate(loaded, label, sweep.density_of(label), seed)
    bed = make_bed(replicate.bed_description)
    return make_case(make_scene(replicate, bed), bed.state)


def beds(sweep: Sweep) -> dict[str, Case]:
    """One packed bed that carries load per kind of granule: the first of the sweep, ellipses by
    ASPECT_RATIO."""
    cases = {}
    order = sorted(sweep.shapes.items(), key=lambda item: abs(item[1].ratio - ASPECT_RATIO))
    for kind in ("disc", "dumbbell", "ellipse"):
        shapes = order if kind == "ellipse" else sweep.shapes.items()
        label = next((label for label, shape in shapes if shape.kind == kind), None)
        if label is None:
            raise InputError(f"the configuration has no {kind}; the benchmark needs one.")
        cases[kind] = packed(sweep, label, first_seed(sweep))
    return cases


def variants(cases: dict[str, Case]) -> dict[str, Case]:
    """By what each has: scenes on the beds of `beds`, full ones first."""
    disc, dumbbell, ellipse = (cases[kind] for kind in ("disc", "dumbbell", "ellipse"))
    elastic = replace(disc.scene.material, restitution=1.0)
    chord = ellipse.scene.shape._replace(contact="geometric_potential")
    return {
        FULL: disc,
        "dumbbells, full": dumbbell,
        "ellipses, full": ellipse,
        "ellipses by geometric potential, full": _changed(ellipse, shape=chord),
        "discs, no damping": _changed(disc, material=elastic),
        "discs, no friction, no rotation": _changed(disc, friction=None),
        "discs, Hertz's force alone": _changed(
            disc, friction=None, material=elastic, walls=None, solids=None
        ),
    }


def _changed(case, **changes):
    return case._replace(scene=replace(case.scene, **changes))
