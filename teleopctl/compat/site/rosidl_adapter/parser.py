"""``rosidl_adapter.parser``. Parser of definitions of messages, services and actions.

Comments are not kept: the ``annotations`` are empty.
"""

import re
from pathlib import Path
from typing import Any

from teleopctl.errors import InvalidDefinitionError
from teleopctl.interfaces import Definition, FieldType, Shape, parse, split_sections

__all__ = [
    "ActionSpecification",
    "BaseType",
    "Constant",
    "Field",
    "InvalidActionSpecification",
    "InvalidFieldDefinition",
    "InvalidResourceName",
    "InvalidServiceSpecification",
    "InvalidSpecification",
    "InvalidValue",
    "MessageSpecification",
    "ServiceSpecification",
    "Type",
    "UnknownMessageType",
    "is_valid_constant_name",
    "is_valid_field_name",
    "is_valid_message_name",
    "is_valid_package_name",
    "parse_action_file",
    "parse_action_string",
    "parse_message_file",
    "parse_message_string",
    "parse_service_file",
    "parse_service_string",
]

PACKAGE_NAME_MESSAGE_TYPE_SEPARATOR = "/"
COMMENT_DELIMITER = "#"
CONSTANT_SEPARATOR = "="
ARRAY_UPPER_BOUND_TOKEN = "<="  # noqa: S105 -- no password, below neither
STRING_UPPER_BOUND_TOKEN = "<="  # noqa: S105
SERVICE_REQUEST_RESPONSE_SEPARATOR = "---"
SERVICE_REQUEST_MESSAGE_SUFFIX = "_Request"
SERVICE_RESPONSE_MESSAGE_SUFFIX = "_Response"
SERVICE_EVENT_MESSAGE_SUFFIX = "_Event"
ACTION_REQUEST_RESPONSE_SEPARATOR = "---"
ACTION_GOAL_SUFFIX = "_Goal"
ACTION_RESULT_SUFFIX = "_Result"
ACTION_FEEDBACK_SUFFIX = "_Feedback"

PRIMITIVE_TYPES = [
    *("bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16"),
    *("int32", "uint32", "int64", "uint64", "string", "wstring", "duration", "time"),
]

VALID_PACKAGE_NAME_PATTERN = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
VALID_FIELD_NAME_PATTERN = VALID_PACKAGE_NAME_PATTERN
VALID_MESSAGE_NAME_PATTERN = re.compile(r"[A-Z][A-Za-z0-9]*")
VALID_CONSTANT_NAME_PATTERN = re.compile(r"[A-Z]([A-Z0-9_]?[A-Z0-9]+)*")


class InvalidSpecification(Exception):
    """Raised when a definition is invalid."""


class InvalidActionSpecification(InvalidSpecification):
    """Raised when a definition of an action is invalid."""


class InvalidServiceSpecification(InvalidSpecification):
    """Raised when a definition of a service is invalid."""


class InvalidResourceName(InvalidSpecification):
    """Raised when a name is invalid."""


class InvalidFieldDefinition(InvalidSpecification):
    """Raised when a line is neither a field nor a constant."""


class UnknownMessageType(InvalidSpecification):
    """Raised when a field has an unknown type."""


class InvalidValue(Exception):
    """Raised when a value does not fit its type."""


def is_valid_package_name(name: str) -> bool:
    """Return whether a name may be that of a package."""
    return VALID_PACKAGE_NAME_PATTERN.fullmatch(name) is not None


def is_valid_field_name(name: str) -> bool:
    """Return whether a name may be that of a field."""
    return VALID_FIELD_NAME_PATTERN.fullmatch(name) is not None


def is_valid_message_name(name: str) -> bool:
    """Return whether a name may be that of a message, or of a part of a service or an action."""
    plain = re.sub("_(Request|Response|Goal|Result|Feedback)$", "", name.removeprefix("Sample_"))
    return VALID_MESSAGE_NAME_PATTERN.fullmatch(plain) is not None


def is_valid_constant_name(name: str) -> bool:
    """Return whether a name may be that of a constant."""
    return VALID_CONSTANT_NAME_PATTERN.fullmatch(name) is not None


class BaseType:
    """Type of a single value.

    Args:
        type_string: Primitive type such as ``string<=10``, or message type.
        context_package_name: Package of a message type without one.

    Raises:
        InvalidResourceName: The text is no type.

    Attributes:
        pkg_name: Package of a message type; None for a primitive type.
        type: Name of the message type or of the primitive type.
        string_upper_bound: Bound of a string; None for none.
    """

    def __init__(self, type_string: str, context_package_name: str | None = None) -> None:
        self._set(_type_of(type_string, context_package_name))

    def _set(self, kind: FieldType) -> None:
        parts = kind.base.split("/")
        self.pkg_name = parts[0] if len(parts) > 1 else None
        self.type = parts[-1]
        self.string_upper_bound = kind.string_capacity or None

    def is_primitive_type(self) -> bool:
        """Return whether values are no messages."""
        return self.pkg_name is None

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and str(self) == str(other)

    def __hash__(self) -> int:
        return hash(str(self))

    def __str__(self) -> str:
        if self.pkg_name is not None:
            return f"{self.pkg_name}/{self.type}"
        bound = self.string_upper_bound
        return f"{self.type}{STRING_UPPER_BOUND_TOKEN}{bound}" if bound else self.type


class Type(BaseType):
    """Type of a field.

    Attributes:
        is_array: Whether the field is an array or a sequence.
        array_size: Length of the array or bound of the sequence; None for none.
        is_upper_bound: Whether `array_size` is a bound.
    """

    def _set(self, kind: FieldType) -> None:
        super()._set(kind)
        self.is_array = kind.shape is not Shape.SINGLE
        self.array_size = kind.capacity or None
        self.is_upper_bound = kind.shape is Shape.BOUNDED

    def is_dynamic_array(self) -> bool:
        """Return whether the field is a sequence."""
        return self.is_array and (self.array_size is None or self.is_upper_bound)

    def is_fixed_size_array(self) -> bool:
        """Return whether the field is an array of a fixed length."""
        return self.is_array and self.array_size is not None and not self.is_upper_bound

    def __str__(self) -> str:
        if not self.is_array:
            return super().__str__()
        bound = ARRAY_UPPER_BOUND_TOKEN if self.is_upper_bound else ""
        return f"{super().__str__()}[{bound}{self.array_size or ''}]"


def _type_of(text: str, package: str | None) -> FieldType:
    base = re.split(r"[\[<]", text, maxsplit=1)[0]
    if package is None and base not in PRIMITIVE_TYPES and "/" not in base:
        raise InvalidResourceName(text)
    if base in ("duration", "time"):
        return FieldType(base)
    try:
        definition = parse(f"{text} value\n", "a_package/msg/A", package or "a_package")
    except InvalidDefinitionError as error:
        raise InvalidResourceName(error.message) from error
    if len(definition.fields) != 1:
        raise InvalidResourceName(text)
    return definition.fields[0].type


class Constant:
    """Constant of a message: type, name and value."""

    # Any, here and below: a value of the constant's or the field's type, or its text.
    def __init__(self, primitive_type: str, name: str, value_string: str) -> None:
        if primitive_type not in PRIMITIVE_TYPES:
            raise TypeError(f"the constant type '{primitive_type}' must be a primitive type")
        if not is_valid_constant_name(name):
            raise NameError(f"'{name}' is an invalid constant name")
        (made,) = _parse(f"{primitive_type} {name}={value_string}\n", "a_package", "A").constants
        self.type, self.name, self.value = primitive_type, name, made.value
        self.annotations: dict[str, Any] = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Constant) and str(self) == str(other)

    __hash__ = None  # type: ignore[assignment]  # mutable

    def __str__(self) -> str:
        is_text = self.type in ("string", "wstring")
        return f"{self.type} {self.name}={repr(self.value) if is_text else self.value}"


class Field:
    """Field of a message: type, name, default value or None."""

    def __init__(self, type_: Type, name: str, default_value_string: str | None = None) -> None:
        if not isinstance(type_, Type):
            raise TypeError(f"the field type '{type_}' must be a 'Type' instance")
        if not is_valid_field_name(name):
            raise NameError(f"'{name}' is an invalid field name")
        self.type, self.name, self.default_value = type_, name, None
        if default_value_string is not None:
            text = f"{type_} {name} {default_value_string}\n"
            self.default_value = _parse(text, "a_package", "A").fields[0].default
        self.annotations: dict[str, Any] = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Field) and str(self) == str(other)

    __hash__ = None  # type: ignore[assignment]  # mutable

    def __str__(self) -> str:
        if self.default_value is None:
            return f"{self.type} {self.name}"
        value = self.default_value
        is_text = str(self.type).startswith(("string", "wstring")) and not self.type.is_array
        return f"{self.type} {self.name} {repr(value) if is_text else value}"


class MessageSpecification:
    """Definition of a message: fields and constants."""

    def __init__(
        self, pkg_name: str, msg_name: str, fields: list[Field], constants: list[Constant]
    ) -> None:
        self.base_type = BaseType(f"{pkg_name}/{msg_name}")
        self.msg_name = msg_name
        self.fields = list(fields)
        self.constants = list(constants)
        self.annotations: dict[str, Any] = {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MessageSpecification) and str(self) == str(other)

    __hash__ = None  # type: ignore[assignment]  # mutable

    def __str__(self) -> str:
        return "\n".join(map(str, (f"# {self.base_type}", *self.constants, *self.fields)))


class ServiceSpecification:
    """Definition of a service: request and response."""

    def __init__(
        self,
        pkg_name: str,
        srv_name: str,
        request: MessageSpecification,
        response: MessageSpecification,
    ) -> None:
        self.pkg_name, self.srv_name = pkg_name, srv_name
        self.request, self.response = request, response

    def __str__(self) -> str:
        return "\n".join(
            map(str, (self.request, SERVICE_REQUEST_RESPONSE_SEPARATOR, self.response))
        )


class ActionSpecification:
    """Definition of an action: goal, result and feedback."""

    def __init__(
        self,
        pkg_name: str,
        action_name: str,
        goal: MessageSpecification,
        result: MessageSpecification,
        feedback: MessageSpecification,
    ) -> None:
        self.pkg_name, self.action_name = pkg_name, action_name
        self.goal, self.result, self.feedback = goal, result, feedback


def parse_message_file(pkg_name: str, interface_filename: str) -> MessageSpecification:
    """Return the definition in a ``.msg`` file."""
    path = Path(interface_filename)
    return parse_message_string(pkg_name, path.stem, path.read_text(encoding="utf-8"))


def parse_message_string(pkg_name: str, msg_name: str, message_string: str) -> MessageSpecification:
    """Return the definition in a text.

    Raises:
        InvalidFieldDefinition: A line is neither a field nor a constant, or a name, type or value
            is invalid.
    """
    return _specification(_parse(message_string, pkg_name, msg_name), pkg_name, msg_name)


def parse_service_file(pkg_name: str, interface_filename: str) -> ServiceSpecification:
    """Return the definition in a ``.srv`` file."""
    path = Path(interface_filename)
    return parse_service_string(pkg_name, path.stem, path.read_text(encoding="utf-8"))


def parse_service_string(pkg_name: str, srv_name: str, message_string: str) -> ServiceSpecification:
    """Return the definition of a service in a text.

    Raises:
        InvalidServiceSpecification: The text has not two parts.
        InvalidFieldDefinition: A line is neither a field nor a constant.
    """
    try:
        sections = split_sections(message_string, "srv", f"{pkg_name}/{srv_name}")
    except InvalidDefinitionError as error:
        raise InvalidServiceSpecification(error.message) from error
    request, response = (
        parse_message_string(pkg_name, srv_name + suffix, text)
        for suffix, (text, _) in zip(
            (SERVICE_REQUEST_MESSAGE_SUFFIX, SERVICE_RESPONSE_MESSAGE_SUFFIX), sections, strict=True
        )
    )
    return ServiceSpecification(pkg_name, srv_name, request, response)


def parse_action_file(pkg_name: str, interface_filename: str) -> ActionSpecification:
    """Return the definition in an ``.action`` file."""
    path = Path(interface_filename)
    return parse_action_string(pkg_name, path.stem, path.read_text(encoding="utf-8"))


def parse_action_string(pkg_name: str, action_name: str, action_string: str) -> ActionSpecification:
    """Return the definition of an action in a text.

    Raises:
        InvalidActionSpecification: The text has not three parts.
        InvalidFieldDefinition: A line is neither a field nor a constant.
    """
    try:
        sections = split_sections(action_string, "action", f"{pkg_name}/{action_name}")
    except InvalidDefinitionError as error:
        raise InvalidActionSpecification(error.message) from error
    goal, result, feedback = (
        parse_message_string(pkg_name, action_name + suffix, text)
        for suffix, (text, _) in zip(
            (ACTION_GOAL_SUFFIX, ACTION_RESULT_SUFFIX, ACTION_FEEDBACK_SUFFIX),
            sections,
            strict=True,
        )
    )
    return ActionSpecification(pkg_name, action_name, goal, result, feedback)


def _parse(text: str, package: str, name: str) -> Definition:
    try:
        return parse(text, f"{package}/msg/{name}", package)
    except InvalidDefinitionError as error:
        raise InvalidFieldDefinition(error.message) from error


def _specification(definition: Definition, package: str, name: str) -> MessageSpecification:
    fields, constants = [], []
    for field in definition.fields:
        made = Field(Type(str(field.type), package), field.name)
        made.default_value = field.default
        fields.append(made)
    for constant in definition.constants:
        kept = Constant.__new__(Constant)
        kept.type, kept.name, kept.value = constant.base, constant.name, constant.value
        kept.annotations = {}
        constants.append(kept)
    return MessageSpecification(package, name, fields, constants)
