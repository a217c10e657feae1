"""Types that stand in a bag and that this program lacks."""

from __future__ import annotations

from teleopctl.bag.records import ROS2MSG, BagTopic
from teleopctl.interfaces import add_definition_text, known_types, type_hash

_SEPARATOR = "=" * 80
_HEAD = "MSG: "
_EVENT = "_Event"


def learn_types(topic: BagTopic) -> None:
    """Register a topic's type and its nested types from the bag's definition.

    Nothing known is replaced. A service is learnt from the definition of its events.

    Raises:
        TeleopctlError: The definition cannot be understood.
    """
    if topic.definition.encoding != ROS2MSG or known_types().find(topic.type_name) is not None:
        return
    texts = _texts(topic)
    event = topic.type_name
    if "/srv/" in event and event.endswith(_EVENT):
        service = event.removesuffix(_EVENT)
        names = [f"{service}_{part}" for part in ("Request", "Response")]
        # rosbag2 writes the .srv file of the service; others a part for each message.
        own = texts.pop(event)
        parts = [texts.pop(name, "") for name in names]
        texts[service] = "\n---\n".join(parts) if any(parts) else own
    for type_name, text in texts.items():
        if known_types().find(type_name) is None:
            add_definition_text(type_name, text)


def hash_of(topic: BagTopic) -> str:
    """Return the type hash of a topic: the recorded one, else that of the known type.

    Raises:
        TeleopctlError: The type is not known.
    """
    return topic.type_hash or type_hash(topic.type_name)


def _texts(topic: BagTopic) -> dict[str, str]:
    """The definitions by type; those that a type uses stand before it."""
    head, *others = topic.definition.text.split(f"{_SEPARATOR}\n")
    texts = {topic.type_name: head}
    for other in others:
        first, _, text = other.partition("\n")
        name = first.removeprefix(_HEAD).strip()
        if name.count("/") == 1:
            name = name.replace("/", "/msg/")
        texts[name] = text
    return dict(reversed(texts.items()))
