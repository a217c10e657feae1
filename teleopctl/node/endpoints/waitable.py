"""Things that receive, as an executor sees them."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore


class NumberOfEntities:
    """Numbers of entities of each kind that an executor waits for."""

    def __init__(
        self,
        num_subs: int = 0,
        num_guards: int = 0,
        num_timers: int = 0,
        num_clients: int = 0,
        num_services: int = 0,
        num_events: int = 0,
    ) -> None:
        self.num_subscriptions = num_subs
        self.num_guard_conditions = num_guards
        self.num_timers = num_timers
        self.num_clients = num_clients
        self.num_services = num_services
        self.num_events = num_events

    def __add__(self, other: NumberOfEntities) -> NumberOfEntities:
        total = NumberOfEntities()
        for kind, number in vars(self).items():
            setattr(total, kind, number + getattr(other, kind))
        return total

    def __repr__(self) -> str:
        return f"NumberOfEntities({', '.join(map(str, vars(self).values()))})"


class QueuingEntity:
    """Base of entities that queue arrivals on any thread until the node's executor takes them.

    An arrival is queued first and then told with `tell_executor`; an executor that gets the
    node later asks `pending`. So none is missed, whichever comes first.
    """

    node: NodeCore
    callback_group: CallbackGroup

    listener: Callable[[], None] | None = None
    """Told of arrivals in the place of the executor, while somebody waits by hand."""

    def take(self) -> Callable[[], object] | None:
        """Return the call for the oldest arrival; None if there is none."""
        raise NotImplementedError

    def pending(self) -> int:
        """Return how many arrivals are queued."""
        raise NotImplementedError

    def tell_executor(self) -> None:
        """Notify the node's executor, or the wait set, of an arrival."""
        if self.listener is not None:
            self.listener()
        elif (executor := self.node.executor) is not None:
            executor.schedule(self)
