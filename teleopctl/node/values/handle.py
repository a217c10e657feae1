"""What rclpy calls the handle of an entity, which programs enter while they use it."""

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
    """Handle of an entity, where rclpy has that of its C library.

    Args:
        entity: The entity (ours).
        name: Its name: of the topic, the service or the node; empty where it has none.
    """

    def __init__(self, entity: Destroyable, name: str = "") -> None:
        # Any: whoever knows of what it is the handle uses it as that.
        self.entity: Any = entity
        self.name = name

    @property
    def pointer(self) -> int:
        """Number that identifies the entity among all living ones."""
        return id(self.entity)

    def destroy_when_not_in_use(self) -> None:
        """Destroy the entity."""
        self.entity.destroy()

    def __enter__(self) -> Self:
        if self.entity.is_destroyed:
            raise InvalidHandle("Tried to use an entity that was destroyed")
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the entity as it is."""
