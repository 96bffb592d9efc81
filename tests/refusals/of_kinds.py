"""What an experiment cannot do: take a pressure, shear a file, shift beds."""

from sweeps import sheared_values

from dem.experiment.config import of_values


def sheared(**changes):
    return lambda: of_values(sheared_values(**changes))


DUMBBELLS = {"disc": {"kind": "dumbbell", "diameter": 1e-3, "granules": 72}}
CYLINDER = {"diameter": 2e-3, "velocity": 1.0, "start": 0.3, "stroke": 1e-3}
CALLS = {
    "periodic is none; the experiment shear needs x": sheared(periodic="none"),
    "gravity is 9.81; the experiment shear needs 0": sheared(gravity=9.81),
    "shear is missing; the experiment shear needs it": sheared(shear=None),
    "shapes.disc.kind is dumbbell; the experiment shear needs disc": sheared(shapes=DUMBBELLS),
    "cylinder is no section of the experiment shear; leave": sheared(cylinder=CYLINDER),
    "cylinder is missing; the experiment drag needs it": sheared(experiment="drag"),
    "the experiment shear has no cylinder": lambda: of_values(
        sheared_values()
    ).configuration.changed({"cylinder.velocity": 1.0}, "disc"),
}
FILES = {
    "packing.pressure is 6e+07; the experiment jamming takes none": {
        "experiment": "jamming",
        "cylinder": None,
        "packing.fraction": None,
        "packing.pressure": 6e7,
    },
}
