"""What studies refuse, of those that are there."""

import tempfile
from pathlib import Path

import numpy as np
import yaml
from beds import make_small_bed
from project import CONFIG, ROOT

import dem
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store

STUDIES = ROOT / "studies"
CALLS = {}


def values_of(study, change):
    """The smallest sweep of a study, changed."""
    values = yaml.safe_load((STUDIES / study / "smoke.yaml").read_text())
    change(values["sweep"]["blocks"])
    return values | {"extends": str(CONFIG / "smoke.yaml")}


def made(study):
    """The file of results of the sweep of config/smoke.yaml, which is no study."""

    def call():
        results = __import__(f"studies.{study}.results", fromlist=["make"])
        results.make(SweepState.of(CONFIG / "smoke.yaml"), 1, None)

    return call


def unmade():
    """The runs of a sweep that nobody made."""
    with tempfile.TemporaryDirectory() as folder:
        state = SweepState(load(CONFIG / "smoke.yaml"), Store(Path(folder)), root=Path(folder))
        list(runs(state, ("drag",)))


if STUDIES.is_dir():
    from studies.common.results import runs

    CALLS |= {"runs of no file": (unmade, "is in no file of the store; run again")}

if (STUDIES / "calibration").is_dir():
    from sweeps import dataset_of

    from studies.common.calibrate import calibrate, fit

    MODULI = 76.6e9 * np.array([0.8, 1.0, 1.2])  # Pa
    WIDE = np.exp([[-3.0], [0.0], [3.0]])  # three beds

    def fitted(means, target=1295.0):
        return lambda: fit(MODULI, 1e3 * means, target)

    def aimed(target):
        runs = dataset_of(np.ones((3, 3)), {"material_young_modulus": MODULI})
        return lambda: calibrate(runs, target)

    def other():
        with dem.open_results(ROOT / "docs/data/drag.nc") as runs:
            calibrate(runs, 1295.0)

    CALLS |= {
        "a modulus of beds that scatter": (
            fitted(WIDE * MODULI / 76.6e9),
            "wider than a factor of 10, with 3 seeds: take more seeds",
        ),
        "a modulus by which no drag rises": (
            fitted(WIDE / MODULI),
            "drag does not rise with the modulus",
        ),
        "a drag below zero": (fitted(-WIDE * MODULI), "the mean drag of 3 beds is not positive"),
        "a modulus of other runs": (other, "its runs are over case, seed"),
    }
    CALLS |= {f"a target of {x}": (aimed(x), f"target is {x}") for x in (np.inf, 0.0)}

if (STUDIES / "accuracy").is_dir():
    from studies.accuracy.results import check

    def checked(shapes="c1", **steps):
        """A sweep of replicates, and of blocks of some steps."""

        def change(blocks):
            blocks.clear()
            blocks["replicates"] = {"shape": shapes, "seed": [1001, 1002]}
            for name, fractions in steps.items():
                run = {"shape": "c1", "numerics.step_fraction": fractions, "seed": [1001, 1002]}
                blocks[name] = run

        return lambda: check(parse(values_of("accuracy", change)))

    CALLS |= {
        "an accuracy without steps": (checked(), "sweep.blocks must be replicates"),
        "an accuracy without the default step": (
            checked(few=[0.1, 1.0]),
            "run c1 at numerics.step_fraction [0.1, 1.0]",
        ),
        "an accuracy of steps that break": (checked(few=[0.5, 2.0]), "another up to 1.2"),
        "an accuracy of two shapes": (checked(["c1", "d1"], few=[0.5, 1.0]), "one shape"),
    }

if (STUDIES / "pressure").is_dir():
    from sweeps import dataset_of

    from studies.pressure.widths import Widths

    def lined(shapes=2, width=(1.0, 2.0, 4.0)):
        axes = {"shape": list("ce")[:shapes], "box": [str(n) for n in range(len(width))]}
        runs = dataset_of(np.ones((shapes, len(width), 4)), axes)
        return lambda: Widths(runs.assign_coords(box_width=("box", list(width))))

    CALLS |= {
        "a line of two boxes": (lined(width=(1.0, 2.0)), "2 of box; a line takes 3"),
        "a line of one shape": (lined(shapes=1), "1 of shape; a line takes 2"),
        "a line of two widths": (
            lined(width=(1.0, 2.0, 1.0)),
            "fewer than 3 of its boxes differ in width alone",
        ),
    }

if (STUDIES / "claims").is_dir():
    from studies.claims import verbs

    TESTED = ROOT / "docs/data/flow.nc"

    def derived(value=None, **more):
        def change(blocks):
            matched = blocks["matched"]
            if value is None:
                del matched["needs"]
            else:
                matched["setting"]["equal load"]["packing.fraction"] = {"derive": value, **more}

        return lambda: parse(values_of("claims", change))

    def too_high(blocks):
        points = {"0.3": {"cylinder.start": 0.8, "shapes.c1.granules": 18}}
        blocks["jamming_height"]["factor"] = points

    CALLS |= {
        "a margin that is none": (lambda: verbs.test(TESTED, margin=np.nan), "margin is nan"),
        "claims of runs without drag": (
            lambda: verbs.test(TESTED),
            "it holds no drag; name drag.nc",
        ),
        "claims of another sweep": (made("claims"), "has no replicates; see studies"),
        "a run that cannot be": (
            lambda: parse(values_of("claims", too_high)),
            "jamming_height asks for",
        ),
        "a value of no derivation": (derived("equal_pressure"), "it must be 'equal_distance' or"),
        "a derivation for no shape": (derived("equal_load", shape="z9"), "has the shape 'z9'"),
        "a derivation without friction": (
            derived("equal_distance", friction=-0.1),
            "friction is -0.1",
        ),
        "an unknown key of a derivation": (
            derived("equal_distance", of="c1"),
            "of is not a known key",
        ),
        "a derivation from nothing": (derived(), "matched derives values; needs must name"),
    }

if (STUDIES / "stability").is_dir():
    from studies.stability import catalogue

    def listed(**case):
        def call():
            short = {"experiment": "draw", "shapes": ["c1"], "change": {"displacement": 5e-5}}
            limits = {"shapes": ["c1"], "granules": 40}
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "catalogue.yaml"
                file.write_text(yaml.safe_dump({"cases": {"one": short | case}, "limits": limits}))
                catalogue.load(file)

        return call

    CALLS |= {
        "stability of another sweep": (
            made("stability"),
            "sweep.blocks.map must vary shape, material",
        ),
        "a limit of no measure": (listed(limits={"beauty": 1.0}), "beauty"),
        "a case without limits": (listed(limits={}), "limits or an error"),
        "a case of no stiffness": (
            listed(limits={"residual": 1.0}, change={"stiffness": -1.0}),
            "stiffness",
        ),
    }

if (STUDIES / "benchmark").is_dir():
    from studies.common.peers import lammps

    def lent(kind, **changes):
        def call():
            small = make_small_bed(kind)
            lammps.Run(small.scene(**changes), small.state, 1e-9, same=True)

        return call

    if lammps.available() is None:
        CALLS |= {
            "ellipses in LAMMPS": (lent("ellipse"), "ellipse"),
            "a dashpot that LAMMPS lacks": (
                lent("disc", material=dem.Material(restitution=0.1)),
                "restitution is 0.1; it must be above exp(-2)",
            ),
        }
