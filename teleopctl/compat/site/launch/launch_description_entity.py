"""``launch.launch_description_entity``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ._places import here

if TYPE_CHECKING:
    import asyncio

    from .launch_context import LaunchContext


class LaunchDescriptionEntity:
    """What a launch description consists of.

    Attributes:
        defined_at: The line where it was made.
        brings_arguments: Whether it gives arguments to what it includes.
    """

    brings_arguments = False

    def __init__(self) -> None:
        self.defined_at = here()

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:  # noqa: ARG002 -- for subclasses
        """Do it, and return what is to be visited in its place."""
        return None

    def describe(self) -> str:
        """Return the entity in words; a subclass brings it."""
        raise NotImplementedError("LaunchDescriptionEntity.describe() is not implemented")

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

    # Any: nobody cares for what it gives.
    def get_asyncio_future(self) -> asyncio.Future[Any] | None:
        """Return what tells of its end, where it goes on after it has been visited."""
        return None
