"""Message types from definition texts in bags, separate from the types of this process.

A bag may contain types that are unknown on this machine, or have another version here. Their
classes are made from the text alone, and are not added to the types of this process.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Mapping

from teleopctl.base.typed import Any, cache
from teleopctl.errors import InvalidDefinitionError, TeleopctlError
from teleopctl.interfaces import hashing
from teleopctl.interfaces.cdr.codec import Codecs
from teleopctl.interfaces.cdr.serialization import set_codecs
from teleopctl.interfaces.definition import Definition
from teleopctl.interfaces.message import Message, make_class
from teleopctl.interfaces.parser import parse
from teleopctl.interfaces.services import service_of_event, split_definition
from teleopctl.interfaces.standard import parse_type_row
from teleopctl.interfaces.store import get_message, known_types
from teleopctl.interfaces.typenames import normalize, split

ROS2MSG, ROS2IDL = "ros2msg", "ros2idl"

# Separator of the parts of a text, as rosbag2 and ROS 1 write it.
_PART = re.compile(r"^=+[ \t]*\r?\n(?:MSG|IDL):[ \t]*(\S+)[ \t]*\r?$\n?", re.MULTILINE)


# Any: the class is made from the text.
@cache
def message_of_text(type_name: str, text: str, encoding: str = ROS2MSG) -> type[Any]:
    """Return a message class for a definition text; the known class if all fields are equal.

    If this process has all types of the text with the same fields, the class is that of
    `get_message`. Otherwise it is a separate class, which only `serialize` and `deserialize`
    accept. The same text returns the same class.

    Args:
        type_name: Full name of the type, ``package/msg/Name``.
        text: Definition of the type and of the types that it uses; missing types are looked up in
            this process.
        encoding: Language of the text: ``ros2msg`` or ``ros2idl``.

    Raises:
        InvalidDefinitionError: The text cannot be parsed.
        InvalidTypeNameError: The type name is malformed.
        InvalidMessageError: A type is neither in the text nor in this process.
    """
    definitions = _definitions(normalize(type_name), text, encoding)
    if all(map(_is_known, definitions.values())):
        return get_message(type_name)
    return _Apart(definitions).message_class(type_name)


def hash_of_text(type_name: str, text: str, encoding: str = ROS2MSG) -> str:
    """Return the type hash, ``RIHS01_…``, of the type in a definition text.

    Args:
        type_name: Full name of the type, ``package/msg/Name``.
        text: Definition of the type, as for `message_of_text`.
        encoding: Language of the text: ``ros2msg`` or ``ros2idl``.

    Raises:
        InvalidDefinitionError: The text cannot be parsed, or uses an unknown type.
        InvalidTypeNameError: The type name is malformed.
    """
    name = normalize(type_name)
    definitions = _definitions(name, text, encoding)

    def lookup(nested: str) -> Definition:
        found = definitions.get(nested) or known_types().find(nested)
        if found is None:
            raise InvalidDefinitionError(f"{type_name} uses {nested}, which is not defined")
        return found

    return hashing.type_hash(definitions[name], lookup)


class _Apart:
    """Message classes of given definitions; other types are those of this process."""

    def __init__(self, definitions: Mapping[str, Definition]) -> None:
        self._definitions = definitions
        self._classes: dict[str, type[Message]] = {}
        self._codecs = Codecs(self.message_class)
        self._lock = threading.RLock()

    def message_class(self, type_name: str) -> type[Any]:
        definition = self._definitions.get(type_name)
        if definition is None:
            return get_message(type_name)
        with self._lock:
            if type_name not in self._classes:
                made = make_class(definition, self.message_class)
                set_codecs(made, self._codecs)
                self._classes[type_name] = made
            return self._classes[type_name]


def _is_known(definition: Definition) -> bool:
    try:
        known = known_types().find(definition.type_name)
    except TeleopctlError:  # the user's definition file of the type cannot be read
        return False
    return known is not None and hashing.fields_of(known) == hashing.fields_of(definition)


def _definitions(type_name: str, text: str, encoding: str) -> dict[str, Definition]:
    if encoding not in (ROS2MSG, ROS2IDL):
        raise InvalidDefinitionError(
            f"{type_name} is defined in the language '{encoding}', which cannot be read",
            hint=f"{ROS2MSG} and {ROS2IDL} can.",
        )
    first, *others = _PART.split(text)
    parts = [(type_name, first)] if first.strip() or not others else []
    parts += [(normalize(name), part) for name, part in zip(others[::2], others[1::2], strict=True)]
    found: dict[str, Definition] = {}
    for name, part in parts:
        if encoding == ROS2IDL:
            found.update(_from_idl(name, part))
        elif (service := service_of_event(name, part)) is not None:
            found.update({each.type_name: each for each in split_definition(part, service, name)})
        else:
            found[name] = parse(part, name, split(name)[0])
    if type_name not in found:
        raise InvalidDefinitionError(f"The text that should define {type_name} does not")
    return found


def _from_idl(name: str, text: str) -> dict[str, Definition]:
    from rosbags.typesys import get_types_from_idl
    from rosbags.typesys.base import TypesysError

    try:
        rows = get_types_from_idl(text)
        return {found: parse_type_row(found, row) for found, row in rows.items()}
    except (TypesysError, ValueError, TypeError, LookupError) as error:
        raise InvalidDefinitionError(f"The IDL of {name} cannot be understood: {error}") from error
