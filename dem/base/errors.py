"""Errors with a name: what went wrong, where and when, in one sentence."""


class InputError(ValueError):
    """A value that the user gave cannot be used; nothing has been written (exit status 2)."""


class RunError(RuntimeError):
    """A run failed (exit status 1)."""


class PackingError(RunError):
    """No bed at rest could be made at the packing fraction that was asked for."""


class OverlapError(RunError):
    """Two bodies overlap by more than the stated fraction of the smaller granule's radius."""


class StateError(RunError):
    """A position or velocity is not a number, a granule has left the box, or steps are too short."""
