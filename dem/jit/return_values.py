"""Make the results of compiled code without running Python, so that no signal interrupts it.

Numba calls the class of a named tuple, and unpickles that class and the type of every array, in
Python. There Python may answer Ctrl-C, SIGTERM or an alarm with an exception. Numba does not check
for it and uses an object that was never made: a segmentation fault. Here classes and types are
constants of the machine code, and tuple.__new__ makes the tuples. Python answers a signal after the
call, and calls cost less.
"""

from unittest.mock import patch

from numba.core import types
from numba.core.boxing import box_array, box_tuple
from numba.core.pythonapi import _boxers


def constant(held, c):
    """A Python object that the machine code keeps; a new reference."""
    found = c.env_manager.read_const(c.env_manager.add_const(held))
    c.pyapi.incref(found)
    return found


def box_named_tuple(typ, value, c):
    """A native structure as an instance of its class, without calling the class."""
    new, kind, plain = (
        constant(tuple.__new__, c),
        constant(typ.instance_class, c),
        box_tuple(typ, value, c),
    )
    made = c.pyapi.call_function_objargs(new, (kind, plain))
    for each in (new, kind, plain):
        c.pyapi.decref(each)
    return made


def box_any_array(typ, value, c):
    """A native array as one of numpy, its type a constant instead of a pickle."""
    with patch.multiple(
        c.pyapi, serialize_object=lambda held: held, unserialize=lambda held: constant(held, c)
    ):
        return box_array(typ, value, c)


_boxers.functions |= dict.fromkeys((types.NamedTuple, types.NamedUniTuple), box_named_tuple)
_boxers.functions[types.Array] = box_any_array
