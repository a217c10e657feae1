"""``launch.utilities.visit_all_entities_and_collect_futures_impl``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..launch_description_entity import LaunchDescriptionEntity

if TYPE_CHECKING:
    import asyncio

    from ..launch_context import LaunchContext


# Any: the results of the futures are not used.
def visit_all_entities_and_collect_futures(
    entity: LaunchDescriptionEntity, context: LaunchContext
) -> list[tuple[LaunchDescriptionEntity, asyncio.Future[Any]]]:
    """Visit an entity and all below it, depth first; return the futures of those that still run."""
    further = entity.visit(context)
    future = entity.get_asyncio_future()
    found = [] if future is None else [(entity, future)]
    for inner in further or ():
        found += visit_all_entities_and_collect_futures(inner, context)
    return found
