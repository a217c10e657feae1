"""A running simulation, and its operations for services on other threads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from teleopctl.errors import NotFoundError, RefusedError, UnavailableError
from teleopctl.mujoco_model import NewObject, with_world, without_objects
from teleopctl.node import Future
from teleopctl.sim.entities.entity import entities, find
from teleopctl.sim.entities.spawning import SpawnQueue

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel
    from teleopctl.robot import World
    from teleopctl.sim.lockstep import LockstepLoop
    from teleopctl.sim.simulation import Simulation

T = TypeVar("T")
Array = npt.NDArray[np.float64]


class RunningSimulation:
    """A simulation with the loop that runs it, and operations that are safe from other threads.

    A changed model is compiled while the simulation runs; the simulation stands still only to
    switch to it. An operation that fails changes nothing.

    Args:
        simulation: The simulation.
        loop: Loop that runs the simulation.
        timeout_s: Longest wait for the loop, in seconds of wall time.
        world: World around the robot; None for the ground alone.
        on_change: Called on the loop's thread when objects, static poses or gravity have changed.
        on_restart: Called on the loop's thread when time has restarted.
        record: Called on the loop's thread with the number of steps that begin, or the states of
            free bodies that are set, as FreeJointState messages.

    Attributes:
        simulation: The simulation; only to be used within `call`.
        loop: Loop that runs the simulation.
        world: World around the robot; None for the ground alone.
        world_source: Source of the world: a file, a URI, or another name.
        stopped: Whether the simulation is stopped at its start, until it is played.
        changed: The function ``on_change``.
        record: The function ``record``.
        infos: EntityInfo messages that clients have set, by the entity's name.
    """

    # Any: messages, whose classes are made at run time.
    def __init__(
        self,
        simulation: Simulation,
        loop: LockstepLoop,
        *,
        timeout_s: float,
        world: World | None = None,
        on_change: Callable[[], None] = lambda: None,
        on_restart: Callable[[], None] = lambda: None,
        record: Callable[[int, Sequence[Any]], None] = lambda *_: None,
    ) -> None:
        self.simulation = simulation
        self.loop = loop
        self.world = world
        self.world_source = "" if world is None else str(world.path)
        self.stopped = False
        self.changed, self.record = on_change, record
        # Any: a message, whose class is made at run time.
        self.infos: dict[str, Any] = {}
        self._timeout_s = timeout_s
        self._start = simulation.model
        self._spawning = SpawnQueue(lambda: self.simulation.model, self._take)
        self._on_restart = on_restart

    def call(self, function: Callable[[], T]) -> T:
        """Run a function on the loop's thread between physics steps; return its result, or raise.

        Raises:
            UnavailableError: The simulation did not react in time.
        """
        results: list[T] = []
        errors: list[Exception] = []

        def run() -> None:
            try:
                results.append(function())
            except Exception as error:  # noqa: BLE001 - raised to the caller, the loop continues
                errors.append(error)

        if not self.loop.call(run, self._timeout_s):
            raise UnavailableError("The simulation did not react in time")
        if errors:
            raise errors[0]
        return results[0]

    def call_and_publish(self, function: Callable[[], T]) -> T:
        """Call a function as `call` does; then publish moved objects and, if paused, the state.

        Raises:
            UnavailableError: The simulation did not react in time.
        """

        def run() -> T:
            moves, gravity = self.simulation.static_moves, self.simulation.gravity
            result = function()
            if (self.simulation.static_moves, self.simulation.gravity) != (moves, gravity):
                self.changed()
            self.loop.show()
            return result

        return self.call(run)

    def spawn(
        self,
        world: World,
        name: str,
        place: Array,
        turn: Array,
        *,
        own_pose: bool = False,
        check_warnings: Callable[[tuple[str, ...]], None] = lambda _: None,
    ) -> Future[NewObject]:
        """Queue an entity to be added to the world; return a future of the spawned object.

        Args:
            world: The entity, as a world of its own.
            name: Name of the entity.
            place: Position in the world, (3,), in metres.
            turn: Rotation in the world, (4,), w x y z.
            own_pose: Whether the entity keeps its pose in the file, relative to ``place`` and
                ``turn``.
            check_warnings: Called with a warning for each part that was repaired or left out; may
                raise an exception, and then nothing is changed.

        Returns:
            A future of the spawned object. Its exception is what ``check_warnings`` raised, or
            an InvalidDescriptionError if MuJoCo cannot simulate the entity.
        """

        def read() -> NewObject:
            coming = NewObject(world, name, place, turn, own_pose=own_pose)
            check_warnings(coming.warnings)
            return coming

        return self._spawning.add(name, read)

    def delete(self, name: str) -> None:
        """Remove an entity, or all parts spawned under its name; raise for robot or unknown name.

        Raises:
            NotFoundError: There is no entity of that name.
            RefusedError: The entity is the robot.
        """
        with self._spawning.changing:
            parts = self._parts_of(name)
            if not parts and find(self.simulation, name).is_robot:
                raise RefusedError(f"'{name}' is the robot of this simulator: it cannot be removed")
            self._take(without_objects(self.simulation.model, parts or [name]))

    def delete_spawned(self) -> None:
        """Remove all entities that were spawned since the world was loaded."""
        with self._spawning.changing:
            model = self.simulation.model
            spawned = [thing.name for thing in model.things if thing.spawned]
            left = {thing.name for thing in model.things}.difference(spawned)
            if left == {thing.name for thing in self._start.things}:
                self._take_start()
            elif spawned:
                self._take(without_objects(model, spawned))

    def _take_start(self) -> None:
        """Return to the starting model, without another compilation of hundreds of objects."""
        if self.simulation.model is not self._start:
            self._take(self._start)

    def load(
        self,
        world: World | None,
        source: str = "",
        check_warnings: Callable[[tuple[str, ...]], None] = lambda _: None,
    ) -> tuple[str, ...]:
        """Replace the world, remove spawned entities, stop at time zero; return the warnings.

        Args:
            world: The new world; None for the ground alone.
            source: Source of the world, such as its URI.
            check_warnings: Called with the warnings; may raise an exception, and then nothing is
                changed.

        Returns:
            A warning for each part that was repaired or left out.

        Raises:
            InvalidDescriptionError: MuJoCo cannot simulate the world.
        """
        with self._spawning.changing:
            model = with_world(self.simulation.model, world)
            check_warnings(model.warnings)
            self.pause()
            self._take(model, self._begin_world)
            self._start = model
        self.world, self.world_source = world, source
        self.reset(time=True, state=False, spawned=False)
        self.stopped = True
        return model.warnings

    def _begin_world(self) -> None:
        """Reset the state for a new world, and drop the infos of the old world's objects."""
        self.simulation.reset_world_state()
        robot = next(iter(entities(self.simulation)))
        self.infos = {name: info for name, info in self.infos.items() if name == robot}

    async def step(self, count: int) -> None:
        """Advance a paused simulation by physics steps, and wait until all are done.

        Raises:
            RefusedError: The simulation is not paused, the number is less than 1, or the simulation
                was played, paused or stopped before all steps were made.
        """
        if not self.loop.paused:
            raise RefusedError("The simulation can be stepped only while paused")
        if count < 1:
            raise RefusedError(f"The number of steps is {count}")
        self.stopped = False
        made: Future[bool] = Future()
        self.loop.step(count, made.set_result, lambda: self.record(count, ()))
        if not await made:
            raise RefusedError("The steps were ended: the simulation was played, paused or stopped")

    def play(self) -> None:
        """Start or resume the simulation, and wait until it runs; raise after a timeout.

        Raises:
            UnavailableError: The simulation did not react in time.
        """
        self._set_paused(False)
        self.stopped = False

    def pause(self) -> None:
        """Pause at the next control tick, and wait until it is reached; raise after a timeout.

        Raises:
            UnavailableError: The simulation did not react in time.
        """
        self._set_paused(True)
        self.stopped = False

    def stop(self) -> None:
        """Pause, reset time and states, remove spawned entities and restore deleted ones.

        Raises:
            UnavailableError: The simulation did not react in time.
        """
        self.pause()
        self.reset(time=True, state=True, spawned=True, deleted=True)
        self.stopped = True

    def reset(self, *, time: bool, state: bool, spawned: bool, deleted: bool = False) -> None:
        """Reset time, state or entities of the simulation, each selected by a keyword argument.

        Args:
            time: Whether to set the time to zero.
            state: Whether to reset all states.
            spawned: Whether to remove spawned entities.
            deleted: Whether to restore deleted objects of the start as well.
        """
        if deleted:
            with self._spawning.changing:
                self._take_start()
        elif spawned:
            self.delete_spawned()

        def change() -> None:
            if state:
                self.simulation.reset_state()
            if time:
                self.simulation.reset_time()
                self.restart_time()

        self.call_and_publish(change)

    def restart_time(self) -> None:
        """Restart the loop's schedules and the sensors after a time reset; on the loop's thread."""
        self.loop.restart()
        self._on_restart()

    def unused_name(self, wanted: str) -> str:
        """Return the requested name if no entity has that name, else with a number appended."""
        name, number = wanted, 0
        while not self.is_free(name):
            number += 1
            name = f"{wanted}_{number}"
        return name

    def is_free(self, name: str) -> bool:
        """Return whether a name is unused by entities, links and entities being spawned."""
        if self._parts_of(name) or self._spawning.is_pending(name):
            return False
        try:
            find(self.simulation, name)
        except NotFoundError:
            return not self.simulation.has_link(name)
        return False

    def _parts_of(self, name: str) -> list[str]:
        """Return the objects ``NAME/part`` that were spawned together under a common name."""
        known = entities(self.simulation)
        if name in known:
            return []
        return [n for n, entity in known.items() if entity.spawned and n.startswith(f"{name}/")]

    def _take(self, model: RobotModel, then: Callable[[], None] = lambda: None) -> None:
        def change() -> None:
            self.simulation.replace_model(model)
            then()
            present = entities(self.simulation)
            self.infos = {name: info for name, info in self.infos.items() if name in present}
            self.changed()
            self.loop.show()

        self.call(change)

    def _set_paused(self, paused: bool) -> None:
        if not self.loop.set_paused(paused, self._timeout_s):
            raise UnavailableError("The simulation did not react in time")
