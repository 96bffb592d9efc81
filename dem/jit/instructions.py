"""Instructions of the processor that compilers do not choose by themselves.

Memory is asked for before it is needed, because large beds do not fit into caches. Four numbers are
added in one move of a vector unit, because a store costs more than a sum.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

ALIGNED = 8  # bytes
NUMBER = ir.IntType(32)


def _place(context, builder, signature, arguments, kind):
    """Pointer of a kind to array[index] (1-D), of the first two arguments."""
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    return builder.bitcast(builder.gep(data, [arguments[1]]), kind.as_pointer())


@intrinsic
def prefetch(typing, array, index):
    """Start to load the cache line that holds array[index] (1-D) into the second-level cache; never
    fails, changes nothing.

    The first level can wait for few lines at a time, and those that the kernel works on must stay.
    """

    def generate(context, builder, signature, arguments):
        byte = ir.IntType(8)
        where = _place(context, builder, signature, arguments, byte)
        kind = ir.FunctionType(ir.VoidType(), [byte.as_pointer(), NUMBER, NUMBER, NUMBER])
        function = builder.module.declare_intrinsic("llvm.prefetch", [byte.as_pointer()], kind)
        read, second_level, data_cache = NUMBER(0), NUMBER(2), NUMBER(1)
        builder.call(function, [where, read, second_level, data_cache])
        return context.get_dummy_value()

    return types.none(array, index), generate


def _changing(operation):
    """An intrinsic that changes array[index] (1-D, float64) and the three numbers after it."""

    @intrinsic
    def change_four(typing, array, index, a, b, c, d):
        def generate(context, builder, signature, arguments):
            four = ir.VectorType(ir.DoubleType(), 4)
            where = _place(context, builder, signature, arguments, four)
            change = ir.Constant(four, ir.Undefined)
            for place, number in enumerate(arguments[2:]):
                change = builder.insert_element(change, number, NUMBER(place))
            before = builder.load(where, align=ALIGNED)
            builder.store(operation(builder, before, change), where, align=ALIGNED)
            return context.get_dummy_value()

        return types.none(array, index, a, b, c, d), generate

    return change_four


add_four = _changing(ir.IRBuilder.fadd)
subtract_four = _changing(ir.IRBuilder.fsub)
