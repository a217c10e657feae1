"""Queue of entities to spawn, several of which are compiled into the model at once.

MuJoCo compiles the whole model again for each change, in a time that grows with the square of its
size. So requests wait for a thread that adds all entities that are queued at once: hundreds cost
little more than one.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model import NewObject, with_objects
from teleopctl.node import Future

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel


class _Waiting(NamedTuple):
    """Queued entity: its name, the function that makes it, and the future of its spawning."""

    name: str
    make_object: Callable[[], NewObject]
    done: Future[NewObject]


class SpawnQueue:
    """Queue of entities to spawn, which a thread adds to the simulation's model.

    Args:
        present: Returns the simulation's present model.
        take: Called with the new model, with which the simulation is to continue.

    Attributes:
        changing: Lock to hold while changing the model.
    """

    def __init__(
        self, present: Callable[[], RobotModel], take: Callable[[RobotModel], None]
    ) -> None:
        self.changing = threading.Lock()
        self._present, self._take = present, take
        self._lock = threading.Lock()
        self._waiting: list[_Waiting] = []
        self._at_work: list[_Waiting] = []

    def add(self, name: str, make_object: Callable[[], NewObject]) -> Future[NewObject]:
        """Queue an entity to be spawned; return a future, done when it is in the simulation.

        Args:
            name: Name of the entity.
            make_object: Called on the queue's thread, again after a failed attempt; returns a new
                object to add to the model, or raises an error if it cannot be spawned.

        Returns:
            A future of the object. Its exception is what ``make_object`` raised, an
            InvalidDescriptionError of MuJoCo's, or an UnavailableError of the simulation's.
        """
        done: Future[NewObject] = Future()
        with self._lock:
            begins = not self._waiting and not self._at_work
            self._waiting.append(_Waiting(name, make_object, done))
        if begins:
            threading.Thread(target=self._work, name="spawning", daemon=True).start()
        return done

    def is_pending(self, name: str) -> bool:
        """Return whether an entity of this name is queued or being added."""
        with self._lock:
            return any(name == each.name for each in (*self._at_work, *self._waiting))

    def _work(self) -> None:
        while True:
            with self._lock:
                self._at_work, self._waiting = self._waiting, []
            if not self._at_work:
                return
            with self.changing:
                self._put_in(self._at_work)

    def _put_in(self, waiting: Sequence[_Waiting]) -> None:
        coming: list[tuple[_Waiting, NewObject]] = []
        for each in waiting:
            try:
                coming.append((each, each.make_object()))
            except Exception as error:  # noqa: BLE001 - reported to the caller that waits
                each.done.set_exception(error)
        if not coming:
            return
        try:
            self._take(with_objects(self._present(), [thing for _, thing in coming]))
        except Exception as error:  # noqa: BLE001 - likewise
            if isinstance(error, InvalidDescriptionError) and len(coming) > 1:
                # Add the objects one by one, to find the faulty one.
                for each, _ in coming:
                    self._put_in([each])
                return
            for each, _ in coming:
                each.done.set_exception(error)
            return
        for each, thing in coming:
            each.done.set_result(thing)
