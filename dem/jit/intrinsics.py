"""What compilers do not choose by themselves: instructions of the processor, and its widest vectors.

Each is a function that Python can call, and an intrinsic of Numba in kernels.
"""

import os
from inspect import Parameter, Signature, signature

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

ALIGNED = 8  # bytes
NUMBER, WHOLE, FOUR = ir.IntType(32), ir.IntType(64), ir.VectorType(ir.DoubleType(), 4)
SPINS = 2000  # checks of a barrier before a thread yields the processor

INTRINSICS = {}  # functions that Python calls, and what kernels call in place of them


def in_kernels(generate, result=types.none):
    """Decorator of a function that Python calls: kernels have in its place the instructions that
    `generate` writes, whose arguments are those of code generators of Numba's intrinsics; it returns
    their result, or nothing.

    Kernels call intrinsics directly: through an overload with `inline="always"`, Numba 0.68 left out the
    last `if` of dem.dynamics.neighbours.set_reference, without a word.
    """

    def generated(context, builder, signature, arguments):
        value = generate(context, builder, signature, arguments)
        return context.get_dummy_value() if value is None else value

    def decorate(python):
        def typed(typing, *kinds):
            return result(*kinds), generated

        context = Parameter("typing", Parameter.POSITIONAL_OR_KEYWORD)
        names = signature(python).parameters.values()
        typed.__signature__ = Signature([context, *names])  # type: ignore[attr-defined]
        INTRINSICS[python] = intrinsic(typed)
        return python

    return decorate


def _pointer(context, builder, array_type, array, index, kind):
    """Pointer of a kind to array[index] (1-D)."""
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), kind.as_pointer())


def attribute(change):
    """Decorator: in kernels a function changes the attributes of the function that calls it."""
    return in_kernels(lambda context, builder, *_: change(builder.function.attributes))


# llvmlite's own `add` knows attributes of one word only
@attribute(lambda have: set.add(have, '"prefer-vector-width"="512"'))
def widest_vectors():
    """Use vectors of 512 bits in the function that calls this: LLVM takes vectors of 256 bits on
    processors of Intel that have both. A step of discs takes a tenth less."""


@attribute(lambda have: have.discard("alwaysinline"))
def noinline():
    """Compile the function that has this line once for a kernel, and have others call it: it is long, or
    has several callers. All others become part of their callers.

    Numba compiles a function again for callers whose options differ; so options are the same for all.
    """


def _prefetch(context, builder, signature, arguments):
    byte = ir.IntType(8)
    where = _pointer(context, builder, signature.args[0], *arguments, byte)
    kind = ir.FunctionType(ir.VoidType(), [byte.as_pointer(), NUMBER, NUMBER, NUMBER])
    function = builder.module.declare_intrinsic("llvm.prefetch", [byte.as_pointer()], kind)
    read, second_level, data_cache = NUMBER(0), NUMBER(2), NUMBER(1)
    builder.call(function, [where, read, second_level, data_cache])


@in_kernels(_prefetch)
def prefetch(array, index):
    """Start to load the cache line that holds array[index] (1-D) into the second-level cache.

    It never fails and changes nothing. Beds that do not fit into the caches gain a tenth. The first
    level can wait for few lines at a time, and those that the kernel works on must stay.
    """


def _add_four(context, builder, signature, arguments):
    array, index, *numbers = arguments
    where = _pointer(context, builder, signature.args[0], array, index, FOUR)
    change = ir.Constant(FOUR, ir.Undefined)
    for place, number in enumerate(numbers):
        change = builder.insert_element(change, number, NUMBER(place))
    before = builder.load(where, align=ALIGNED)
    builder.store(builder.fadd(before, change), where, align=ALIGNED)


@in_kernels(_add_four)
def add_four(array, index, a, b, c, d):
    """Add four numbers to array[index] (1-D, float64) and the three after it.

    In kernels it is one move of a vector unit, because a store costs more than a sum.
    """
    for place, number in enumerate((a, b, c, d), int(index)):
        array[place] += number


def _transpose(context, builder, signature, arguments):
    target, k, apart, source, *places = arguments
    kind, *_ = signature.args

    def rows(places):
        for c in range(4):
            place = builder.extract_value(places, c)
            at = _pointer(context, builder, signature.args[3], source, place, FOUR)
            yield builder.load(at, align=ALIGNED)

    def mixed(one, two, places):
        return builder.shuffle_vector(one, two, ir.Constant(ir.VectorType(NUMBER, 4), places))

    a, b, c, d = rows(places[0])
    if len(places) > 1:
        a, b, c, d = map(builder.fsub, rows(places[1]), (a, b, c, d))
    halves = [(mixed(a, b, at), mixed(c, d, at)) for at in ((0, 4, 2, 6), (1, 5, 3, 7))]
    for at in ((0, 1, 4, 5), (2, 3, 6, 7)):
        for half in halves:
            where = _pointer(context, builder, kind, target, k, FOUR)
            builder.store(mixed(*half, at), where, align=ALIGNED)
            k = builder.add(k, apart)


@in_kernels(_transpose)
def transpose(target, k, apart, source, ones):
    """Write the four numbers from each of four places of source on (1-D, float64) to target[k]: the first
    of each side by side, the second of each so many numbers `apart`, and so on.

    In kernels these are moves of a vector unit: of one contact it reads numbers that are together, and
    it computes with one number of several contacts. A step of discs takes a sixth less.
    """
    for c, one in enumerate(map(int, ones)):
        for r in range(4):
            target[int(k) + int(apart) * r + c] = source[one + r]


@in_kernels(_transpose)
def transpose_differences(target, k, apart, source, ones, twos):
    """As `transpose`, of the numbers from the second places on less those from the first on."""
    for c, (one, two) in enumerate(zip(map(int, ones), map(int, twos), strict=True)):
        for r in range(4):
            target[int(k) + int(apart) * r + c] = source[two + r] - source[one + r]


def _whole(context, builder, signature, arguments):
    return _pointer(context, builder, signature.args[0], *arguments, WHOLE)


def _add_one(*given):
    one, builder = WHOLE(1), given[1]
    return builder.add(builder.atomic_rmw("add", _whole(*given), one, "seq_cst"), one)


@in_kernels(_add_one, types.int64)
def add_one(array, index):
    """Add one to array[index] (1-D, int64) before any other thread sees it; returns the sum."""
    array[index] += 1
    return array[index]


@in_kernels(lambda *given: given[1].load_atomic(_whole(*given), "seq_cst", align=8), types.int64)
def load(array, index):
    """array[index] (1-D, int64) as other threads have left it."""
    return array[index]


def _yield_processor(context, builder, *_):
    if hasattr(os, "sched_yield"):
        known, kind = builder.module.globals, ir.FunctionType(NUMBER, [])
        builder.call(
            known.get("sched_yield") or ir.Function(builder.module, kind, "sched_yield"), []
        )


@in_kernels(_yield_processor)
def yield_processor():
    """Let other threads and programs have the processor."""


def barrier(arrivals, size):
    """Wait until all of `size` threads have arrived; arrivals (1,): how often threads did so far.

    A barrier of the operating system takes longer than a short step. Threads spin instead, and
    yield the processor when they wait for long.
    """
    if size > 1:
        number = add_one(arrivals, 0)
        full, spins = (number + size - 1) // size * size, 0
        while load(arrivals, 0) < full:
            spins += 1
            if spins > SPINS:
                yield_processor()
                spins = 0
