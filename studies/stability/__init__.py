"""Stiff and extreme cases: a catalogue, a map of the time step, the paper's cases with a ledger."""
