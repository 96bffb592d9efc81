"""Errors with a name: what went wrong, where and when, in one sentence."""


class InputError(ValueError):
    """A value that the user gave cannot be used; nothing was written.

    The sentence names the value and what to write instead. The exit status of a verb is 2.

    Examples
    --------
    >>> import dem
    >>> dem.Friction(-0.1)
    Traceback (most recent call last):
    ...
    dem.base.errors.InputError: friction granule is -0.1; it must be zero or a positive number, up to 1e+20.
    """


class RunError(RuntimeError):
    """A run failed. The exit status of a verb is 1; all errors below are RunErrors."""


class PackingError(RunError):
    """No bed comes to rest at this packing fraction; lower packing.fraction or take another seed."""


class OverlapError(RunError):
    """Two bodies overlap by more than `max_overlap` of the smaller granule's radius."""


class StateError(RunError):
    """A position or velocity is not finite, a granule left the box, or steps are too short."""
