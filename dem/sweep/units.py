"""Values that another unit was probably meant for: mm/s for m/s, MPa for Pa."""

import numpy as np

from dem.sweep.campaign import Campaign

FASTEST = 0.1  # of the velocity of sound, beyond which a bed is shocked rather than sheared
SPARSEST = 1.0  # inertial number, beyond which a bed is no dense flow


def unusual(campaign: Campaign) -> list[str]:
    """Velocities so high that another unit was probably meant, one sentence each: of the fastest run
    over the velocity of sound, and of the highest inertial number where the pressure is known."""
    sound, inertia = (0.0, ""), (0.0, "")
    for replicate in {
        (id(run.replicate.configuration), run.replicate.density): run.replicate
        for name in campaign.sweep.blocks for run in campaign.block(name).runs
    }.values():  # fmt: skip
        own, density = replicate.configuration, replicate.density
        if own.experiment == "shear":
            number = own.shear.inertial_number
            inertia = max(inertia, (number, f"shear.inertial_number is {number:g}"))
        if own.experiment != "drag":
            continue
        speed, drawn = np.sqrt(own.material.young_modulus / density), own.cylinder.velocity
        words = (
            f"cylinder.velocity is {drawn:g} m/s, {drawn / speed:.2g} of the velocity of sound in a "
            f"granule, sqrt(material.young_modulus / density) = {speed:.4g} m/s"
        )
        sound = max(sound, (drawn / speed, words))
        if (load := own.packing.pressure) is not None:
            time = replicate.shape.diameter * np.sqrt(density / load)
            number = drawn / own.cylinder.diameter * time
            words = (
                f"cylinder.velocity is {drawn:g} m/s and packing.pressure is {load:g} Pa, an inertial "
                f"number of {number:.2g}"
            )
            inertia = max(inertia, (number, words))
    return [
        f"Warning: {words}; it should be below {limit:g}. Are all values in SI units?"
        for (found, words), limit in ((sound, FASTEST), (inertia, SPARSEST))
        if found > limit
    ]
