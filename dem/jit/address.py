"""Named tuples in compiled code: by their address, and back to Python.

Numba hands over a named tuple member by member. A World has some sixty arrays of seven numbers or
more, and each call and each function would take all of them apart. Behind an address only the
members that a function reads are loaded.

The compiler cannot tell whether a store into an array changes what lies behind an address, and
would load it again for every granule. Read members before a loop, or take a `local` copy of a
tuple.

A member of what is `changeable` can be replaced, and only then its references are counted: to
count those of a whole World takes two thousand instructions.
"""

from numba.core import cgutils, types
from numba.core.boxing import box_tuple
from numba.core.datamodel import models
from numba.core.imputils import impl_ret_borrowed, impl_ret_new_ref
from numba.core.pythonapi import _boxers
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    lower_builtin,
    lower_cast,
    lower_getattr_generic,
    lower_setattr_generic,
    register_model,
    type_callable,
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
    """Of what is `changeable` only: other addresses do not count references."""
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


def by_address(held):
    """The address of a named tuple, for as long as the caller runs; what is not one goes as it
    is."""
    return held


@lower_builtin(by_address, types.Any)
def _lower_by_address(context, builder, signature, arguments):
    if signature.args[0] != signature.return_type:
        return cgutils.alloca_once_value(builder, arguments[0])
    return impl_ret_borrowed(context, builder, signature.return_type, arguments[0])


def another(held):
    """The address of a copy of a named tuple, whose members can be replaced until it is `given`."""
    return held


@lower_builtin(another, types.Any)
def _lower_another(context, builder, signature, arguments):
    value = arguments[0]
    if isinstance(signature.args[0], Address):
        value = builder.load(value)
    value = impl_ret_borrowed(context, builder, signature.return_type.held, value)
    return cgutils.alloca_once_value(builder, value)


def changeable(held):
    """The address of `another` named tuple, or that of the one itself."""
    return held


@lower_builtin(changeable, types.Any)
def _lower_changeable(context, builder, signature, arguments):
    if isinstance(signature.args[0], Address):
        return arguments[0]
    return _lower_another(context, builder, signature, arguments)


for _function in by_address, another, changeable:
    type_callable(_function)(lambda context: handed)


def given(copy):
    """A named tuple by value, at whose address there is then nothing."""
    return copy


@type_callable(given)
def _type_given(context):
    return lambda copy: copy.held


@lower_builtin(given, Address)
def _lower_given(context, builder, signature, arguments):
    value = builder.load(arguments[0])
    return impl_ret_new_ref(context, builder, signature.return_type, value)


def as_before(changed, held):
    """What was made `changeable`, by value if it was so before."""
    return changed


@type_callable(as_before)
def _type_as_before(context):
    return lambda changed, held: held


@lower_builtin(as_before, Address, types.Any)
def _lower_as_before(context, builder, signature, arguments):
    if isinstance(signature.return_type, Address):
        return arguments[0]
    return _lower_given(context, builder, signature, arguments)


def local(held):
    """A copy of a named tuple that nothing else can change: its members stay in registers."""
    return held


@type_callable(local)
def _type_local(context):
    return lambda held: held


@lower_builtin(local, types.Any)
def _lower_local(context, builder, signature, arguments):
    if isinstance(signature.args[0], Address):
        return cgutils.alloca_once_value(builder, builder.load(arguments[0]))
    return impl_ret_borrowed(context, builder, signature.return_type, arguments[0])


def _box_named_tuple(typ, value, c):
    """A native named tuple as an instance of its class, by tuple.__new__.

    Numba calls the class, but a shape checks what it is called with, and a kernel returns it often.
    """
    constants = [
        c.env_manager.read_const(c.env_manager.add_const(constant))
        for constant in (tuple.__new__, typ.instance_class)
    ]
    for constant in constants:
        c.pyapi.incref(constant)
    parts = [*constants, box_tuple(typ, value, c)]
    named = c.pyapi.call_function_objargs(parts[0], parts[1:])
    for part in parts:
        c.pyapi.decref(part)
    return named


_boxers.functions |= dict.fromkeys((types.NamedTuple, types.NamedUniTuple), _box_named_tuple)
