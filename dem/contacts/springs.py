"""A spring of friction or of rolling resistance at one contact, under Coulomb's cap.

Symbols: measure of the law (dem.laws.protocol), tangential stiffness k_t (N/m).
"""

TINY = 1e-300


def spring_after(spring, measured, last, stiffness, slip):
    """Force (N) or moment (N m) of a tangential or rolling spring after a further slip (m or rad).

    A contact remembers this force. Its increment is k_t slip, where k_t = stiffness * measured is
    the mean over both ends of the step while the overlap grows. This makes the increment second
    order. While the contact unloads, the force shrinks with k_t, under Hertz's law the contact
    radius (Thornton, Cummins and Cleary 2013, Powder Technol. 233, 30). In both cases the stored
    energy spring^2 / (2 k_t) can only fall when the overlap changes: no contact makes energy.
    """
    kept = min(measured / max(last, TINY), 1.0)  # without a branch; 1 for a new contact
    return spring * kept - stiffness * 0.5 * (measured + kept * last) * slip


def capped(force, limit):
    """Coulomb: the force (N), at most limit in size."""
    return min(max(force, -limit), limit)
