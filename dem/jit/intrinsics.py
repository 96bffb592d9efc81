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


def _pointer(context, builder, array_type, array, index, kind):
    """Pointer of a kind to array[index] (1-D)."""
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), kind.as_pointer())


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
        where = _pointer(context, builder, signature.args[0], *arguments, byte)
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
        where = _pointer(context, builder, signature.args[0], *arguments[:2], four)
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


def _rows(context, builder, kind, source, places):
    """Four vectors of four numbers, from source[place] of each place on."""
    wide = ir.VectorType(ir.DoubleType(), 4)
    where = (builder.extract_value(places, c) for c in range(4))
    pointers = [_pointer(context, builder, kind, source, at, wide) for at in where]
    return [builder.load(at, align=ALIGNED) for at in pointers]


def _put_columns(context, builder, kind, target, k, apart, rows):
    """Write four vectors of four numbers to target[k], as columns that are so many numbers apart."""

    def mixed(one, two, places):
        return builder.shuffle_vector(one, two, ir.Constant(ir.VectorType(NUMBER, 4), places))

    a, b, c, d = rows
    halves = [(mixed(a, b, at), mixed(c, d, at)) for at in ((0, 4, 2, 6), (1, 5, 3, 7))]
    for at in ((0, 1, 4, 5), (2, 3, 6, 7)):
        for half in halves:
            builder.store(
                mixed(*half, at),
                _pointer(context, builder, kind, target, k, a.type),
                align=ALIGNED,
            )
            k = builder.add(k, apart)
    return context.get_dummy_value()


@intrinsic
def _transpose(typing, target, k, apart, source, ones):
    def generate(context, builder, signature, arguments):
        target, k, apart, source, ones = arguments
        kind, *_, from_kind, _ = signature.args
        rows = _rows(context, builder, from_kind, source, ones)
        return _put_columns(context, builder, kind, target, k, apart, rows)

    return types.none(target, k, apart, source, ones), generate


@in_kernels(
    lambda target, k, apart, source, ones: (
        lambda target, k, apart, source, ones: _transpose(target, k, apart, source, ones)
    )
)
def transpose(target, k, apart, source, ones):
    """Write the four numbers from each of four places of source on (1-D, float64) to target[k]: the first
    of each side by side, the second of each so many numbers `apart`, and so on.

    In kernels these are moves of a vector unit: of one contact it reads numbers that are together, and
    it computes with one number of several contacts.
    """
    for c, row in enumerate(ones):
        for r in range(4):
            target[int(k) + int(apart) * r + c] = source[int(row) + r]


@intrinsic
def _transpose_differences(typing, target, k, apart, source, ones, twos):
    def generate(context, builder, signature, arguments):
        target, k, apart, source, ones, twos = arguments
        kind, *_, from_kind, _, _ = signature.args
        one, two = (_rows(context, builder, from_kind, source, places) for places in (ones, twos))
        rows = [builder.fsub(second, first) for first, second in zip(one, two, strict=True)]
        return _put_columns(context, builder, kind, target, k, apart, rows)

    return types.none(target, k, apart, source, ones, twos), generate


@in_kernels(
    lambda target, k, apart, source, ones, twos: (
        lambda target, k, apart, source, ones, twos: _transpose_differences(
            target, k, apart, source, ones, twos
        )
    )
)
def transpose_differences(target, k, apart, source, ones, twos):
    """As `transpose`, of the numbers from the second places on less those from the first on."""
    for c, (one, two) in enumerate(zip(ones, twos, strict=True)):
        for r in range(4):
            number = source[int(two) + r] - source[int(one) + r]
            target[int(k) + int(apart) * r + c] = number


@intrinsic
def _add_one(typing, array, index):
    def generate(context, builder, signature, arguments):
        one = context.get_constant(types.int64, 1)
        where = _pointer(context, builder, signature.args[0], *arguments, ir.IntType(64))
        return builder.add(builder.atomic_rmw("add", where, one, "seq_cst"), one)

    return types.int64(array, index), generate


@intrinsic
def _load(typing, array, index):
    def generate(context, builder, signature, arguments):
        where = _pointer(context, builder, signature.args[0], *arguments, ir.IntType(64))
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
