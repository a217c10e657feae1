"""``launch.utilities.visit_all_entities_and_collect_futures_impl``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    import asyncio

    from ..launch_context import LaunchContext


# Any: nobody cares for what a future gives.
def visit_all_entities_and_collect_futures(
    entity: LaunchDescriptionEntity, context: LaunchContext
) -> list[tuple[LaunchDescriptionEntity, asyncio.Future[Any]]]:
    """Visit an entity and what that gives, depth first; return what is still going on."""
    further = entity.visit(context)
    future = entity.get_asyncio_future()
    found = [] if future is None else [(entity, future)]
    for inner in further or ():
        found += visit_all_entities_and_collect_futures(inner, context)
    return found
