"""``rosbag2_py._message_definitions``. Definitions of message types."""

from rosbag2_py._storage import MessageDefinition
from teleopctl import bag

__all__ = ["LocalMessageDefinitionSource"]


class LocalMessageDefinitionSource:
    """Source of the definitions of this process's types."""

    def get_full_text(self, topic_type: str) -> MessageDefinition:
        """Return the definition of a type, followed by those of all nested types.

        The encoding and the text are ``unknown`` and empty for an unknown type.
        """
        definition = bag.known_definition(topic_type)
        if definition is None:
            return MessageDefinition(topic_type, "unknown", "", "")
        return MessageDefinition(
            topic_type, definition.encoding, definition.text, bag.known_hash(topic_type)
        )
