"""Any scene: granules around solids that have names and move in phases. The last phase is recorded.

A phase takes a time, or lasts until the granules are at rest; solids that it does not name move on.
"""

import math

import numpy as np

from dem.base.messages import check_known
from dem.experiment.config import Configuration
from dem.experiment.intruders import intruder_of
from dem.experiment.replicate import Replicate

SECTIONS = {
    "solids": True,
    "phases": True,
    "record": True,
    "sinks": False,
    "sources": False,
    "exchange_interval": False,
}
RECORD = ("cells", "region")
OBSERVED = ("scene",)
AXIS = {
    "time": (("time",), "s", "time since the last phase began, middle of the bin"),
    "snapshot_time": (("snapshot",), "s", "time since the last phase began at the snapshot"),
}
OFF = 0.01  # of the radius of a body of parts: from its place to its centre
SIZES = {"time": "record.bins", "snapshot": "record.snapshots"}


def check(configuration: Configuration) -> None:
    """Raise ValueError where a phase, a sink or a source cannot be."""
    _check_exchange(configuration)
    removed, solids, forced = {}, configuration.solids, set()
    for name, solid in solids.items():
        moving = (phase.motion.get(name, solid) for phase in configuration.phases.values())
        if solid.mass is not None and not any(motion.driven for motion in (solid, *moving)):
            raise ValueError(
                f"solids.{name}.mass is {solid.mass:g} and no force moves it; leave it out, or give "
                "force_x, force_y, torque or spin: free"
            )
        _check_body(configuration, name, solid)
        _check_pivot(solid, solid, f"solids.{name}")
        if solid.path is not None or solid.forces != (None, None):
            forced.add(name)
    for name, phase in configuration.phases.items():
        for solid, motion in phase.motion.items():
            check_known(f"phases.{name}.motion has", solid, solids, "solids")
            if solid in removed:
                raise ValueError(
                    f"phases.{name}.motion has {solid}, which phases.{removed[solid]} removed"
                )
            if motion.removed:
                removed[solid] = name
            if solid in forced and (motion.velocity is None) != (motion.direction is None):
                raise ValueError(
                    f"phases.{name}.motion.{solid} has one of velocity and direction; forces or a path "
                    "moved it before, give both"
                )
            _check_pivot(solids[solid], motion, f"phases.{name}.motion.{solid}")
            if motion.path is not None or motion.forces != (None, None):
                forced.add(solid)
            elif motion.velocity is not None:
                forced.discard(solid)
        plate = configuration.base_plate
        if phase.until and not configuration.gravity and not (plate and plate.friction):
            raise ValueError(
                f"phases.{name}.until is rest and gravity 0; without gravity nothing comes to rest, "
                "give gravity, a base_plate with friction or a time"
            )
    if not configuration.duration:
        raise ValueError(f"phases.{name} is the last and has until; what is recorded needs a time")


def _check_body(configuration: Configuration, name: str, solid) -> None:
    phases = configuration.phases.values()
    moving = [solid, *(phase.motion[name] for phase in phases if name in phase.motion)]
    turns = any(motion.torque is not None or motion.spin == "free" for motion in moving)
    if solid.weight:
        if not (turns or any(motion.forces[1] is not None for motion in moving)):
            raise ValueError(
                f"solids.{name}.weight is true and no force moves it along y, or turns it; leave it "
                "out, or give force_y, spring_y, torque or spin: free"
            )
        if not configuration.gravity:
            raise ValueError(f"solids.{name}.weight is true and gravity 0; leave it out")
    if solid.parts and turns and any(motion.forces != (None, None) for motion in moving):
        body = intruder_of(solid).solid(0.0)
        x, y = (round(c, 9) + 0.0 for c in body.centre)
        if math.hypot(x, y) > OFF * body.radius:
            raise ValueError(
                f"solids.{name}.parts have their centre at [{x:.4g}, {y:.4g}]; a body that forces move "
                "and turn moves about it, put them so that it is at [0, 0]"
            )


def _check_exchange(c: Configuration) -> None:
    for name, sink in c.sinks.items():
        if sink.to is not None:
            check_known(f"sinks.{name}.to is", sink.to, c.sources, "sources")
    fed = {sink.to for sink in c.sinks.values()}
    for name, source in c.sources.items():
        if source.count is None and name not in fed:
            raise ValueError(
                f"sources.{name}.count is missing; no sink gives it granules, give it, or a sink to: {name}"
            )
    interval, acting = c.exchange_interval, c.sinks or c.sources
    if interval and not acting:
        raise ValueError(
            f"exchange_interval is {interval:g} s; there are no sinks and no sources, leave it out"
        )
    if acting and not (interval or c.gravity or c.base_plate):
        raise ValueError(
            "exchange_interval is missing; without gravity nothing says how fast granules are, give it"
        )


def _check_pivot(solid, motion, where: str) -> None:
    if motion.forces != (None, None) and {solid.pivot_x, solid.pivot_y} != {None}:
        raise ValueError(
            f"{where} has a force, and the solid a pivot; forces move the middle of a solid, leave "
            "pivot_x and pivot_y out"
        )


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    record, duration = configuration.record, configuration.duration
    return {
        "time": duration * (np.arange(record.bins) + 0.5) / record.bins,
        "snapshot_time": np.linspace(0.0, duration, record.snapshots),
    }


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates, but for what it takes to come to rest."""
    return sum(phase.time or 0.0 for phase in replicate.configuration.phases.values())
