"""Add four numbers to four others in one move of a vector unit: a store costs more than a sum."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

ALIGNED = 8  # bytes


def _changing(operation):
    """An intrinsic that changes array[index] (1-D, float64) and the three numbers after it."""

    @intrinsic
    def change_four(typing, array, index, a, b, c, d):
        def generate(context, builder, signature, arguments):
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            four = ir.VectorType(ir.DoubleType(), 4)
            where = builder.bitcast(builder.gep(data, [arguments[1]]), four.as_pointer())
            change = ir.Constant(four, ir.Undefined)
            for place, number in enumerate(arguments[2:]):
                change = builder.insert_element(change, number, ir.IntType(32)(place))
            before = builder.load(where, align=ALIGNED)
            builder.store(operation(builder, before, change), where, align=ALIGNED)
            return context.get_dummy_value()

        return types.none(array, index, a, b, c, d), generate

    return change_four


add_four = _changing(ir.IRBuilder.fadd)
subtract_four = _changing(ir.IRBuilder.fsub)
