"""What the graph tells an endpoint: whom it matches, and whose type is another one."""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.endpoints.events.callbacks import (
    EventCallback,
    IncompatibleTypeInfo,
    MatchedInfo,
)
from teleopctl.node.endpoints.events.handler import EventHandler
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.wire import EndpointToken, EntityKind

if TYPE_CHECKING:
    from teleopctl.node.endpoints.endpoint import Endpoint

_OTHER_SIDE = {EntityKind.MP: EntityKind.MS, EntityKind.MS: EntityKind.MP}


class GraphHandler(EventHandler):
    """Base of handlers that follow the matching endpoints of a topic.

    Args:
        endpoint: A publisher or subscription; its other side is looked at.
        callback: Told of changes.
        group: For multi-threaded executors.
    """

    def __init__(self, endpoint: Endpoint, callback: EventCallback, group: CallbackGroup) -> None:
        super().__init__(endpoint.node, callback, group)
        self._endpoint = endpoint
        self._other_side = _OTHER_SIDE[endpoint.kind]
        self._present: frozenset[EndpointToken] = frozenset()
        self._total = 0
        self.node.context.on_graph_change(self._look)
        self._look()

    def _find(self) -> list[EndpointToken]:
        """Return the endpoints that fulfil the condition now."""
        raise NotImplementedError

    def _look(self) -> None:
        with self._lock:
            present = frozenset(self._find())
            come, gone = present - self._present, self._present - present
            if not come and not gone:
                return
            self._total += len(come)
            self._take_note(come, gone)
            self._present = present
            self._changed = True
        self.tell_executor()

    def _take_note(self, come: frozenset[EndpointToken], gone: frozenset[EndpointToken]) -> None:
        """Learn who has come and gone, under the lock."""

    def close(self) -> None:
        """Stop following the graph."""
        self.node.context.forget_on_graph_change(self._look)


class MatchedHandler(GraphHandler):
    """Counts the endpoints that match: of the same name and type, as under rmw_zenoh."""

    _told = (0, 0)

    def _find(self) -> list[EndpointToken]:
        return self.node.matched(self._other_side, self._endpoint.name, self._endpoint.type_name)

    def _status(self) -> MatchedInfo:
        current = len(self._present)
        total_before, current_before = self._told
        self._told = (self._total, current)
        return MatchedInfo(
            self._total, self._total - total_before, current, current - current_before
        )


class IncompatibleTypeHandler(GraphHandler):
    """Counts the endpoints of the same name with another type, or another version of the type.

    Such two exchange nothing, and under rmw_zenoh nobody is told.
    """

    _told = 0

    def _find(self) -> list[EndpointToken]:
        graph, name = self.node.graph(), self._endpoint.name
        others = (
            graph.publishers(name)
            if self._other_side is EntityKind.MP
            else graph.subscriptions(name)
        )
        own = (self._endpoint.type_name, self._endpoint.type_hash)
        return [other for other in others if (other.type_name, other.type_hash) != own]

    def _status(self) -> IncompatibleTypeInfo:
        before, self._told = self._told, self._total
        return IncompatibleTypeInfo(self._total, self._total - before)
