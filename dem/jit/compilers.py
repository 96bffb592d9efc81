"""Compile kernels with the widest vectors, and their parts in less time than Numba takes.

Numba makes a library of every function: it optimises it, assembles it, and does both again in every
library that calls it. A part is only lowered and simplified. The kernels that contain it, which
Python calls, are optimised and assembled once.
"""

from operator import is_, is_not

from llvmlite import binding
from numba import _dynfunc
from numba.core import ir, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import GuardException, get_definition, guard
from numba.core.typed_passes import NativeLowering
from numba.core.untyped_passes import DeadBranchPrune

from dem.jit.address import local

# LLVM uses vectors of 256 bits on processors of Intel that have some of 512. This attribute changes
# that; other processors ignore it.
WIDE_VECTORS = '"prefer-vector-width"="512"'


class KernelLibrary(JITCodeLibrary):
    """Code that uses the widest vectors that the processor has.

    What Numba brings itself, such as np.zeros, is optimised before, without them.
    """

    def add_ir_module(self, module):
        for function in module.functions:
            # llvmlite's own `add` knows attributes of one word only
            set.add(function.attributes, WIDE_VECTORS)
        super().add_ir_module(module)


class PartLibrary(KernelLibrary):
    """Code of a part, with the code of the parts that it calls.

    An inlined function is optimised before it is inlined, as by Numba: which sums and products the
    processor rounds together depends on it, and so does the last bit of a result.
    """

    inlined = False

    def finalize(self):
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        if self.inlined:
            self._optimize_final_module()
        self._finalize_dynamic_globals()
        self._finalized = True


class RolledLibrary(PartLibrary):
    """Code of an inlined loop, optimised with the loop left as it is.

    Only the kernel knows that the arrays of the loop do not overlap, so only there it becomes
    vector code; a loop that is unrolled before stays scalar.
    """

    def _optimize_final_module(self):
        for prepares in True, False:
            options = binding.create_pipeline_tuning_options(speed_level=3)
            options.loop_vectorization, options.slp_vectorization = True, False
            options.loop_unrolling = False
            builder = binding.create_pass_builder(self._codegen._tm, options)
            passes = builder.getModulePassManager()
            if prepares:  # as Numba does
                passes.add_loop_rotate_pass()
                passes.add_instruction_combine_pass()
                passes.add_jump_threading_pass()
            passes.run(self._final_module, builder)


def type_of(state, variable):
    """Type of an argument, of a member of one, or of its address; raises GuardException for others."""
    definition = get_definition(state.func_ir, variable)
    if isinstance(definition, ir.Arg):
        return state.args[definition.index]
    operation = getattr(definition, "op", None)
    if operation == "getattr":
        kind = type_of(state, definition.value)
        kind = getattr(kind, "held", kind)
        if isinstance(kind, types.BaseNamedTuple):
            return kind.types[kind.fields.index(definition.attr)]
    elif operation == "call":
        function = get_definition(state.func_ir, definition.func)
        if getattr(function, "value", None) is local:
            return type_of(state, definition.args[0])
    elif operation == "static_getitem":  # of `a, b, c, d = ...`
        values = get_definition(state.func_ir, definition.value)
        if getattr(values, "op", None) == "exhaust_iter":
            values = get_definition(state.func_ir, values.value)
        if getattr(values, "op", None) == "build_tuple":
            return type_of(state, values.items[definition.index])
    raise GuardException


@register_pass(mutates_CFG=False, analysis_only=False)
class DecideAbsence(FunctionPass):
    """Decide `member is None` by the types of the arguments, so that only one branch is compiled.

    Numba decides it itself where an argument is None, but not for members of an argument.
    """

    _name = "decide_absence"

    def __init__(self):
        super().__init__()

    def run_pass(self, state):
        for block in state.func_ir.blocks.values():
            for assignment in block.find_insts(ir.Assign):
                test = assignment.value
                if getattr(test, "op", None) != "binop" or test.fn not in (is_, is_not):
                    continue
                kind = guard(type_of, state, test.lhs)
                other = guard(get_definition, state.func_ir, test.rhs)
                if kind is None or not isinstance(other, ir.Const) or other.value is not None:
                    continue
                assignment.value = ir.Const(test.fn(kind, types.none), assignment.loc)
                definitions = state.func_ir._definitions[assignment.target.name]
                definitions[definitions.index(test)] = assignment.value
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerKernel(NativeLowering):
    """Lower a function into a KernelLibrary."""

    _name = "lower_kernel"
    library = KernelLibrary

    def run_pass(self, state):
        state.library = self.new_library(state)
        return super().run_pass(state)

    def new_library(self, state):
        library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        library.enable_object_caching()
        return library


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerPart(LowerKernel):
    """Lower a function into a PartLibrary. Python cannot call it: it has no address."""

    _name = "lower_part"
    library = PartLibrary

    def new_library(self, state):
        library = super().new_library(state)
        library.inlined = state.flags.forceinline
        return library

    def run_pass(self, state):
        state.flags.no_compile = True
        super().run_pass(state)
        library, fndesc = state.library, state.cr.fndesc
        key = _dynfunc.make_function(
            fndesc.lookup_module(), fndesc.qualname, "a part", 0, state.cr.env, (library,)
        )
        state.targetctx.insert_user_function(key, fndesc, [library])
        state.cr = state.cr._replace(cfunc=key)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerRolled(LowerPart):
    """The same into a RolledLibrary."""

    _name = "lower_rolled"
    library = RolledLibrary


class KernelCompiler(Compiler):
    """Numba's compiler, with DecideAbsence, and with LowerKernel in place of its own."""

    lower = LowerKernel

    def define_pipelines(self):
        (manager,) = super().define_pipelines()
        names = [name for name, _ in manager.passes]
        manager.passes = [
            (self.lower if part is NativeLowering else part, words)
            for part, words in manager.passes
        ]
        manager.passes.insert(names.index(DeadBranchPrune), (DecideAbsence, "decide absence"))
        manager._finalized = False
        manager.finalize()
        return [manager]


class PartCompiler(KernelCompiler):
    """The same, up to LowerPart."""

    lower = LowerPart


class RolledCompiler(PartCompiler):
    """The same, up to LowerRolled."""

    lower = LowerRolled
