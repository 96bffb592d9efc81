"""What compilers do not choose by themselves: instructions of the processor, and its widest vectors.

Each is a function that Python can call, and an intrinsic of Numba in kernels.
"""

import os

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

ALIGNED = 8  # bytes
NUMBER = ir.IntType(32)
INLINED = {"_nrt": False, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
SPINS = 2000  # checks of a barrier before a thread yields the processor

INTRINSICS = {}  # functions that Python calls, and what kernels call in place of them


def in_kernels(function):
    """Decorator of a function that returns what kernels call in place of another one."""

    def decorate(python):
        INTRINSICS[python] = python
        overload(python, jit_options=INLINED)(function)
        return python

    return decorate


def _pointer(context, builder, signature, arguments, kind):
    """Pointer of a kind to array[index] (1-D), of the first two arguments."""
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    return builder.bitcast(builder.gep(data, [arguments[1]]), kind.as_pointer())


def attribute(change):
    """An intrinsic that changes the attributes of the function that calls it.

    Kernels call it directly: through an overload with `inline="always"`, Numba 0.68 left out the last
    `if` of dem.dynamics.neighbours.set_reference, without a word.
    """

    def typed(typing):
        def generate(context, builder, signature, arguments):
            change(builder.function.attributes)
            return context.get_dummy_value()

        return types.none(), generate

    return intrinsic(typed)


def widest_vectors():
    """Use vectors of 512 bits in the function that calls this: LLVM takes vectors of 256 bits on
    processors of Intel that have both. A step of discs takes a tenth less."""


def noinline():
    """Compile the function that has this line once for a kernel, and have others call it: it is long, or
    has several callers. All others become part of their callers.

    Numba compiles a function again for callers whose options differ; so options are the same for all.
    """


# llvmlite's own `add` knows attributes of one word only
INTRINSICS[widest_vectors] = attribute(lambda have: set.add(have, '"prefer-vector-width"="512"'))
INTRINSICS[noinline] = attribute(lambda have: have.discard("alwaysinline"))


@intrinsic
def _prefetch(typing, array, index):
    def generate(context, builder, signature, arguments):
        byte = ir.IntType(8)
        where = _pointer(context, builder, signature, arguments, byte)
        kind = ir.FunctionType(ir.VoidType(), [byte.as_pointer(), NUMBER, NUMBER, NUMBER])
        function = builder.module.declare_intrinsic("llvm.prefetch", [byte.as_pointer()], kind)
        read, second_level, data_cache = NUMBER(0), NUMBER(2), NUMBER(1)
        builder.call(function, [where, read, second_level, data_cache])
        return context.get_dummy_value()

    return types.none(array, index), generate


@in_kernels(lambda array, index: lambda array, index: _prefetch(array, index))
def prefetch(array, index):
    """Start to load the cache line that holds array[index] (1-D) into the second-level cache.

    It never fails and changes nothing. Beds that do not fit into the caches gain a tenth. The first
    level can wait for few lines at a time, and those that the kernel works on must stay.
    """


@intrinsic
def _add_four(typing, array, index, a, b, c, d):
    def generate(context, builder, signature, arguments):
        four = ir.VectorType(ir.DoubleType(), 4)
        where = _pointer(context, builder, signature, arguments, four)
        change = ir.Constant(four, ir.Undefined)
        for place, number in enumerate(arguments[2:]):
            change = builder.insert_element(change, number, NUMBER(place))
        before = builder.load(where, align=ALIGNED)
        builder.store(builder.fadd(before, change), where, align=ALIGNED)
        return context.get_dummy_value()

    return types.none(array, index, a, b, c, d), generate


@in_kernels(
    lambda array, index, a, b, c, d: (
        lambda array, index, a, b, c, d: _add_four(array, index, a, b, c, d)
    )
)
def add_four(array, index, a, b, c, d):
    """Add four numbers to array[index] (1-D, float64) and the three after it.

    In kernels it is one move of a vector unit, because a store costs more than a sum.
    """
    for place, number in enumerate((a, b, c, d), int(index)):
        array[place] += number


@intrinsic
def _add_one(typing, array, index):
    def generate(context, builder, signature, arguments):
        one = context.get_constant(types.int64, 1)
        where = _pointer(context, builder, signature, arguments, ir.IntType(64))
        return builder.add(builder.atomic_rmw("add", where, one, "seq_cst"), one)

    return types.int64(array, index), generate


@intrinsic
def _load(typing, array, index):
    def generate(context, builder, signature, arguments):
        where = _pointer(context, builder, signature, arguments, ir.IntType(64))
        return builder.load_atomic(where, "seq_cst", align=ALIGNED)

    return types.int64(array, index), generate


if hasattr(os, "sched_yield"):
    _yield_processor = types.ExternalFunction("sched_yield", types.int32())
else:
    _yield_processor = None


def _wait(arrivals, size):
    if size == 1:
        return
    number = _add_one(arrivals, 0)
    full = (number + size - 1) // size * size
    spins = 0
    while _load(arrivals, 0) < full:
        spins += 1
        if spins > SPINS:
            if _yield_processor is not None:
                _yield_processor()
            spins = 0


@in_kernels(lambda arrivals, size: _wait)
def barrier(arrivals, size):
    """Wait until all of `size` threads have arrived; arrivals (1,): how often threads did so far.

    A barrier of the operating system takes longer than a short step. Threads spin instead, and
    yield the processor when they wait for long.
    """
