"""``launch.utilities.class_tools_impl``."""

import inspect


# object: whatever somebody wants to know about.
def isclassinstance(obj: object) -> bool:
    """Tell whether something is an instance of a class, which in Python everything is."""
    return hasattr(obj, "__class__")


def is_a(obj: object, entity_type: type) -> bool:
    """Tell whether something is an instance of a class.

    Raises:
        RuntimeError: What is given as the class is none.
    """
    if not inspect.isclass(entity_type):
        raise RuntimeError(f"entity_type '{obj}' is not a class")
    return isinstance(obj, entity_type)


def is_a_subclass(obj: object, entity_type: type) -> bool:
    """Tell whether something is an instance of a class, or a class derived from it."""
    return is_a(obj, entity_type) or (inspect.isclass(obj) and issubclass(obj, entity_type))
