"""``rosidl_runtime_py.import_message``. The class of a type."""

from importlib import import_module
from typing import Any

from rosidl_parser.definition import NamespacedType


# Any: a class that is made from a definition.
def import_message_from_namespaced_type(message_type: NamespacedType) -> Any:
    """Return the class of a message, a service or an action."""
    return getattr(import_module(".".join(message_type.namespaces)), message_type.name)
