"""Type definitions of topics in bags: looked up, registered, hashed, and made into classes."""

from __future__ import annotations

from typing import Any

from teleopctl.bag.records import CDR, ROS2MSG, BagTopic, TypeText
from teleopctl.errors import InvalidMessageError, TeleopctlError
from teleopctl.interfaces import (
    add_definition_text,
    check_readable,
    complete_definition_text,
    get_message,
    known_types,
    message_of_text,
    type_hash,
)

_SEPARATOR = "=" * 80
_HEAD = "MSG: "
_EVENT = "_Event"


def known_definition(type_name: str, required_hash: str = "") -> TypeText | None:
    """Return a type's definition as this process has it; None if unknown or of another hash.

    Args:
        type_name: Name of the type, ``package/msg/Name``.
        required_hash: Type hash (``RIHS01_…``) that the definition must have; any if empty.
    """
    try:
        if known_types().find(type_name) is None or required_hash not in ("", type_hash(type_name)):
            return None
        return TypeText(ROS2MSG, complete_definition_text(type_name))
    except TeleopctlError:
        return None


def known_hash(type_name: str) -> str:
    """Return the hash (``RIHS01_…``) of a type that this process knows; empty if unknown."""
    try:
        return "" if known_types().find(type_name) is None else type_hash(type_name)
    except TeleopctlError:
        return ""


def register_types(topic: BagTopic) -> None:
    """Add a bag topic's types to this process's known types; known ones are not replaced.

    Nested types are also added, and known types are not replaced. The definition of a service's
    event type defines the service.

    Raises:
        TeleopctlError: The definition cannot be parsed.
    """
    if topic.definition.encoding != ROS2MSG or known_types().find(topic.type_name) is not None:
        return
    texts = _texts(topic)
    event = topic.type_name
    if "/srv/" in event and event.endswith(_EVENT):
        service = event.removesuffix(_EVENT)
        names = [f"{service}_{part}" for part in ("Request", "Response")]
        # rosbag2 writes the .srv file of the service; other writers a part for each message.
        own = texts.pop(event)
        parts = [texts.pop(name, "") for name in names]
        texts[service] = "\n---\n".join(parts) if any(parts) else own
    for type_name, text in texts.items():
        if known_types().find(type_name) is None:
            add_definition_text(type_name, text)


def topic_type_hash(topic: BagTopic) -> str:
    """Return the type hash recorded for a topic, or else that of this process's type.

    Raises:
        TeleopctlError: The type is not known.
    """
    return topic.type_hash or type_hash(topic.type_name)


# Any: a class made from its definition.
def topic_message_class(topic: BagTopic) -> type[Any]:
    """Return a bag topic's message class, from the bag's definition or else this process's types.

    If the bag has no definition, the type of that name in this process's type catalog is used.

    Raises:
        TeleopctlError: The definition cannot be parsed, or no definition exists.
    """
    if topic.serialization_format != CDR:
        raise InvalidMessageError(
            f"Its messages are in the form '{topic.serialization_format}', and not in {CDR}"
        )
    definition = topic.definition
    if definition.text.strip():
        found = message_of_text(topic.type_name, definition.text, definition.encoding)
    else:
        found = get_message(topic.type_name)
    check_readable(found)
    return found


def _texts(topic: BagTopic) -> dict[str, str]:
    """Return the topic's definition texts by type, nested types before those that use them."""
    head, *others = topic.definition.text.split(f"{_SEPARATOR}\n")
    texts = {topic.type_name: head}
    for other in others:
        first, _, text = other.partition("\n")
        name = first.removeprefix(_HEAD).strip()
        if name.count("/") == 1:
            name = name.replace("/", "/msg/")
        texts[name] = text
    return dict(reversed(texts.items()))
