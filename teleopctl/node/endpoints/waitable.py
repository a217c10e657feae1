"""Base of the entities whose arrivals an executor takes."""

from __future__ import annotations

from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.values.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from teleopctl.node.node_core import NodeCore


class NumberOfEntities:
    """Numbers of subscriptions, guard conditions, timers, clients, services and events."""

    def __init__(
        self,
        num_subs: int = 0,
        num_gcs: int = 0,
        num_timers: int = 0,
        num_clients: int = 0,
        num_services: int = 0,
        num_events: int = 0,
    ) -> None:
        self.num_subscriptions = num_subs
        self.num_guard_conditions = num_gcs
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

    An arrival is queued first and then reported with `notify_executor`; an executor that gets the
    node later checks `pending`. So no arrival is missed.
    """

    node: NodeCore
    callback_group: CallbackGroup

    listener: Callable[[], None] | None = None
    """Function called on arrivals instead of the executor, while a wait set holds the entity."""

    def take(self) -> Callable[[], object] | None:
        """Remove the oldest arrival; return the call that handles it, None if there is none."""
        raise NotImplementedError

    def pending(self) -> int:
        """Return how many arrivals are queued."""
        raise NotImplementedError

    def notify_executor(self) -> None:
        """Notify the wait set that holds the entity, else the node's executor, of an arrival."""
        if self.listener is not None:
            self.listener()
        elif (executor := self.node.executor) is not None:
            executor.schedule(self)
