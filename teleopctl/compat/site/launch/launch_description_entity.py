"""``launch.launch_description_entity``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ._places import here

if TYPE_CHECKING:
    import asyncio

    from .launch_context import LaunchContext


class LaunchDescriptionEntity:
    """Base class of actions and launch descriptions.

    Attributes:
        defined_at: The line where it was made.
        brings_arguments: Whether it gives arguments to what it includes.
    """

    brings_arguments = False

    def __init__(self) -> None:
        self.defined_at = here()

    def visit(self, context: LaunchContext) -> list[LaunchDescriptionEntity] | None:  # noqa: ARG002 -- for subclasses
        """Visit the entity; return the entities to visit next."""
        return None

    def describe(self) -> str:
        """Return a readable form of the entity; a subclass implements it."""
        raise NotImplementedError("LaunchDescriptionEntity.describe() is not implemented")

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the contained entities."""
        return []

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the contained entities that are always visited."""
        return self.get_sub_entities()

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the entities visited under a condition, with the condition's description."""
        return []

    # Any: the result is not used.
    def get_asyncio_future(self) -> asyncio.Future[Any] | None:
        """Return the future that ends with the entity, or None if it ends when it is visited."""
        return None
