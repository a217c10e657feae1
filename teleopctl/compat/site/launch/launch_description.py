"""``launch.launch_description``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from .actions.declare_launch_argument import DeclareLaunchArgument
    from .launch_context import LaunchContext


class LaunchDescription(LaunchDescriptionEntity):
    """A launch file's entities in their order.

    Args:
        initial_entities: First entities.
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
        """Whether the description is deprecated."""
        return self._deprecated_reason is not None

    @property
    def deprecated_reason(self) -> str | None:
        """Reason of the deprecation, or None."""
        return self._deprecated_reason

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Return the entities, and log a warning if the description is deprecated."""
        known = context.get_locals_as_dict()
        if "current_launch_file_path" in known:
            file = known["current_launch_file_path"]
            return self.with_warning(f"launch file [{file}] is deprecated")
        return self.with_warning("deprecated launch description")

    def with_warning(self, words: str) -> list[LaunchDescriptionEntity]:
        """Return the entities, after a warning if the description is deprecated.

        Args:
            words: Beginning of the warning.
        """
        if self._deprecated_reason is None:
            return self._entities
        from .actions.log_info import LogWarning

        return [LogWarning(msg=f"{words}: {self._deprecated_reason}"), *self._entities]

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities."""
        return self._entities

    def describe(self) -> str:
        """Return a readable form of the description."""
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
        """Return the launch arguments that are declared here and in included descriptions.

        Args:
            conditional_inclusion: Whether they are to be marked as such that may not be visited.
        """
        found = self.get_launch_arguments_with_include_launch_description_actions(
            conditional_inclusion
        )
        return [argument for argument, _ in found]

    def get_launch_arguments_with_include_launch_description_actions(
        self, conditional_inclusion: bool = False
    ) -> list[tuple[DeclareLaunchArgument, list[LaunchDescriptionEntity] | None]]:
        """Return the launch arguments, each with the includes that lead to it, or None."""
        from .actions.declare_launch_argument import DeclareLaunchArgument
        from .actions.reset_launch_configurations import ResetLaunchConfigurations

        found: dict[str, tuple[DeclareLaunchArgument, list[LaunchDescriptionEntity] | None]] = {}

        def look(
            entities: Iterable[LaunchDescriptionEntity],
            under: list[LaunchDescriptionEntity],
            *,
            conditional: bool,
        ) -> None:
            for entity in entities:
                if isinstance(entity, ResetLaunchConfigurations):
                    return  # arguments of later entities cannot be set from outside
                if isinstance(entity, DeclareLaunchArgument) and entity.name not in found:
                    entity._conditionally_included = conditional or entity.condition is not None  # noqa: SLF001 -- the original's name
                    found[entity.name] = (entity, under or None)
                below = [*under, entity] if entity.brings_arguments else under
                look(entity.describe_sub_entities(), below, conditional=False)
                for _, inner in entity.describe_conditional_sub_entities():
                    look(inner, below, conditional=True)

        look(self._entities, [], conditional=conditional_inclusion)
        return list(found.values())
