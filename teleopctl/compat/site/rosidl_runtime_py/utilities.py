"""``rosidl_runtime_py.utilities``. Types by their names."""

from typing import Any

from rosidl_parser.definition import NamespacedType

from rosidl_runtime_py.import_message import import_message_from_namespaced_type

# Any: classes that are made from definitions.


def get_interface(identifier: str) -> Any:
    """Return the class of ``package/kind/Name``."""
    return import_message_from_namespaced_type(get_namespaced_type(identifier))


def get_message(identifier: str) -> Any:
    """Return the class of a message; the kind may be left out."""
    return _of_kind(identifier, "msg", is_message, "a message")


def get_service(identifier: str) -> Any:
    """Return the class of a service; the kind may be left out."""
    return _of_kind(identifier, "srv", is_service, "a service")


def get_action(identifier: str) -> Any:
    """Return the class of an action; the kind may be left out."""
    return _of_kind(identifier, "action", is_action, "an action")


def get_namespaced_type(identifier: str) -> NamespacedType:
    """Return the type of a name."""
    *namespaces, name = identifier.split("/")
    return NamespacedType(namespaces, name)


def get_message_namespaced_type(identifier: str) -> NamespacedType:
    """Return the type of a message; the kind may be left out."""
    return _with_kind(identifier, "msg")


def get_service_namespaced_type(identifier: str) -> NamespacedType:
    """Return the type of a service; the kind may be left out."""
    return _with_kind(identifier, "srv")


def get_action_namespaced_type(identifier: str) -> NamespacedType:
    """Return the type of an action; the kind may be left out."""
    return _with_kind(identifier, "action")


def is_message(interface: object) -> bool:
    """Return whether a class is a message."""
    return hasattr(interface, "SLOT_TYPES")


def is_service(interface: object) -> bool:
    """Return whether a class is a service."""
    return hasattr(interface, "Request") and hasattr(interface, "Response")


def is_action(interface: object) -> bool:
    """Return whether a class is an action."""
    return all(hasattr(interface, part) for part in ("Goal", "Result", "Feedback"))


def _with_kind(identifier: str, kind: str) -> NamespacedType:
    found = get_namespaced_type(identifier)
    if len(found.namespaces) == 1:
        found.namespaces.append(kind)
    return found


def _of_kind(identifier: str, kind: str, fits: Any, what: str) -> Any:
    found = import_message_from_namespaced_type(_with_kind(identifier, kind))
    if not fits(found):
        raise ValueError(f"Expected the full name of {what}, got '{identifier}'")
    return found
