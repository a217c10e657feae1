"""``launch.utilities.class_tools_impl``."""


# object: any object can be tested.
def isclassinstance(obj: object) -> bool:
    """Return whether an object is an instance of a class; True for every Python object."""
    return hasattr(obj, "__class__")


def is_a(obj: object, entity_type: type) -> bool:
    """Return whether an object is an instance of a class.

    Raises:
        RuntimeError: The second argument is no class.
    """
    if not isinstance(entity_type, type):
        raise RuntimeError(f"entity_type '{obj}' is not a class")
    return isinstance(obj, entity_type)


def is_a_subclass(obj: object, entity_type: type) -> bool:
    """Return whether an object is an instance of a class or of a subclass."""
    return is_a(obj, entity_type) or (isinstance(obj, type) and issubclass(obj, entity_type))
