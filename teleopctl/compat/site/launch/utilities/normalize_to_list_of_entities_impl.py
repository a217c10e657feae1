"""``launch.utilities.normalize_to_list_of_entities_impl``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    from ..some_entities_type import SomeEntitiesType


def normalize_to_list_of_entities(
    entities: Iterable[SomeEntitiesType],
) -> list[LaunchDescriptionEntity]:
    """Return entities and lists of them as one list."""
    flat: list[LaunchDescriptionEntity] = []
    for entity in entities:
        flat += [entity] if isinstance(entity, LaunchDescriptionEntity) else entity
    return flat
