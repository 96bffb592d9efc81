"""Ask the processor for memory before it is needed: large beds do not fit into its caches."""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def prefetch(typing, array, index):
    """Start to load the cache line that holds array[index] (1-D); never fails, changes nothing."""

    def generate(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        byte = ir.IntType(8).as_pointer()
        where = builder.bitcast(builder.gep(data, [arguments[1]]), byte)
        flag = ir.IntType(32)
        function = builder.module.declare_intrinsic(
            "llvm.prefetch", [byte], ir.FunctionType(ir.VoidType(), [byte, flag, flag, flag])
        )
        read, everywhere, data_cache = flag(0), flag(3), flag(1)
        builder.call(function, [where, read, everywhere, data_cache])
        return context.get_dummy_value()

    return types.none(array, index), generate
