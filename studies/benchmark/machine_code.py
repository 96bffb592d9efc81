"""How much machine code a scene needs, and how wide its vectors are."""

from typing import NamedTuple

import numba
from llvmlite.binding.object_file import ObjectFileRef

from dem.dynamics.integration import advance
from dem.dynamics.world import World
from dem.jit.compilation import OPTIONS
from dem.jit.compilers import KernelCompiler

WIDEST = {"zmm": 512, "ymm": 256}  # bits of the registers of x86


class MachineCode(NamedTuple):
    """Size in bytes, and the width in bits of the widest vector registers that it names."""

    size: int
    vector_bits: int


def machine_code(world: World) -> MachineCode:
    """Machine code of dem.dynamics.integration.advance for a scene, with all it calls.

    Its size is that of the text section of the object file, with the few hundred bytes that call it
    from Python. It is compiled again, because Numba does not keep object files that it reads from disk.
    """
    like = world, 0.5, 1.0, 1, 1.0, None  # as dem.dynamics.stepping calls it
    signature = tuple(map(numba.typeof, like))
    fresh = numba.jit(pipeline_class=KernelCompiler, **OPTIONS)(advance.py_func)
    fresh.compile(signature)
    code = fresh.overloads[signature].library._compiled_object
    sections = ObjectFileRef.from_data(code).sections()
    assembly = fresh.inspect_asm(signature)
    return MachineCode(
        sum(section.size() for section in sections if section.is_text()),
        next((bits for name, bits in WIDEST.items() if name in assembly), 128),
    )
