"""What an experiment cannot do: a pressure that cannot be, a file that cannot be sheared, beds that do not jam."""

from beds import replicate
from project import ROOT
from sweeps import sheared_values

from dem.experiment.config import of_values, parse
from dem.sweep.config import load


def pressed(**changes):
    return lambda: replicate(**changes)


def sheared(**changes):
    return lambda: of_values(sheared_values(**changes))


def jammed(**changes):
    """A run of the experiment onset."""

    def call():
        values = load(ROOT / "config/smoke.yaml").values() | {"experiment": "onset"}
        shapes = {"c": {"kind": "disc", "diameter": 1e-3, "granules": 40}}
        parse({**values, "cylinder": None, "shapes": shapes, **changes})

    return call


DUMBBELLS = {"disc": {"kind": "dumbbell", "diameter": 1e-3, "granules": 72}}
CYLINDER = {"diameter": 2e-3, "velocity": 1.0, "start": 0.3, "stroke": 1e-3}
CALLS = {
    "neither fraction nor pressure": (
        pressed(pressure=None),
        "fraction is missing; give it, or a pressure",
    ),
    "fraction and pressure": (
        pressed(**{"packing.fraction": 0.84}),
        "fraction is 0.84 and pressure 6e+07 Pa; one follows from the",
    ),
    "friction in a bed under a pressure": (
        pressed(**{"packing.friction": 0.3}),
        "friction is 0.3 and preparation relaxed; a bed that is packed under a pressure",
    ),
    "a pressure without a top wall": (
        pressed(periodic="y"),
        "packing.pressure is 6e+07 Pa and periodic y; a pressure needs a top",
    ),
    "a pressure where beds are compressed": (
        pressed(experiment="jamming"),
        "packing.pressure is 6e+07; the experiment jamming takes none",
    ),
    "no pressure at all": (pressed(pressure=0.0), "packing.pressure is 0.0; it must be positive"),
    "shear between side walls": (
        sheared(periodic="none"),
        "periodic is none; the experiment shear needs x",
    ),
    "shear with gravity": (sheared(gravity=9.81), "gravity is 9.81; the experiment shear needs 0"),
    "shear without its section": (sheared(shear=None), "shear is missing"),
    "shear of dumbbells": (
        sheared(shapes=DUMBBELLS),
        "shapes.disc.kind is dumbbell; the experiment shear needs disc",
    ),
    "shear with a cylinder": (
        sheared(cylinder=CYLINDER),
        "cylinder is no section of the experiment shear; leave it out",
    ),
    "shear of one sample": (
        sheared(shear=sheared_values()["shear"] | {"samples": 1}),
        "shear.samples is 1; it must be at least 2",
    ),
    "drag without a cylinder": (sheared(experiment="drag"), "cylinder is missing"),
    "values of another experiment": (
        lambda: of_values(sheared_values()).configuration.changed(
            {"cylinder.velocity": 1.0}, "disc"
        ),
        "the experiment shear has no cylinder",
    ),
    "onset with friction": (
        jammed(packing={"fraction": 0.84, "size_spread": 0.2, "friction": 0.3}),
        "packing.friction is 0.3; the experiment onset needs 0",
    ),
}
