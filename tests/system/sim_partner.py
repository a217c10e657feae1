"""Counterpart of the simulator: robot_state_publisher and controller in one node."""

import contextlib
import threading
from collections.abc import Callable
from typing import Any

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import (
    Context,
    ExternalShutdownException,
    Node,
    Publisher,
    SingleThreadedExecutor,
    qos_profile_latched,
)
from teleopctl.packages import package_share
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.testing import LONGEST_WAIT_S

JointState: Any = get_message("sensor_msgs/msg/JointState")
String: Any = get_message("std_msgs/msg/String")
Clock: Any = get_message("rosgraph_msgs/msg/Clock")

# Function that returns a command for a state, or None.
Answer = Callable[[Any], Any]


def teleop_urdf(**mappings: str) -> str:
    """Return the URDF of the teleop arm."""
    file = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    return expand_xacro(str(file), mappings)


def stamp_ns(message) -> int:
    """Return the stamp of a message with a header, in nanoseconds."""
    return int(message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)


def command(state, **positions: float) -> Any:
    """Return a position command with the stamp of a state."""
    answer = JointState(name=list(positions), position=list(positions.values()))
    answer.header.stamp = state.header.stamp
    return answer


class Partner(Node):
    """Node that publishes the description and commands, and stores received states and clocks."""

    def __init__(self, urdf: str) -> None:
        self._own = Context()
        self._own.init(args=[])
        super().__init__("partner", context=self._own, start_parameter_services=False)
        self.states: list[Any] = []
        self.clocks: list[int] = []
        self.answer: Answer = lambda state: None
        self._changed = threading.Condition()
        self._description = self.create_publisher(String, "/robot_description", qos_profile_latched)
        self.describe(urdf)
        self.create_subscription(Clock, "/clock", self._on_clock, 10, immediate=True)
        self._executor_of_test = SingleThreadedExecutor(context=self._own)
        self._executor_of_test.add_node(self)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()
        self.commands: Publisher[Any] | None = None

    def describe(self, urdf: str) -> None:
        """Publish a robot description."""
        self._description.publish(String(data=urdf))

    def connect(self, answer: Answer) -> None:
        """Start to answer states with commands, as a controller; wait for the simulator."""
        self.answer = answer
        self.create_subscription(
            JointState, "/robot_joint_states", self._on_state, 10, immediate=True
        )
        self.commands = self.create_publisher(JointState, "/robot_joint_commands", 10)
        assert self.wait_for_subscribers("/robot_joint_commands", 1, LONGEST_WAIT_S)
        # The simulator publishes its state for each new subscriber. A subscriber that is declared
        # after the controller's topics receives it when the simulator has discovered those too.
        seen = threading.Event()
        shown = self.create_subscription(
            JointState, "/mujoco_sim/joint_states", lambda _: seen.set(), 10, immediate=True
        )
        assert seen.wait(LONGEST_WAIT_S)
        self.destroy_subscription(shown)

    def disconnect(self) -> None:
        """Stop to publish commands; states are still received."""
        commands, self.commands = self.commands, None
        assert commands is not None
        self.destroy_publisher(commands)

    def wait(self, what: Callable[[], object], timeout_s: float = LONGEST_WAIT_S) -> None:
        """Wait until a condition on received states or clocks is true."""
        with self._changed:
            assert self._changed.wait_for(what, timeout_s), f"{len(self.states)} states came"

    def wait_for_states(self, count: int) -> list[Any]:
        """Wait for a number of states, and return them."""
        self.wait(lambda: len(self.states) >= count)
        return self.states[:count]

    def call(self, service: str, name: str, **request):
        """Call a service of the simulator, and return the response."""
        kind = get_service(f"mujoco_ros2_control_msgs/srv/{service}")
        return self.call_as(kind, f"/mujoco_sim/{name}", kind.Request(**request))

    def call_as(self, kind: Any, name: str, request: Any) -> Any:
        """Call a service by type and name, and return the response."""
        client = self.create_client(kind, name)
        assert client.wait_for_service(LONGEST_WAIT_S)
        return client.call(request, timeout_sec=LONGEST_WAIT_S)

    def close(self) -> None:
        """Shut down the node's context and thread."""
        self._own.try_shutdown()
        self._thread.join(LONGEST_WAIT_S)

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor_of_test.spin()

    def _on_state(self, state: Any) -> None:
        answer = self.answer(state)
        if answer is not None and self.commands is not None:
            self.commands.publish(answer)
        with self._changed:
            self.states.append(state)
            self._changed.notify_all()

    def _on_clock(self, message: Any) -> None:
        with self._changed:
            self.clocks.append(message.clock.sec * 1_000_000_000 + message.clock.nanosec)
            self._changed.notify_all()
