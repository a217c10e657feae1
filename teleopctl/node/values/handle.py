"""Handles of entities, as rclpy has them."""

from __future__ import annotations

from teleopctl.base.typed import Any, Protocol, Self
from teleopctl.node.values.exceptions import InvalidHandle


class Destroyable(Protocol):
    """Interface of entities that can be destroyed."""

    @property
    def is_destroyed(self) -> bool:
        """Whether the entity was destroyed."""

    def destroy(self) -> None:
        """Destroy the entity."""


class Handle:
    """Handle of an entity, in place of rclpy's handle to its C library.

    Args:
        entity: The entity (ours).
        name: Name of the entity's topic, service or node; empty if it has none.
    """

    def __init__(self, entity: Destroyable, name: str = "") -> None:
        # Any: subclasses declare the class of their entities.
        self.entity: Any = entity
        self.name = name

    @property
    def pointer(self) -> int:
        """Number that identifies the entity, as rclpy's address of the C structure."""
        return id(self.entity)

    def destroy_when_not_in_use(self) -> None:
        """Destroy the entity at once, even while the entity is in use (unlike rclpy)."""
        self.entity.destroy()

    def __enter__(self) -> Self:
        if self.entity.is_destroyed:
            raise InvalidHandle("Tried to use an entity that was destroyed")
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the entity as it is."""
