"""What the energy ledger leaves unexplained, at the snapshots."""

LEDGER = True  # the simulation keeps one
VARIABLES = {
    "ledger_residual": (("snapshot",), "1", "residual of the energy ledger"),
}


def measure(seen) -> dict:
    """Values of VARIABLES by name."""
    return {"ledger_residual": seen.residual}
