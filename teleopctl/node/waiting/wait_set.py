"""Wait sets: several entities are waited for at once, without an executor."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from teleopctl.base.typed import TYPE_CHECKING, TypeAlias
from teleopctl.node.endpoints.timer import PeriodicTimer
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.context import Context

KINDS = ("subscription", "guard_condition", "timer", "client", "service", "event")

Entity: TypeAlias = QueuingEntity | PeriodicTimer


class WaitSet:
    """Wait set as rclpy has it: entities to wait for, and those that are ready.

    Whoever waits takes: meanwhile an executor is not told of what arrives. A timer of a node is
    called by its executor all the same.

    Args:
        context: Whose shutdown ends a wait.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._entities: dict[str, list[Entity]] = {kind: [] for kind in KINDS}
        self._ready: set[Entity] = set()

    def add_subscription(self, subscription: Handle | QueuingEntity) -> int:
        """Add a subscription; return its index for `is_ready`."""
        return self._add("subscription", subscription)

    def add_guard_condition(self, guard: Handle | QueuingEntity) -> int:
        """Add a guard condition; return its index for `is_ready`."""
        return self._add("guard_condition", guard)

    def add_timer(self, timer: Handle | PeriodicTimer) -> int:
        """Add a timer; return its index for `is_ready`."""
        return self._add("timer", timer)

    def add_client(self, client: Handle | QueuingEntity) -> int:
        """Add a client; return its index for `is_ready`."""
        return self._add("client", client)

    def add_service(self, service: Handle | QueuingEntity) -> int:
        """Add a service; return its index for `is_ready`."""
        return self._add("service", service)

    def add_event(self, event: Handle | QueuingEntity) -> int:
        """Add an event; return its index for `is_ready`."""
        return self._add("event", event)

    def _add(self, kind: str, entity: Handle | Entity) -> int:
        waitable = entity.entity if isinstance(entity, Handle) else entity
        if not isinstance(waitable, QueuingEntity | PeriodicTimer):
            raise TypeError(f"{type(waitable).__name__} is nothing that can be waited for")
        self._entities[kind].append(waitable)
        return len(self._entities[kind]) - 1

    def clear_entities(self) -> None:
        """Remove all entities."""
        self.listen(None)
        for entities in self._entities.values():
            entities.clear()
        self._ready = set()

    def listen(self, listener: Callable[[], None] | None) -> None:
        """Direct the entities' arrivals to a listener, or back to the executor for None."""
        for entities in self._entities.values():
            for entity in entities:
                entity.listener = listener
                if listener is None and entity.pending():
                    entity.tell_executor()

    def timers(self) -> list[PeriodicTimer]:
        """Return the timers of the set."""
        return [one for one in self._entities["timer"] if isinstance(one, PeriodicTimer)]

    def has_arrivals(self) -> bool:
        """Return whether any entity has an arrival."""
        return any(one.pending() for entities in self._entities.values() for one in entities)

    def look(self) -> bool:
        """Record which entities are ready; return False if none is.

        A trigger is taken by being noted.
        """
        found = [one for entities in self._entities.values() for one in entities if one.pending()]
        self._ready = set(found)
        for guard in self._entities["guard_condition"]:
            if guard in self._ready and isinstance(guard, QueuingEntity):
                guard.take()
        return bool(found)

    def wait(self, timeout_nsec: int) -> None:
        """Wait until an entity is ready, or for so many nanoseconds; negative is for ever."""
        end_ns = None if timeout_nsec < 0 else time.monotonic_ns() + timeout_nsec
        arrived = threading.Event()
        self.listen(arrived.set)
        self._context.on_shutdown(arrived.set)
        try:
            while not self.look() and self._context.ok():
                left_ns = None if end_ns is None else end_ns - time.monotonic_ns()
                if left_ns is not None and left_ns <= 0:
                    break
                arrived.wait(self._longest_wait_s(left_ns))
                arrived.clear()
        finally:
            self._context.forget_on_shutdown(arrived.set)
            self.listen(None)

    def _longest_wait_s(self, left_ns: int | None) -> float | None:
        """Return after what time to look again though nothing arrives; None for never."""
        due = [
            until_ns
            for timer in self.timers()
            if not timer.waits_for_event and (until_ns := timer.time_until_next_call()) is not None
        ]
        if left_ns is not None:
            due.append(left_ns)
        return max(0, min(due)) / 1e9 if due else None

    def is_ready(self, entity_type: str, index: int) -> bool:
        """Return whether an entity was ready at the last wait.

        Args:
            entity_type: One of `KINDS`.
            index: What adding it returned.
        """
        return self._entities[entity_type][index] in self._ready

    def get_ready_entities(self, entity_type: str) -> list[int]:
        """Return the ``pointer`` of each ready entity's handle, of one kind."""
        return [id(entity) for entity in self._entities[entity_type] if entity in self._ready]
