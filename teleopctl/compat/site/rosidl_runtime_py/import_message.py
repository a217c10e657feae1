"""``rosidl_runtime_py.import_message``. The class of a type."""

import warnings
from importlib import import_module
from typing import Any

from rosidl_parser.definition import AbstractNestedType, AbstractType, NamespacedType

from teleopctl.interfaces import module_name


# Any: a class that is made from a definition.
def import_message_from_namespaced_type(message_type: AbstractType) -> Any:
    """Return the class of a message, a service, an action, or of a part of one.

    That of the elements, with a DeprecationWarning, if an array or a sequence is given.
    """
    if isinstance(message_type, AbstractNestedType):
        warnings.warn(
            "an array or a sequence has no class: give its value_type",
            DeprecationWarning,
            stacklevel=2,
        )
        return import_message_from_namespaced_type(message_type.value_type)
    assert isinstance(message_type, NamespacedType)
    # A part, as Fibonacci_FeedbackMessage, is only to be had from the module of its definition.
    name = message_type.name
    whole = "/".join((*message_type.namespaces, name.split("_", 1)[0]))
    module = module_name(whole) if "_" in name else ".".join(message_type.namespaces)
    return getattr(import_module(module), name)
