"""Named tuples in compiled code: by their address, and back to Python.

Numba hands over a named tuple member by member. A World has some sixty arrays of seven numbers or
more, and each call and each function would take all of them apart. Behind an address only the
members that a function reads are loaded.

The compiler cannot tell whether a store into an array changes what lies behind an address, and
would load it again for every granule. Read members before a loop, or take a `local` copy of a
tuple.

A kernel that Python calls gets the arrays of a tuple as they are in Python, which holds them for as
long as it runs: their references are not counted. Those of what replaces a member are: it lives on
in the tuple that the kernel returns.
"""

import functools

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    box,
    infer_getattr,
    lower_builtin,
    lower_cast,
    lower_getattr_generic,
    lower_setattr_generic,
    register_model,
    type_callable,
    unbox,
)

FEW = 8  # numbers and arrays: a tuple with no more goes by value


class Address(types.Type):
    """Where a named tuple of a type is."""

    def __init__(self, held):
        self.held = held
        super().__init__(f"Address({held})")

    @property
    def instance_class(self):
        return self.held.instance_class


@functools.cache  # which also keeps the types that calls know by number
def handed(kind):
    """The type by which a value of some type is handed over."""
    large = isinstance(kind, types.BaseNamedTuple) and size(kind) > FEW
    return Address(kind) if large else kind


def size(kind):
    """How many numbers and arrays a type has."""
    return sum(map(size, kind.types)) if isinstance(kind, types.BaseTuple) else 1


@register_model(Address)
class _AddressModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        held = manager.lookup(kind.held)
        super().__init__(manager, kind, held.get_value_type().as_pointer())


@infer_getattr
class _Members(AttributeTemplate):
    key = Address

    def generic_resolve(self, kind, name):
        if name in kind.held.fields:
            return handed(kind.held.types[kind.held.fields.index(name)])
        return None


@lower_getattr_generic(Address)
def _member(context, builder, kind, value, name):
    index = kind.held.fields.index(name)
    place, member = cgutils.gep_inbounds(builder, value, 0, index), kind.held.types[index]
    if isinstance(handed(member), Address):
        return place
    return impl_ret_borrowed(context, builder, member, builder.load(place))


@lower_setattr_generic(Address)
def _replace_member(context, builder, signature, arguments, name):
    kind, (address, new) = signature.args[0].held, arguments
    index = kind.fields.index(name)
    place, member = cgutils.gep_inbounds(builder, address, 0, index), kind.types[index]
    if isinstance(signature.args[1], Address):
        new = builder.load(new)
    impl_ret_borrowed(context, builder, member, new)
    if context.enable_nrt:
        context.nrt.decref(builder, member, builder.load(place))
    builder.store(new, place)


@lower_cast(types.BaseNamedTuple, Address)
def _lower_placed(context, builder, kind, target, value):
    return cgutils.alloca_once_value(builder, value)


def local(held):
    """A copy of a named tuple that nothing else can change: its members stay in registers."""
    return held


@type_callable(local)
def _type_local(context):
    return lambda held: held


@lower_builtin(local, Address)
def _lower_local(context, builder, signature, arguments):
    return cgutils.alloca_once_value(builder, builder.load(arguments[0]))


@unbox(Address)
def _unbox_address(kind, value, c):
    place = cgutils.alloca_once(c.builder, c.context.get_value_type(kind.held))
    _unbox_at(place, kind.held, value, c)
    return NativeValue(place)


def _unbox_at(place, kind, value, c):
    """Write a Python value to an address; its type is known, because it has chosen the kernel."""
    if isinstance(kind, types.BaseTuple):
        for k, part in enumerate(kind):
            member = cgutils.gep_inbounds(c.builder, place, 0, k)
            _unbox_at(member, part, c.pyapi.tuple_getitem(value, k), c)
    elif isinstance(kind, types.Array):  # as Numba without counting references
        signature = ir.FunctionType(ir.IntType(32), [c.pyapi.pyobj, c.pyapi.voidptr])
        adapt = cgutils.get_or_insert_function(c.builder.module, signature, "numba_adapt_ndarray")
        c.builder.call(adapt, (value, c.builder.bitcast(place, c.pyapi.voidptr)))
    else:
        c.builder.store(c.unbox(kind, value).value, place)


@box(Address)
def _box_address(kind, place, c):
    """A tuple with the instances of its members' classes, by tuple.__new__.

    Numba calls the class, but a shape checks what it is called with, and a kernel returns it often.
    """
    return _box_at(place, kind.held, c)


def _box_at(place, kind, c):
    if not isinstance(kind, types.BaseTuple):
        return c.box(kind, c.builder.load(place))
    value = c.pyapi.tuple_new(len(kind))
    for k, part in enumerate(kind):
        member = _box_at(cgutils.gep_inbounds(c.builder, place, 0, k), part, c)
        c.pyapi.tuple_setitem(value, k, member)
    if not isinstance(kind, types.BaseNamedTuple):
        return value
    new, cls = (
        c.env_manager.read_const(c.env_manager.add_const(constant))
        for constant in (tuple.__new__, kind.instance_class)
    )
    named = c.pyapi.call_function_objargs(new, (cls, value))
    c.pyapi.decref(value)
    return named
