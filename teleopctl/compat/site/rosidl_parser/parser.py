"""``rosidl_parser.parser``. IDL files as values of `rosidl_parser.definition`."""

from typing import cast

from rosidl_parser.definition import (
    ACTION_FEEDBACK_SUFFIX,
    ACTION_GOAL_SUFFIX,
    ACTION_RESULT_SUFFIX,
    SERVICE_REQUEST_MESSAGE_SUFFIX,
    SERVICE_RESPONSE_MESSAGE_SUFFIX,
    AbstractType,
    Action,
    Annotation,
    BoundedString,
    BoundedWString,
    Constant,
    IdlContent,
    IdlFile,
    IdlLocator,
    Include,
    Member,
    Message,
    NamespacedType,
    Service,
    Structure,
)
from teleopctl.errors import InvalidDefinitionError
from teleopctl.interfaces import FieldType, IdlStruct, idl_includes, read_idl, slot_type

__all__ = ["parse_idl_file", "parse_idl_string"]

# The parts of a definition by their number.
_SERVICE = (SERVICE_REQUEST_MESSAGE_SUFFIX, SERVICE_RESPONSE_MESSAGE_SUFFIX)
_ACTION = (ACTION_GOAL_SUFFIX, ACTION_RESULT_SUFFIX, ACTION_FEEDBACK_SUFFIX)


def parse_idl_file(locator: IdlLocator) -> IdlFile:
    """Read a file.

    Raises:
        InvalidDefinitionError: It cannot be understood, or has no message, service or action.
        OSError: It cannot be read.
    """
    path = locator.get_absolute_path()
    return IdlFile(locator, _content(path.read_text(encoding="utf-8"), str(path)))


def parse_idl_string(idl_string: str) -> IdlContent:
    """Read the text of a file.

    Raises:
        InvalidDefinitionError: It cannot be understood, or has no message, service or action.
    """
    return _content(idl_string, "the text")


def _content(text: str, where: str) -> IdlContent:
    structs = read_idl(text, where)
    includes = idl_includes(text)
    content = IdlContent([Include(locator) for locator in includes])
    messages = [_message(struct) for struct in structs]
    if len(messages) == 1:
        content.elements.append(messages[0])
    elif name := _common_name(structs, _SERVICE):
        content.elements.append(Service(name, *messages))
    elif name := _common_name(structs, _ACTION):
        action = Action(name, *messages)
        content.elements.extend(
            one for one in action.implicit_includes if one.locator not in includes
        )
        content.elements.append(action)
    else:
        raise InvalidDefinitionError(
            f"{where}: its structs are not those of a message, a service or an action"
        )
    return content


def _common_name(structs: list[IdlStruct], suffixes: tuple[str, ...]) -> NamespacedType | None:
    """Return the name that structs have before their suffixes, None where they have none."""
    names = {struct.name.removesuffix(end) for struct, end in zip(structs, suffixes, strict=False)}
    fits = len(structs) == len(suffixes) and all(
        struct.name.endswith(end) for struct, end in zip(structs, suffixes, strict=True)
    )
    return _namespaced(names.pop()) if fits and len(names) == 1 else None


def _namespaced(name: str) -> NamespacedType:
    *namespaces, last = name.split("/")
    return NamespacedType(namespaces, last)


def _message(struct: IdlStruct) -> Message:
    members = [
        Member(
            slot_type(member.type), member.name, [Annotation(*one) for one in member.annotations]
        )
        for member in struct.members
    ]
    constants = [
        Constant(one.name, _type_of_constant(one.base, one.value), cast("str | float", one.value))
        for one in struct.constants
    ]
    annotations = [Annotation(*one) for one in struct.annotations]
    return Message(Structure(_namespaced(struct.name), members, annotations), constants)


def _type_of_constant(base: str, value: object) -> AbstractType:
    """Return the type of a constant; that of a text is as long as it."""
    if base == "string":
        return BoundedString(len(str(value)))
    return BoundedWString(len(str(value))) if base == "wstring" else slot_type(FieldType(base))
