"""``launch.frontend.entity``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, get_args

from teleopctl.errors import TeleopctlError
from teleopctl.launch import Element

from ..utilities.type_utils import get_typed_value, is_instance_of


class Entity:
    """Element of an XML or YAML launch file.

    Args:
        type_name: Its name.
        element: Element of `teleopctl.launch`.
        parent: Parent element, or None.
    """

    def __init__(self, type_name: str, element: Element, parent: Entity | None = None) -> None:
        self._type_name = type_name
        self._element = element
        self._parent = parent
        self._read: list[str] = []

    @property
    def type_name(self) -> str:
        """Name of the element, such as ``node``."""
        return self._type_name

    @property
    def parent(self) -> Entity | None:
        """Parent element, or None."""
        return self._parent

    @property
    def children(self) -> list[Entity]:
        """Child elements."""
        self._read.append("children")
        found = self._element.fields((*self._read, "children")).get("children")
        if found is None:
            return []
        return [Entity(*item.action(), self) for item in found.items("a list of actions")]

    # Any: the caller gives the type.
    def get_attr(
        self, name: str, *, data_type: Any = str, optional: bool = False, can_be_str: bool = True
    ) -> Any:
        """Return the value of an attribute.

        Args:
            name: The key.
            data_type: Type of the value: a scalar's type, a list of one, or a list of entities.
            optional: Whether None is returned where it is missing.
            can_be_str: Whether it may be a text with substitutions all the same.

        Raises:
            AttributeError: The attribute is missing.
            TypeError: The value has another type.
        """
        self._read.append(name)
        found = self._element.fields((name, "children")).get(name)
        if found is None:
            if optional:
                return None
            raise AttributeError(
                f"Attribute '{name}' of type '{data_type}' not found in Entity '{self._type_name}'"
            )
        if get_args(data_type) == (Entity,):
            return [Entity(name, item, self) for item in found.items("a list")]
        value = _plain(found)
        if data_type is str and isinstance(value, bool | int | float):
            return found.text()
        # YAML has types; an XML attribute is a text until its type is requested.
        is_open = found.noun == "attribute" and data_type is not str
        if not is_open and is_instance_of(value, data_type, can_be_str=can_be_str):
            return value
        try:
            return get_typed_value(value, data_type, can_be_str=can_be_str)
        except (TypeError, ValueError) as error:
            raise TypeError(
                f"Attribute '{name}' of Entity '{self._type_name}' expected to be of type "
                f"'{data_type}'.'{value}' can not be converted to one of those types"
            ) from error

    @property
    def element(self) -> Element:
        """Element as `teleopctl.launch` has it."""
        return self._element

    def has_read(self, keys: Iterable[str]) -> None:
        """Mark attributes as read."""
        self._read += keys

    def assert_entity_completely_parsed(self) -> None:
        """Raise if an attribute has not been read.

        Raises:
            ValueError: There are such.
        """
        try:
            left = self._element.fields((*self._read, "children")).keys() - set(self._read)
        except TeleopctlError:
            return  # a list, which has no keys
        if left := left - {"if", "unless"}:
            raise ValueError(f"Unexpected attribute(s) found in `{self._type_name}`: {left}")


def _plain(element: Element) -> Any:
    value = element.value
    return [_plain(item) for item in value] if isinstance(value, list) else value
