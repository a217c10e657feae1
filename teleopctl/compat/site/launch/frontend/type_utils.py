"""``launch.frontend.type_utils``."""

from __future__ import annotations

from typing import Any, get_args

from ..utilities.type_utils import AllowedTypesTuple, AllowedTypesType, is_typing_list
from .entity import Entity


# Any: a type may be `typing.List[int]`, which is no class.
def check_is_list_entity(data_type: Any) -> bool:
    """Return whether a type is a list of entities."""
    arguments = get_args(data_type)
    return is_typing_list(data_type) and len(arguments) == 1 and issubclass(arguments[0], Entity)


def get_data_type_from_identifier(type_identifier: str) -> AllowedTypesType:
    """Return the type of an identifier such as ``int`` or ``list_of_str``.

    Raises:
        RuntimeError: There is no such type.
    """
    if type_identifier not in _TYPES:
        raise RuntimeError(
            f"Unrecognized type identifier '{type_identifier}', expected one of {', '.join(_TYPES)}"
        )
    return _TYPES[type_identifier]


_TYPES: dict[str, AllowedTypesType] = {
    f"list_of_{get_args(kind)[0].__name__}" if get_args(kind) else kind.__name__: kind
    for kind in AllowedTypesTuple
}
