"""``launch.launch_description``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from .actions.declare_launch_argument import DeclareLaunchArgument
    from .launch_context import LaunchContext


class LaunchDescription(LaunchDescriptionEntity):
    """What a launch file describes: entities in their order.

    Args:
        initial_entities: Those that it begins with.
        deprecated_reason: Why it should not be used any more.
    """

    def __init__(
        self,
        initial_entities: Iterable[LaunchDescriptionEntity] | None = None,
        *,
        deprecated_reason: str | None = None,
    ) -> None:
        super().__init__()
        self._entities = list(initial_entities or ())
        self._deprecated_reason = deprecated_reason

    @property
    def entities(self) -> list[LaunchDescriptionEntity]:
        """The entities in their order."""
        return self._entities

    @property
    def deprecated(self) -> bool:
        """Whether it should not be used any more."""
        return self._deprecated_reason is not None

    @property
    def deprecated_reason(self) -> str | None:
        """Why it should not be used any more, or None."""
        return self._deprecated_reason

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:  # noqa: ARG002 -- the original's signature
        """Return the entities."""
        return self._entities

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities."""
        return self._entities

    def describe(self) -> str:
        """Return the description in words."""
        return repr(self)

    def add_entity(self, entity: LaunchDescriptionEntity) -> None:
        """Add an entity."""
        self._entities.append(entity)

    def add_action(self, action: LaunchDescriptionEntity) -> None:
        """Add an action."""
        self.add_entity(action)

    def get_launch_arguments(
        self, conditional_inclusion: bool = False
    ) -> list[DeclareLaunchArgument]:
        """Return the launch arguments that are declared here and in what is included."""
        from .actions.declare_launch_argument import DeclareLaunchArgument

        found: list[DeclareLaunchArgument] = []

        def look(entities: Iterable[LaunchDescriptionEntity]) -> None:
            for entity in entities:
                if isinstance(entity, DeclareLaunchArgument):
                    found.append(entity)
                look(entity.describe_sub_entities())
                if not conditional_inclusion:
                    for _, inner in entity.describe_conditional_sub_entities():
                        look(inner)

        look(self._entities)
        return found
