"""Ask the processor for memory before it is needed: large beds do not fit into its caches."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from dem.jit.compilation import INLINED

LINE = 8  # numbers to a cache line


@intrinsic
def prefetch(typing, array, index):
    """Start to load the cache line that holds array[index] (1-D) into the second-level cache; never
    fails, changes nothing.

    The first level can wait for few lines at a time, and those that the kernel works on must stay.
    """

    def generate(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        byte = ir.IntType(8).as_pointer()
        where = builder.bitcast(builder.gep(data, [arguments[1]]), byte)
        flag = ir.IntType(32)
        function = builder.module.declare_intrinsic(
            "llvm.prefetch", [byte], ir.FunctionType(ir.VoidType(), [byte, flag, flag, flag])
        )
        read, second_level, data_cache = flag(0), flag(2), flag(1)
        builder.call(function, [where, read, second_level, data_cache])
        return context.get_dummy_value()

    return types.none(array, index), generate


def fetch_share(tree, low, high, count):
    """Prefetch entries low to high, out of `count`, of every array in a tree of tuples."""


@overload(fetch_share, jit_options=INLINED)
def _fetch_share(tree, low, high, count):
    if isinstance(tree, types.Array):
        return _fetch_entries
    if not isinstance(tree, types.BaseTuple) or len(tree) == 0:
        return lambda tree, low, high, count: None

    def each(tree, low, high, count):
        fetch_share(tree[0], low, high, count)
        fetch_share(tree[1:], low, high, count)

    return each


def _fetch_entries(tree, low, high, count):
    numbers = tree.reshape(-1)
    for k in range(low * numbers.size // count, high * numbers.size // count, LINE):
        prefetch(numbers, k)
