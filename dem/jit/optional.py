"""Arithmetic in which an absent quantity costs nothing.

A disc has no lever in the tangential direction, a frictionless contact no tangential force. Such
a quantity is ``None``: its type is known while compiling, so the terms with it are never
compiled at all (a float 0.0 would stay, since 0.0 * x is not 0.0 for every x).
"""

import functools

from numba.core import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, overload

from dem.jit.compilation import INLINED, ROLLED

NONE = types.none


def optional(function):
    """Decorator: an inlined function that returns None, compiling nothing, if its first argument is
    None."""

    def choose(first, *rest):
        return None if first is NONE else function

    @functools.wraps(function)
    def present(first, *rest):
        return None if first is None else function(first, *rest)

    class Absent(AbstractTemplate):
        key = present

        def generic(self, kinds, keywords):
            return signature(NONE, *kinds) if kinds[0] is NONE else None

    infer_global(present, types.Function(Absent))
    lower_builtin(present, NONE, types.VarArg(types.Any))(
        lambda context, *_: context.get_dummy_value()
    )
    overload(present, strict=False, jit_options=INLINED)(choose)
    return present


def rolled_without_first(function):
    """Decorator: an inlined loop, left rolled (dem.jit.compilers) if its first argument is None.

    The loop is then so short that LLVM would unroll it before the kernel can make vector code of
    it.
    """
    overload(function, strict=False, jit_options=INLINED)(
        lambda first, *rest: None if first is NONE else function
    )
    overload(function, strict=False, jit_options=ROLLED)(
        lambda first, *rest: function if first is NONE else None
    )
    return function


def _by_presence(stub):
    """Decorator: `stub` returns the function of two arguments to compile, given which are
    present."""

    def operation(a, b):
        return stub(a is not None, b is not None)(a, b)

    def choose(a, b):
        return stub(not isinstance(a, types.NoneType), not isinstance(b, types.NoneType))

    operation.__name__, operation.__doc__ = stub.__name__, stub.__doc__
    overload(operation, strict=False, jit_options=INLINED)(choose)
    return operation


@_by_presence
def plus(a, b):
    """a + b; whichever is present; None if neither is."""
    if a and b:
        return lambda a, b: a + b
    return (lambda a, b: a) if a else (lambda a, b: b)


@_by_presence
def minus(a, b):
    """a - b; a or -b if only that is present; None if neither is."""
    if a and b:
        return lambda a, b: a - b
    if b:
        return lambda a, b: -b
    return lambda a, b: a


@_by_presence
def times(a, b):
    """a * b; None if either is absent."""
    return (lambda a, b: a * b) if a and b else (lambda a, b: None)


@_by_presence
def either(a, b):
    """a if present, else b."""
    return (lambda a, b: a) if a else (lambda a, b: b)


@_by_presence
def given(a, b):
    """b; None if a is absent."""
    return (lambda a, b: b) if a else (lambda a, b: None)
