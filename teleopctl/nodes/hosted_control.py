"""Controller manager in the simulator's process: joint states and commands pass in memory.

The physics thread calls the control cycle at each control tick, in the order read, update, write,
step; services of the two nodes run on threads of their own. The result is that of two processes,
bit for bit, without the messages between them.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from teleopctl.base import progress
from teleopctl.control import (
    ReceivedJointStates,
    TopicChannel,
    replace_topics,
)
from teleopctl.errors import TeleopctlError
from teleopctl.node import ExternalShutdownException
from teleopctl.nodes.controller_manager import controller_manager
from teleopctl.nodes.single_instance import AlreadyRunningError

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim import JointStateView, MujocoSim

# Longest wait for the end of the manager, in seconds of wall time.
_LONGEST_END_S = 5.0
_LONGEST_END_AFTER_ERROR_S = 1.0


class MemoryChannel:
    """Channel between simulator and controller manager: calls instead of messages.

    For the manager it is a JointStateChannel, for the simulator a HostedController.

    Attributes:
        has_started: Set once the simulator has built its model and sends states.
    """

    def __init__(self) -> None:
        self._simulator: MujocoSim | None = None
        self._topics: TopicChannel | None = None
        self._on_state: Callable[[ReceivedJointStates, int, bool], None] | None = None
        self._has_subscribers = False
        self._graph_lock = threading.RLock()
        self.has_started = threading.Event()
        self.published_ns = -1

    def set_simulator(self, simulator: MujocoSim) -> None:
        """Set the simulator that receives the commands."""
        self._simulator = simulator

    def set_manager(self, node: Node) -> None:
        """Set the manager's node; its hardware on the simulator's topics uses this channel."""
        assert self._simulator is not None
        states, commands = (
            str(self._simulator.get_parameter(name).value)
            for name in ("joint_states_topic", "joint_commands_topic")
        )
        self._topics = TopicChannel(node, states, commands)
        node.add_graph_callback(self._on_graph)
        replace_topics(node, states, commands, self)

    # --- for the simulator ------------------------------------------------------------------

    @property
    def is_connected(self) -> bool:
        """Whether hardware reads the states and is active."""
        return self._on_state is not None and self._topics is not None and self._topics.is_sending

    def simulation_started(self) -> None:
        """Record that states arrive from now on."""
        self.has_started.set()

    def update(self, states: JointStateView, time_ns: int, reset: bool) -> None:
        """Run the control cycle for the states of a control tick."""
        if self._on_state is not None:
            self._on_state(states, time_ns, reset)

    # --- for the manager --------------------------------------------------------------------

    def open(self, on_state: Callable[[ReceivedJointStates, int, bool], None]) -> None:
        """Start to receive states."""
        self._on_state = on_state
        self._changed()

    def close(self) -> None:
        """Stop receiving states."""
        self._on_state = None
        self._changed()

    def absence(self) -> str:
        """Return an empty text: the simulator is in this process."""
        return ""

    def start_sending(self) -> None:
        """Create the publisher of the commands, for subscribers other than the simulator."""
        assert self._topics is not None
        self._topics.start_sending()
        self._changed()

    def stop_sending(self) -> None:
        """Destroy the publisher of the commands."""
        assert self._topics is not None
        self._topics.stop_sending()
        self._changed()

    def send(self, time_ns: int, names: list[str], columns: Mapping[str, list[float]]) -> None:
        """Pass the commands to the simulator; publish them if their topic has subscribers."""
        assert self._simulator is not None
        assert self._topics is not None
        get = columns.get
        self._simulator.receive_command(
            time_ns, names, get("position", []), get("velocity", []), get("effort", [])
        )
        if self._has_subscribers:
            self.published_ns = time_ns
            self._topics.send(time_ns, names, columns)

    def _on_graph(self) -> None:
        with self._graph_lock:
            # The simulator subscribes as well, for commands of other programs.
            others = self._topics is not None and self._topics.get_subscription_count() > 1
            self._has_subscribers = others

    def _changed(self) -> None:
        assert self._simulator is not None
        self._on_graph()
        self._simulator.controller_changed()


@contextlib.contextmanager
def hosted_control(
    simulator: MujocoSim,
    channel: MemoryChannel,
    arguments: Sequence[str],
    *,
    unless_running: bool = False,
) -> Iterator[None]:
    """Context manager that runs a controller manager beside a simulator, on a thread of its own.

    Args:
        simulator: The simulator's node; an exception in the manager is raised where it spins.
        channel: Channel between the two.
        arguments: Command line with the manager's ROS arguments.
        unless_running: Whether another controller manager of that name, if one runs, controls the
            robot; otherwise it is an error.
    """
    ended = threading.Event()
    stop: list[Callable[[], object]] = []

    def run() -> None:
        try:
            with (
                controller_manager(
                    arguments,
                    is_process=False,
                    prepare=channel.set_manager,
                    on_failure=simulator.fail,
                    simulation_started=channel.has_started,
                ) as executor,
                contextlib.suppress(ExternalShutdownException),
            ):
                stop.append(executor.shutdown)
                if not ended.is_set():
                    executor.spin()
        except AlreadyRunningError as error:
            if not unless_running:
                simulator.fail(error)
                return
            simulator.get_logger().warning(
                "A controller manager of this name runs already: it controls the robot, and none "
                "is started here. A launch file for Gazebo needs no ros2_control_node"
            )
            progress.report(progress.READY, part=progress.CONTROL)
        except Exception as error:  # noqa: BLE001 - raised where the simulator spins
            simulator.fail(error)

    thread = threading.Thread(target=run, name="controller_manager", daemon=True)
    thread.start()
    longest_end_s = _LONGEST_END_S
    try:
        yield
    except TeleopctlError:
        # A controller that does not return keeps the manager from ending.
        longest_end_s = _LONGEST_END_AFTER_ERROR_S
        raise
    finally:
        # First, so that physics does not advance without its controllers.
        simulator.stop()
        ended.set()
        # A manager that waits for the simulation waits no longer.
        channel.has_started.set()
        for end in stop:
            end()
        thread.join(longest_end_s)
