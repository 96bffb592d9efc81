"""What studies refuse, of those that are there."""

import tempfile
from pathlib import Path

import numpy as np
import yaml
from project import CONFIG, ROOT

import dem
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store

STUDIES = ROOT / "studies"
NAMES = [path.name for path in STUDIES.glob("*")]
CALLS = {}


def values_of(study):
    """The smallest sweep of a study."""
    values = yaml.safe_load((STUDIES / study / "smoke.yaml").read_text())
    return values | {"extends": str(CONFIG / "smoke.yaml")}


def made(make):
    """A call of a study for the sweep of config/smoke.yaml, which is no study."""
    return lambda: make(SweepState.of(CONFIG / "smoke.yaml"), 1, None)


def unmade():
    """The runs of a sweep that nobody made."""
    with tempfile.TemporaryDirectory() as folder:
        state = SweepState(load(CONFIG / "smoke.yaml"), Store(Path(folder)), root=Path(folder))
        list(runs(state, ("drag",)))


if NAMES:
    from studies.common.results import runs

    CALLS |= {"is in no file of the store; run again": unmade}

if "calibration" in NAMES:
    from sweeps import dataset_of

    from studies.common.calibrate import calibrate, fit

    MODULI = 76.6e9 * np.array([0.8, 1.0, 1.2])  # Pa
    WIDE = np.exp([[-3.0], [0.0], [3.0]])  # three beds

    CALLS |= {
        "wider than a factor of 10, with 3 seeds: take more seeds": lambda: fit(
            MODULI, WIDE * MODULI / 76.6e6, 1295.0
        ),
        "drag does not rise with the modulus": lambda: fit(MODULI, 1e3 * WIDE / MODULI, 1295.0),
        "the mean drag of 3 beds is not positive": lambda: fit(MODULI, -WIDE * MODULI, 1295.0),
        "target is 0.0": lambda: calibrate(
            dataset_of(np.ones((3, 3)), {"material_young_modulus": MODULI}), 0.0
        ),
    }

if "accuracy" in NAMES:
    from studies.accuracy.results import check

    def checked(shapes="c1", **steps):
        """A sweep of replicates, and of blocks of some steps."""
        blocks = {
            name: {"shape": "c1", "numerics.step_fraction": fractions, "seed": [1001, 1002]}
            for name, fractions in steps.items()
        }
        blocks["replicates"] = {"shape": shapes, "seed": [1001, 1002]}
        values = values_of("accuracy")
        return lambda: check(parse(values | {"sweep": {"blocks": blocks}}))

    CALLS |= {
        "sweep.blocks must be replicates": checked(),
        "run c1 at numerics.step_fraction [0.1, 1.0]": checked(few=[0.1, 1.0]),
        "another up to 1.2": checked(few=[0.5, 2.0]),
        "one shape": checked(["c1", "d1"], few=[0.5, 1.0]),
    }

if "pressure" in NAMES:
    from sweeps import dataset_of

    from studies.pressure.widths import Widths

    def lined(*width):
        axes = {"shape": ["c", "e"], "box": [str(n) for n in range(len(width))]}
        runs = dataset_of(np.ones((2, len(width), 4)), axes)
        return lambda: Widths(runs.assign_coords(box_width=("box", list(width))))

    CALLS |= {
        "2 of box; a line takes 3": lined(1.0, 2.0),
        "fewer than 3 of its boxes differ in width alone": lined(1.0, 2.0, 1.0),
    }

if "claims" in NAMES:
    from studies.claims import results, verbs

    TESTED = ROOT / "docs/data/flow.nc"

    CALLS |= {
        "margin is nan": lambda: verbs.test(TESTED, margin=np.nan),
        "it holds no drag; name drag.nc": lambda: verbs.test(TESTED),
        "has no replicates; see studies": made(results.make),
    }

if "stability" in NAMES:
    from studies.stability import catalogue, results

    def listed(**case):
        def call():
            short = {"experiment": "draw", "shapes": ["c1"], "change": {"displacement": 5e-5}}
            values = {"cases": {"one": short | case}, "limits": {"shapes": ["c1"], "granules": 40}}
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "catalogue.yaml"
                file.write_text(yaml.safe_dump(values))
                catalogue.load(file)

        return call

    CALLS |= {
        "sweep.blocks.map must vary shape, material": made(results.make),
        "beauty": listed(limits={"beauty": 1.0}),
        "limits or an error": listed(limits={}),
    }

if "benchmark" in NAMES:
    from studies.common.peers import lammps

    def lent(shape, **changes):
        return lambda: lammps.script(dem.Scene(shape, **changes), 1e-9, same=True)

    CALLS |= {
        "ellipse": lent(dem.Ellipse([1e-3], [5e-4])),
        "restitution is 0.1; it must be above exp(-2)": lent(
            dem.Disc([1e-3]), material=dem.Material(restitution=0.1)
        ),
    }
