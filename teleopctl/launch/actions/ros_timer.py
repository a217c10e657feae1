"""Launch action ``ros_timer``: runs actions after a period of ROS time."""

from __future__ import annotations

import threading

from teleopctl.base.typed import Callable, Iterable
from teleopctl.errors import LaunchError, TeleopctlError
from teleopctl.launch.actions.nesting import TimedEntities
from teleopctl.launch.model.action import Launch, Step
from teleopctl.launch.model.events import ShutdownBegan
from teleopctl.launch.model.records import dataclass

# Interval at which a timer of simulated time checks whether it was cancelled.
_LOOK_EVERY_S = 0.2


class RosTimer(TimedEntities):
    """``ros_timer``: runs actions after a period of ROS time, or of wall time by default."""

    __slots__ = ()

    def evaluate(self, launch: Launch) -> None:
        """Add the timer to the launch: by ``/clock`` if ``use_sim_time`` is set, else wall time.

        That is set for the whole launch, so that a later action counts as well.
        """
        seconds, cancel = self.settings(launch)

        def add() -> None:
            if not launch.uses_sim_time:
                self.begin(launch, seconds, cancel)
                return
            timer = _SimulatedTimer(seconds, self.steps, self.is_cancelled, cancel, launch.emit)
            launch.register(timer)
            launch.work(timer)

        launch.decide_last(add)


@dataclass(frozen=True, slots=True)
class _TimeHasCome:
    """Event: a timer of simulated time has fired."""

    timer: object


class _SimulatedTimer:
    """Work that waits for a time of ``/clock``, and handler that then returns the timer's steps."""

    wants_output = False

    def __init__(
        self,
        seconds: float,
        steps: tuple[Step, ...],
        is_cancelled: Callable[[], bool],
        ends_with_launch: bool,
        emit: Callable[[object], None],
    ) -> None:
        self._seconds = seconds
        self._steps = steps
        self._is_cancelled = is_cancelled
        self._ends_with_launch = ends_with_launch
        self._emit = emit
        self._ended = threading.Event()

    def begin(self, report: Callable[[TeleopctlError | None], None]) -> None:
        """Start a thread that waits for the period of ``/clock`` and then calls ``report``."""
        threading.Thread(target=self._wait, args=(report,), name="ros_timer", daemon=True).start()

    def dry_run(self) -> tuple[str, tuple[Step, ...]]:
        """Return a text about when the timer fires, and the timer's steps, for a dry run."""
        return f"after {self._seconds:g} s of /clock", self._steps

    def answers(self, event: object, launch: Launch) -> bool:  # noqa: ARG002 -- a handler's form
        """Return whether the event is the end of this timer's period, or a shutdown."""
        return event == _TimeHasCome(self) or isinstance(event, ShutdownBegan)

    def respond(self, event: object, launch: Launch) -> Iterable[Step]:
        """Return the timer's steps at the end of the period; a shutdown may stop the wait."""
        if isinstance(event, ShutdownBegan) and self._ends_with_launch:
            self._ended.set()
        elif event == _TimeHasCome(self) and not self._is_cancelled():
            launch.unregister(self)
            return self._steps
        return ()

    def _wait(self, report: Callable[[TeleopctlError | None], None]) -> None:
        failed: TeleopctlError | None = None
        try:
            self._wait_for_clock()
        except TeleopctlError as error:
            failed = error
        except Exception as error:  # noqa: BLE001 -- else the launch would wait without end
            failed = LaunchError(f"ros_timer: {type(error).__name__}: {error}")
        report(failed)

    def _wait_for_clock(self) -> None:
        from teleopctl.node import Context, Node, Parameter, SingleThreadedExecutor

        with Context() as context:
            node = Node(
                "launch_ros_timer",
                context=context,
                use_global_arguments=False,
                parameter_overrides=[Parameter("use_sim_time", value=True)],
            )
            executor = SingleThreadedExecutor(context=context)
            executor.add_node(node)
            came = threading.Event()
            node.create_timer(self._seconds, came.set)
            while not (came.is_set() or self._ended.is_set() or self._is_cancelled()):
                executor.spin_once(timeout_sec=_LOOK_EVERY_S)
            if came.is_set():
                self._emit(_TimeHasCome(self))
            executor.shutdown()
            node.destroy_node()
