"""Effective radius and moduli of two bodies that touch: E* and G* (Pa), R* (m)."""


def effective_radius(one, two):
    """R* (m) of two radii, of which the second is zero for a flat body."""
    return one * two / (one + two) if two > 0.0 else one


def effective_modulus(*materials):
    """E* (Pa) of the elastic materials that meet; a rigid partner is left out."""
    return 1.0 / sum((1.0 - m.poisson_ratio**2) / m.young_modulus for m in materials)


def effective_shear_modulus(*materials):
    """G* (Pa), 1/G* = sum of 2 (2 - nu)(1 + nu) / E over the elastic materials that meet."""
    return 1.0 / sum(
        2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.young_modulus for m in materials
    )
