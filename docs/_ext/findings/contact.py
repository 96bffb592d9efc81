"""Restitution of contacts off the centre, by the law of docs/explanation/contact.md."""

from dem.contacts.force_law import damping_from_restitution, restitution_from_damping

# m* over the mass at the contact of two dumbbells that are hit at right angles to their axes
DUMBBELLS = 5.0 / 3.0


def off_centre(restitution: float) -> str:
    """What two dumbbells return at right angles to their axes."""
    alpha = damping_from_restitution(restitution) * DUMBBELLS**0.5
    return f"{restitution_from_damping(alpha):.{2 if restitution >= 0.2 else 3}f}"
