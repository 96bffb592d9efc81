"""The section `cylinder` in other words: solids of a scene, and a phase in which they move."""

import math

from dem.base.declarations import definitions
from dem.experiment.observables import file_of
from dem.experiment.scene_sections import PhaseSection, SolidSection


def as_scene(configuration) -> dict:
    """Sections of the scene that a cylinder, and a second one, are; both are centred in the box."""
    cylinder, second = configuration.cylinder, configuration.second
    width, dx, dy = configuration.box_width, 0.0, 0.0
    if second is not None:
        (x, y), apart = cylinder.ahead, second.gap + 0.5 * (cylinder.diameter + second.diameter)
        beside, along = apart * math.cos(second.bearing), apart * math.sin(second.bearing)
        dx, dy = beside * y + along * x, along * y - beside * x
    shared = "velocity", "direction", "material", "start"
    moving = {name: getattr(cylinder, name) for name in shared}
    solids = {
        "cylinder": SolidSection.model_construct(
            outline=cylinder.outline or "circle",
            diameter=cylinder.diameter,
            thickness=cylinder.aspect_ratio and cylinder.diameter / cylinder.aspect_ratio,
            x=0.5 * width - 0.5 * dx,
            y=0.0 - 0.5 * dy,
            angle=cylinder.angle or 0.0,
            spin=cylinder.spin,
            **moving,
        )
    }
    if second is not None:
        solids["second"] = SolidSection.model_construct(
            outline="circle",
            diameter=second.diameter,
            x=0.5 * width + 0.5 * dx,
            y=0.5 * dy,
            friction=second.friction,
            spin=second.spin,
            **moving,
        )
    time = cylinder.stroke / cylinder.velocity
    looks = [  # they ask the simulation alone, and not how far a cylinder is
        name
        for name in configuration.observables
        if "measure" not in definitions(file_of(name, configuration.beside))
    ]
    record = configuration.record
    recorded = {"window": None, "observables": tuple(sorted((*looks, "scene"))) if looks else None}
    return {
        "experiment": "scene",
        "cylinder": None,
        "second": None,
        "solids": solids,
        "phases": {"draw": PhaseSection.model_construct(time=time)},
        "record": record and record.model_copy(update=recorded),
    }
