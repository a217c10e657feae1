"""Message classes, made from definitions, with the interface of rclpy's."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING, Any, Callable, ClassVar, TypeAlias, TypeVar, cast
from teleopctl.interfaces.blocks import (
    BLOCK_CODES,
    ITEM_SIZES,
    empty,
    equal,
    is_array,
    new_array,
    to_array,
    to_own_numpy,
)
from teleopctl.interfaces.convert import converter
from teleopctl.interfaces.definition import (
    FLOATS,
    INTEGER_RANGES,
    PLACEHOLDER,
    STRINGS,
    Constant,
    Definition,
    Field,
    FieldType,
    Shape,
)
from teleopctl.interfaces.typenames import module_name, split

if TYPE_CHECKING:
    from types import MemberDescriptorType

    from teleopctl.interfaces.slot_types import AbstractType

ClassLookup = Callable[[str], type["Message"]]
# Type variables of publishers, subscriptions, clients and services.
MessageT = TypeVar("MessageT", bound="Message")
RequestT = TypeVar("RequestT", bound="Message")
ResponseT = TypeVar("ResponseT", bound="Message")
Maker: TypeAlias = tuple[Callable[[Any, Any], None], Callable[[], Any]]
"""Functions for the default of a field: the first stores a value, the second makes the default."""


_DEFAULT = "__DEFAULT"


class _SlotTypes:
    """Descriptor that returns the slot types of a class's fields, made at each access."""

    def __get__(self, _: Message | None, owner: type[Message]) -> tuple[AbstractType, ...]:
        from teleopctl.interfaces.slot_types import slot_types

        return slot_types(owner.__definition__)


class MessageClass(type):
    """Metaclass of messages: constants are read-only, defaults readable as ``FIELD__DEFAULT``.

    The default value of a field ``speed`` is ``SPEED__DEFAULT``, a new value at each access.
    """

    def __setattr__(cls, name: str, value: object) -> None:
        definition = cls.__dict__.get("__definition__")
        constants = [each.name for each in definition.constants] if definition else []
        if name in constants or name.endswith(_DEFAULT):
            raise AttributeError(f"{name} of {cls.__name__} cannot be changed")
        super().__setattr__(name, value)

    def __getattr__(cls, name: str) -> Any:  # Any: of the field's type
        if name == f"_Metaclass_{cls.__name__}__constants":  # ros2cli reads constants by this name
            constants = cls.__dict__["__definition__"].constants
            return {constant.name: constant_value(constant) for constant in constants}
        if name.endswith(_DEFAULT) and (definition := cls.__dict__.get("__definition__")):
            for field in definition.fields:
                if field.default is not None and field.attribute.upper() + _DEFAULT == name:
                    return getattr(cls(), field.attribute)
        raise AttributeError(f"type object {cls.__name__!r} has no attribute {name!r}")


class Message(metaclass=MessageClass):
    """Base class of all messages; assigned field values are checked and converted.

    Each field has a slot named ``_field`` and a property named as the field. Assigned values are
    checked at once. The slot stores a block of numbers as assigned, often as a memoryview of
    received bytes; reading the property converts it to the type of ROS 2's messages (see
    ``blocks``).

    Attributes:
        TYPE_NAME: Full name of the type, ``package/kind/Name``.
        SLOT_TYPES: Types of the fields in order, with the API of ``rosidl_parser.definition``.
        __definition__: Definition from which the class was made.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment] # messages are mutable

    TYPE_NAME: ClassVar[str]
    SLOT_TYPES = _SlotTypes()
    __definition__: ClassVar[Definition]
    __makers__: ClassVar[dict[str, Maker]]
    _fields_and_field_types: ClassVar[dict[str, str]]

    def __init__(self, **fields: object) -> None:
        for name, (put, make) in self.__makers__.items():
            if name not in fields:
                put(self, make())
        for name, value in fields.items():
            if name in self.__makers__:
                setattr(self, name, value)
            elif name != "check_fields":  # argument of rclpy's classes; these always check
                unknown = [each for each in fields if each not in self.__makers__]
                from teleopctl.interfaces.field_errors import unknown_fields_error

                raise unknown_fields_error(self.TYPE_NAME, unknown, list(self.__makers__))

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return a dictionary from field names, in order, to types in ROS 2's spelling."""
        return dict(cls._fields_and_field_types)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return all(
            equal(getattr(self, f"_{name}"), getattr(other, f"_{name}"))
            for name in self._fields_and_field_types
        )

    def __repr__(self) -> str:
        package, kind, name = split(self.TYPE_NAME)
        fields = (
            f"{field.attribute}={_field_repr(getattr(self, field.attribute))}"
            for field in self.__definition__.fields
        )
        return f"{package}.{kind}.{name}({', '.join(fields)})"


def make_class(definition: Definition, lookup: ClassLookup) -> type[Message]:
    """Return a new message class made from a `Definition`.

    Args:
        definition: Definition of the type.
        lookup: Function that returns the class of a nested type by its full name; called when a
            value of the type is first needed.
    """
    fields = definition.fields
    namespace: dict[str, Any] = {
        "__slots__": tuple(f"_{field.attribute}" for field in fields),
        "__module__": module_name(definition.type_name),
        "__doc__": f"Message class {split(definition.type_name)[2]!r}.",
        "TYPE_NAME": definition.type_name,
        "__definition__": definition,
        "__makers__": {},
        "_fields_and_field_types": {field.attribute: field.type.idl() for field in fields},
    }
    namespace.update((c.name, constant_value(c)) for c in definition.constants)
    if not fields:
        namespace[f"_{PLACEHOLDER}"] = 0
    name = split(definition.type_name)[2]
    cls: type[Message] = cast("type[Message]", MessageClass(name, (Message,), namespace))
    check = _size_check(definition, lookup)
    for field in fields:
        slot: Any = cls.__dict__[f"_{field.attribute}"]
        setattr(cls, field.attribute, _property(definition.type_name, field, slot, lookup))
        cls.__makers__[field.attribute] = (slot.__set__, _default(field, lookup, check))
    return cls


# Any: the type depends on the field.
def stored(message: Message, field: Field) -> Any:
    """Return the raw value in the slot of a field, without conversion."""
    return getattr(message, f"_{field.attribute}")


def _property(
    type_name: str, field: Field, slot: MemberDescriptorType, lookup: ClassLookup
) -> property:
    put = slot.__set__
    kind = field.type
    convert = converter(kind, lookup)

    def set_value(self: Message, value: object) -> None:
        try:
            put(self, convert(value))
        except (TypeError, ValueError) as error:
            from teleopctl.interfaces.field_errors import field_error

            raise field_error(type_name, field, error) from None

    return property(_getter(kind, slot), set_value, doc=f"Field {field.attribute!r}: {kind}.")


def _getter(kind: FieldType, slot: MemberDescriptorType) -> Callable[[Any], Any]:
    get, put = slot.__get__, slot.__set__
    if kind.shape is Shape.SINGLE or kind.base not in BLOCK_CODES:
        return get
    if not kind.is_numeric:

        def get_list(self: Message) -> Any:
            value = get(self)
            if isinstance(value, memoryview):
                value = value.tolist()
                put(self, value)
            return value

        return get_list

    if kind.shape is Shape.ARRAY:

        def get_numpy(self: Message) -> Any:
            value = get(self)
            if isinstance(value, memoryview) or is_array(value):
                value = to_own_numpy(kind.base, value)
                put(self, value)
            return value

        return get_numpy

    code = BLOCK_CODES[kind.base]

    def get_array(self: Message) -> Any:
        value = get(self)
        if not is_array(value):
            value = to_array(code, value)
            put(self, value)
        return value

    return get_array


def _size_check(definition: Definition, lookup: ClassLookup) -> Callable[[], None]:
    """Return a function that raises TeleopctlError if a type is too large; it checks only once."""
    is_checked = False

    def check() -> None:
        nonlocal is_checked
        if not is_checked:
            from teleopctl.interfaces.cdr.layout import Layout

            own = definition.type_name
            Layout(lambda n: definition if n == own else lookup(n).__definition__).check(own)
            is_checked = True

    return check


def _default(field: Field, lookup: ClassLookup, check: Callable[[], None]) -> Callable[[], Any]:
    kind = field.type
    convert = converter(kind, lookup)
    if kind.shape is Shape.SINGLE:
        if kind.is_nested:

            def nested() -> Any:
                check()
                return lookup(kind.base)()

            return nested
        value = convert(_zero(kind) if field.default is None else field.default)
        return lambda: value
    if field.default is not None:
        return lambda: convert(list(field.default))  # type: ignore[call-overload]
    if kind.is_numeric:
        if kind.shape is not Shape.ARRAY:
            none = empty(kind.base)
            return lambda: none
        return _zeros(BLOCK_CODES[kind.base], kind.capacity, check)
    if kind.shape is not Shape.ARRAY:
        return list

    def several() -> Any:
        check()
        if kind.is_nested:
            return [lookup(kind.base)() for _ in range(kind.capacity)]
        return [_zero(kind)] * kind.capacity

    return several


def _zeros(code: str, count: int, check: Callable[[], None]) -> Callable[[], Any]:
    zeros = b""

    def make() -> Any:
        nonlocal zeros
        if not zeros:
            check()
            zeros = bytes(count * ITEM_SIZES[code])
        return new_array(code, zeros)

    return make


def _zero(kind: FieldType) -> object:
    if kind.base in INTEGER_RANGES:
        return 0
    if kind.base in FLOATS:
        return 0.0
    if kind.base in STRINGS:
        return ""
    return False if kind.base == "bool" else b"\0"


def constant_value(constant: Constant) -> object:
    """Return the Python value of a constant; a ``byte`` is bytes of length one."""
    if constant.base == "byte" and isinstance(constant.value, int):
        return bytes((constant.value,))
    return constant.value


def _field_repr(value: object) -> str:
    if is_array(value):
        return repr(value.tolist())
    return repr(value)
