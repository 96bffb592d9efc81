"""How much machine code a scene needs."""

import numba
from llvmlite.binding.object_file import ObjectFileRef

from dem.dynamics.integration import advance
from dem.dynamics.world import World
from dem.jit.compilation import OPTIONS


def code_size(world: World) -> int:
    """Bytes of machine code of dem.dynamics.integration.advance for a scene, with all it calls.

    The text section of the object file, with the few hundred bytes that call it from Python. It is
    compiled again, because Numba does not keep object files that it reads from disk.
    """
    like = world, 1.0, 1, 1.0, None  # as dem.dynamics.stepping calls it
    signature = tuple(map(numba.typeof, like))
    fresh = numba.jit(**OPTIONS)(advance.py_func)
    fresh.compile(signature)
    code = fresh.overloads[signature].library._compiled_object
    sections = ObjectFileRef.from_data(code).sections()
    return sum(section.size() for section in sections if section.is_text())
