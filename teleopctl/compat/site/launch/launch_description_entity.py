"""``launch.launch_description_entity``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ._places import here

if TYPE_CHECKING:
    from .launch_context import LaunchContext


class LaunchDescriptionEntity:
    """What a launch description consists of.

    Attributes:
        defined_at: The line where it was made.
    """

    def __init__(self) -> None:
        self.defined_at = here()

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:
        """Do it, and return what is to be visited in its place."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return the entity in words."""
        return repr(self)

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return what stands in it."""
        return []

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return what stands in it and is always visited."""
        return self.get_sub_entities()

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return what stands in it and is visited under a condition, with that condition."""
        return []

    def get_asyncio_future(self) -> None:
        """Return what tells of its end; nothing does."""
        return
