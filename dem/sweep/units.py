"""Velocities that another unit was probably meant for: mm/s for m/s, MPa for Pa."""

import math

from dem.sweep.campaign import Campaign

FASTEST = 0.1  # of the velocity of sound, beyond which a bed is shocked rather than sheared


def unusual(campaign: Campaign) -> list[str]:
    """A sentence of the fastest run, where its cylinder is so fast that another unit was probably meant."""
    found = {}
    blocks = map(campaign.block, campaign.sweep.blocks)
    for run in (run.replicate for block in blocks for run in block.runs):
        own = run.configuration
        if own.experiment == "drag":
            sound = math.sqrt(own.material.young_modulus / run.density)
            found[own.cylinder.velocity / sound] = own.cylinder.velocity, sound
    share = max(found, default=0.0)
    if share <= FASTEST:
        return []
    velocity, sound = found[share]
    return [
        f"Warning: cylinder.velocity is {velocity:g} m/s, {share:.2g} of the velocity of sound in a granule, "
        f"sqrt(material.young_modulus / density) = {sound:.4g} m/s; it should be below {FASTEST:g}. Are all "
        "values in SI units?"
    ]
