"""Which runs the study makes: a list a part, of runs of the sweep with some values changed."""

from typing import TYPE_CHECKING, NamedTuple

from dem.base.errors import InputError
from dem.experiment.config import Sweep

if TYPE_CHECKING:
    from dem.studies.claims.jamming import Jamming

NEED_JAMMING = ("matched", "ratios", "scaling")
DISTANCE, LOAD, ROUGH = "equal distance", "equal load", "equal distance, friction"
FRACTION = "equal fraction"
SIZES = ("diameter", "width", "height")
BOXES = ("width", "height")  # run at equal distance from jamming too


class Trial(NamedTuple):
    """A run: case and shape by label, density (kg/m3), seed, values changed by path; setting: what
    they are about; x: the value that varies along the part (NaN: none); point: of the design."""

    case: str
    shape: str
    density: float
    seed: int
    changes: dict
    setting: str = ""
    x: float = float("nan")
    point: int = -1


def seeds(sweep: Sweep, count: int) -> range:
    """The first `count` seeds of the study."""
    return range(sweep.claims.first_seed, sweep.claims.first_seed + count)


def reference(sweep: Sweep) -> tuple[str, float]:
    """Shape and density (kg/m3) of the first case."""
    first = next(iter(sweep.cases.values()))
    return first.shape, first.density


def replicates(sweep: Sweep, jamming) -> list[Trial]:
    """Many runs of every case, those of one bed together."""
    return [
        Trial(label, case.shape, case.density, seed, {})
        for seed in seeds(sweep, sweep.claims.replicates)
        for label, case in sorted(sweep.cases.items(), key=lambda item: item[1].shape)
    ]


def sensitivity(sweep: Sweep, jamming) -> list[Trial]:
    """One run of some cases at each point of the design, on a bed of its own."""
    from dem.studies.claims import design

    wanted = sweep.claims.sensitivity
    found = design.points(wanted, sweep.claims.first_seed)
    return [
        Trial(label, sweep.cases[label].shape, sweep.cases[label].density, seed, changes, point=point)
        for point, (seed, changes) in enumerate(zip(seeds(sweep, wanted.points), found, strict=True))
        for label in sorted(wanted.cases, key=lambda label: sweep.cases[label].shape)
    ]  # fmt: skip


def matched(sweep: Sweep, jamming: "Jamming") -> list[Trial]:
    """Shapes at the packing fractions at which they are as far from jamming as the first case."""
    wanted, (first, density) = sweep.claims.matched, reference(sweep)
    fraction, mu = sweep.packing.fraction, sweep.friction.granule
    states = {
        DISTANCE: lambda shape: jamming.at_distance(shape, first, fraction),
        LOAD: lambda shape: jamming.at_load(shape, first, fraction),
    }
    if mu > 0.0:
        states[ROUGH] = lambda shape: jamming.at_distance(shape, first, fraction, mu)
    return [
        Trial(shape, shape, density, seed, {"packing.fraction": there(shape)}, state, there(shape))
        for seed in seeds(sweep, wanted.seeds)
        for shape in wanted.shapes
        for state, there in states.items()
    ]


def ratios(sweep: Sweep, jamming: "Jamming") -> list[Trial]:
    """Ellipses of many aspect ratios, at the sweep's packing fraction and at equal distance."""
    wanted, (first, density) = sweep.claims.ratios, reference(sweep)
    fraction, found = sweep.packing.fraction, []
    for ratio in wanted.ratios:
        there = jamming.at_distance(ellipse_label(ratio), first, fraction)
        for setting, value in ((FRACTION, fraction), (DISTANCE, there)):
            changes = {f"shapes.{wanted.shape}.aspect_ratio": ratio, "packing.fraction": value}
            found += [
                Trial("ellipse", wanted.shape, density, seed, changes, setting, ratio)
                for seed in seeds(sweep, wanted.seeds)
            ]
    return found


def ellipse_label(ratio: float) -> str:
    """How a table of jamming names ellipses of an aspect ratio."""
    return f"{ratio:g}:1"


def box_label(shape: str, setting: str, x: float) -> str:
    """How a table of jamming names a shape in a box of another size."""
    return f"{shape} {setting} {x:g}"


def scaling(sweep: Sweep, jamming: "Jamming") -> list[Trial]:
    """One size or the velocity changed at a time, all values on one seed together; other boxes also
    as far from jamming as the sweep's own."""
    wanted, (first, _), found = sweep.claims.scaling, reference(sweep), []
    for shape in wanted.shapes:
        density = sweep.density_of(shape)
        for setting in ("velocity", *SIZES):
            if setting == "velocity" and shape != first:
                continue
            number = wanted.velocity_seeds if setting == "velocity" else wanted.seeds
            for seed in seeds(sweep, number):
                for x in getattr(wanted, setting):
                    changes = scaled(sweep, shape, setting, x)
                    found.append(Trial(shape, shape, density, seed, changes, setting, x))
                    if setting in BOXES:
                        label = box_label(shape, setting, x)
                        there = jamming.at_distance(label, shape, sweep.packing.fraction)
                        changes = changes | {"packing.fraction": there}
                        name = f"{setting}, {DISTANCE}"
                        found.append(Trial(shape, shape, density, seed, changes, name, x))
    return found


def scaled(sweep: Sweep, shape: str, setting: str, x: float) -> dict:
    """Changes that make one size, or the velocity, x times that of the sweep.

    The box grows with its granules; in a higher one the cylinder starts as far from the floor.
    """
    granules = {f"shapes.{shape}.granules": round(x * sweep.shapes[shape].granules)}
    return {
        "velocity": {"cylinder.velocity": x * sweep.cylinder.velocity},
        "diameter": {"cylinder.diameter": x * sweep.cylinder.diameter},
        "width": {"box_width": x * sweep.box_width} | granules,
        "height": {"cylinder.start": sweep.cylinder.start / x} | granules,
    }[setting]


PARTS = {
    "replicates": replicates, "sensitivity": sensitivity, "matched": matched, "ratios": ratios,
    "scaling": scaling,
}  # fmt: skip


def trials(sweep: Sweep, part: str, jamming: "Jamming | None" = None) -> list[Trial]:
    """All runs of a part; raises InputError where it does not exist or needs jamming fractions."""
    if part not in PARTS:
        raise InputError(f"part is {part!r}; there are {', '.join(PARTS)}.")
    if part in NEED_JAMMING and jamming is None:
        raise InputError(
            f"jamming is missing; the part {part} needs the files of dem claims jamming."
        )
    return PARTS[part](sweep, jamming)


def count(sweep: Sweep, part: str) -> int:
    """Number of runs of a part, known before any jamming fraction is."""
    return len(trials(sweep, part, _Anywhere()))


class _Anywhere:
    """In place of jamming fractions where they are not known yet."""

    def __init__(self, fraction=0.5):
        self.fraction = fraction

    def at_distance(self, *_):
        return self.fraction

    at_load = at_distance


def groups(sweep: Sweep, part: str) -> int:
    """Number of jobs of a part."""
    return -(-count(sweep, part) // sweep.claims.group)


def share(sweep: Sweep, part: str, group: int, jamming: "Jamming | None" = None) -> list[Trial]:
    """The runs of one job; raises InputError beyond the last, and for runs that cannot be."""
    found, size = trials(sweep, part, jamming), sweep.claims.group
    if group * size >= len(found):
        raise InputError(f"group is {group}; {part} has {-(-len(found) // size)}, from 0.")
    mine = found[group * size : (group + 1) * size]
    check(sweep, mine)
    return mine


def check(sweep: Sweep, some: list[Trial]) -> None:
    """Raise InputError where a run cannot be simulated, before any is."""
    from dem.studies.claims.changes import changed
    from dem.studies.claims.runs import shortened

    sweep = shortened(sweep)
    for trial in some:
        try:
            changed(sweep, trial.changes, trial.shape, trial.density, trial.seed)
        except InputError as error:
            values = ", ".join(f"{path}: {value}" for path, value in trial.changes.items())
            raise InputError(f"claims asks for a run that cannot be ({values}): {error}") from None


def check_all(sweep: Sweep) -> None:
    """The same for all runs, at the packing fraction of the sweep where it is not known yet."""
    for part in PARTS:
        check(sweep, trials(sweep, part, _Anywhere(sweep.packing.fraction)))
