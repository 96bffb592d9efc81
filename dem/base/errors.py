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
    dem.base.errors.InputError: Friction.granule is -0.1; it must be at least 0.
    """


class RunError(RuntimeError):
    """A run failed. The exit status of a verb is 1; all errors below are RunErrors.

    Examples
    --------
    >>> import dem
    >>> issubclass(dem.OverlapError, dem.RunError)
    True
    """


class PackingError(RunError):
    """No bed comes to rest at this packing fraction or pressure; lower it or take another seed.

    Examples
    --------
    >>> import dem
    >>> cylinder = dem.Cylinder(diameter=1e-3, position=(3e-3, 2e-3), velocity=(0.0, 1.0))
    >>> dem.pack(dem.Disc([1e-3] * 12), width=6e-3, height=6.2e-3, solids=cylinder, seed=1)
    Traceback (most recent call last):
    ...
    dem.base.errors.PackingError: the bed at packing fraction 1.035 (seed 1) cannot be made: ...
    """


class OverlapError(RunError):
    """Two bodies overlap by more than `max_overlap` of the smaller granule's radius.

    Examples
    --------
    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]))
    >>> dem.simulate(scene, dem.State([[0, 0], [1e-5, 0]]), duration=1e-5)
    Traceback (most recent call last):
    ...
    dem.base.errors.OverlapError: granule 0 overlaps granule 1 by 1.99 of the smaller radius at step 0, ...
    """


class StateError(RunError):
    """A position or velocity is not finite, a granule left the box, or steps are too short.

    Examples
    --------
    >>> import dem
    >>> box = dem.box(width=1e-2, height=1e-2)
    >>> scene = dem.Scene(dem.Disc([1e-3]), friction=dem.Friction(), walls=box, gravity=(0, -9.81))
    >>> dem.simulate(scene, dem.State([[-2e-3, 5e-3]]), duration=1e-5)
    Traceback (most recent call last):
    ...
    dem.base.errors.StateError: granule 0 has its centre 0.002 m behind wall 0 at step 0, ...
    """
