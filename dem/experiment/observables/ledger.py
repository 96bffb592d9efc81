"""What the energy ledger leaves unexplained, at the snapshots."""

LEDGER = True  # the simulation keeps one
VARIABLES = {
    "ledger_residual": (("snapshot",), "1", "residual of the energy ledger"),
}


def look(simulation) -> dict:
    """Values of VARIABLES by name, at one snapshot."""
    return {"ledger_residual": simulation.ledger().residual}
