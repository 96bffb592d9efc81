"""Stress and fabric of the whole bed, at the snapshots; compression is positive.

A run begins without tangential springs: at the first snapshot only normal forces contribute to the
stress.
"""

S = ("snapshot",)
VARIABLES = {
    "stress_xx": (S, "Pa", "stress of the contacts: force along x across lines with normal x"),
    "stress_xy": (S, "Pa", "stress of the contacts: force along x across lines with normal y"),
    "stress_yx": (S, "Pa", "stress of the contacts: force along y across lines with normal x"),
    "stress_yy": (S, "Pa", "stress of the contacts: force along y across lines with normal y"),
    "kinetic_pressure": (
        S,
        "Pa",
        "mean normal stress of the motion of granules about their mean velocity",
    ),
    "fabric_anisotropy": (
        S,
        "1",
        "difference of the principal values of the fabric of contacts between granules",
    ),
    "fabric_angle": (
        S,
        "rad",
        "angle of the direction in which most contacts are, anticlockwise from x",
    ),
}


def look(simulation) -> dict:
    """Values of VARIABLES by name, at one snapshot."""
    stress = simulation.stress()
    kinetic = 0.5 * stress.kinetic.trace()
    values = *stress.contact.ravel(), kinetic, stress.anisotropy, stress.fabric_angle
    return dict(zip(VARIABLES, values, strict=True))
