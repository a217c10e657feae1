"""Wait sets: several entities are waited for at once, without an executor."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from teleopctl.node.endpoints.waitable import Waitable
from teleopctl.node.values.handle import Handle

if TYPE_CHECKING:
    from teleopctl.node.context import Context

KINDS = ("subscription", "guard_condition", "event")


class WaitSet:
    """What is waited for, and what of it is ready.

    Subscriptions, guard conditions and events can be waited for. Whoever waits takes: meanwhile an
    executor is not told of what arrives.

    Args:
        context: Whose shutdown ends a wait.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._entities: dict[str, list[Waitable]] = {kind: [] for kind in KINDS}
        self._ready: set[Waitable] = set()

    def add_subscription(self, subscription: Handle | Waitable) -> int:
        """Wait for messages as well; returns the index for `is_ready`."""
        return self._add("subscription", subscription)

    def add_guard_condition(self, guard: Handle | Waitable) -> int:
        """Wait for a trigger as well; returns the index for `is_ready`."""
        return self._add("guard_condition", guard)

    def add_event(self, event: Handle | Waitable) -> int:
        """Wait for an event of an endpoint as well; returns the index for `is_ready`."""
        return self._add("event", event)

    def _add(self, kind: str, entity: Handle | Waitable) -> int:
        waitable = entity.entity if isinstance(entity, Handle) else entity
        if not isinstance(waitable, Waitable):
            raise TypeError(f"{type(waitable).__name__} is nothing that can be waited for")
        self._entities[kind].append(waitable)
        return len(self._entities[kind]) - 1

    def clear_entities(self) -> None:
        """Wait for nothing any more."""
        self.listen(None)
        for entities in self._entities.values():
            entities.clear()
        self._ready = set()

    def listen(self, listener: Callable[[], None] | None) -> None:
        """Have a function told of arrivals in the place of an executor; None gives them back."""
        for entities in self._entities.values():
            for entity in entities:
                entity.listener = listener
                if listener is None and entity.pending():
                    entity.tell_executor()

    def has_arrivals(self) -> bool:
        """Tell whether anything is ready now."""
        return any(one.pending() for entities in self._entities.values() for one in entities)

    def look(self) -> bool:
        """Note what is ready; False when nothing is. A trigger is taken by being noted."""
        found = [one for entities in self._entities.values() for one in entities if one.pending()]
        self._ready = set(found)
        for guard in self._entities["guard_condition"]:
            if guard in self._ready:
                guard.take()
        return bool(found)

    def wait(self, timeout_nsec: int) -> None:
        """Wait until something is ready, or so many nanoseconds; negative waits for ever."""
        arrived = threading.Event()
        self.listen(arrived.set)
        self._context.on_shutdown(arrived.set)
        try:
            if not self.look() and self._context.ok():
                arrived.wait(None if timeout_nsec < 0 else timeout_nsec / 1e9)
                self.look()
        finally:
            self._context.forget_on_shutdown(arrived.set)
            self.listen(None)

    def is_ready(self, entity_type: str, index: int) -> bool:
        """Whether an entity was ready at the last look.

        Args:
            entity_type: ``subscription``, ``guard_condition`` or ``event``.
            index: What adding it returned.
        """
        return self._entities[entity_type][index] in self._ready

    def get_ready_entities(self, entity_type: str) -> list[int]:
        """Return the ``pointer`` of the handles of one kind that were ready at the last look."""
        return [id(entity) for entity in self._entities[entity_type] if entity in self._ready]
