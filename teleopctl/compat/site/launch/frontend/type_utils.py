"""``launch.frontend.type_utils``."""

from __future__ import annotations

from typing import Any, get_args

from ..utilities.type_utils import is_typing_list
from .entity import Entity


# Any: a type may be `typing.List[int]`, which is no class.
def check_is_list_entity(data_type: Any) -> bool:
    """Tell whether a type is a list of entities."""
    arguments = get_args(data_type)
    return is_typing_list(data_type) and len(arguments) == 1 and issubclass(arguments[0], Entity)
