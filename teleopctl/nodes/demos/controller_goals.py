"""Programs of ``ros2_controllers_test_nodes``: they send goals from parameters to a controller.

The launch files of ros2_control_demos start them to move a robot back and forth. Names of nodes,
parameters and topics are those of ROS 2; see
https://github.com/ros-controls/ros2_controllers/tree/master/ros2_controllers_test_nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from teleopctl.errors import InvalidParameterError
from teleopctl.nodes.demos import run

# Time in which a trajectory controller reaches a goal, s.
_REACHED_S = 4
_WHOLE_TURN = 2 * 3.14159
_QUANTITIES = ("positions", "velocities", "accelerations", "effort")


def _numbers(node: Node, name: str) -> list[float]:
    """Return a parameter that is a list of numbers; empty if it is not set."""
    node.declare_parameter(name, Parameter.Type.DOUBLE_ARRAY)
    return [float(value) for value in node.get_parameter_or(name).value or ()]


class ForwardPositionPublisher(Node):
    """Node that publishes the goals ``goal_names`` in turn as ``Float64MultiArray``.

    Parameters: ``publish_topic``, ``wait_sec_between_publish`` (s), ``goal_names``, and a list of
    positions (rad or m) for each of these names.

    Raises:
        InvalidParameterError: A goal has no values.
    """

    def __init__(self) -> None:
        super().__init__("publisher_forward_position_controller")
        topic = self.declare_parameter("publish_topic", "/position_commands").value
        period_s = self.declare_parameter("wait_sec_between_publish", 5).value
        names = self.declare_parameter("goal_names", ["pos1", "pos2"]).value
        goals = {name: _numbers(self, name) for name in names}
        for name, goal in goals.items():
            if not goal:
                raise InvalidParameterError(f"Values for goal '{name}' not set!")
        self._goals = cycle(goals.values())
        self._publisher = self.create_publisher(Float64MultiArray, topic, 1)
        self.create_timer(float(period_s), self._publish)
        self.get_logger().info(
            f"Publishing {len(names)} goals on topic '{topic}' every {period_s} s"
        )

    def _publish(self) -> None:
        message = Float64MultiArray(data=next(self._goals))
        self.get_logger().info(f'Publishing: "{message.data}"')
        self._publisher.publish(message)


class JointTrajectoryPublisher(Node):
    """Node that publishes the goals ``goal_names`` in turn as trajectories of one point.

    Parameters: ``controller_name``, ``wait_sec_between_publish`` (s), ``joints``, ``goal_names``;
    for each goal a list per joint of ``positions`` (rad or m), ``velocities``, ``accelerations`` or
    ``effort``; ``check_starting_point``, and then ``starting_point_limits.JOINT`` (lower and upper
    position of the first joint state).

    Raises:
        InvalidParameterError: No joints are named, a limit is not two numbers, or no goal is valid.
    """

    def __init__(self) -> None:
        super().__init__("publisher_position_trajectory_controller")
        controller = self.declare_parameter("controller_name", "position_trajectory_controller")
        period_s = self.declare_parameter("wait_sec_between_publish", 6).value
        names = self.declare_parameter("goal_names", ["pos1", "pos2"]).value
        self._joints = [name for name in self.declare_parameter("joints", [""]).value if name]
        checks = self.declare_parameter("check_starting_point", False).value
        if not self._joints:
            raise InvalidParameterError("'joints' parameter is not set!")
        # Why nothing is published yet; empty once the start is known to be within its limits.
        self._waits_for = ""
        if checks:
            self._limits = {name: self._limits_of(name) for name in self._joints}
            self._waits_for = 'Start configuration could not be checked! Check "joint_state" topic!'
            self._states = self.create_subscription(
                JointState, "joint_states", self._check_start, 10
            )
        goals = [goal for name in names if (goal := self._goal(name)) is not None]
        if not goals:
            raise InvalidParameterError("No valid goal found. Exiting...")
        self._goals = cycle(goals)
        topic = f"/{controller.value}/joint_trajectory"
        self._publisher = self.create_publisher(JointTrajectory, topic, 1)
        self.create_timer(float(period_s), self._publish)
        self.get_logger().info(
            f"Publishing {len(names)} goals on topic '{topic}' every {period_s} s"
        )

    def _limits_of(self, joint: str) -> tuple[float, float]:
        name = f"starting_point_limits.{joint}"
        limits = self.declare_parameter(name, [-_WHOLE_TURN, _WHOLE_TURN]).value
        if len(limits) != 2:
            raise InvalidParameterError(f"'{name}' is not a lower and an upper position")
        return limits[0], limits[1]

    def _goal(self, name: str) -> JointTrajectoryPoint | None:
        given = {each: _numbers(self, f"{name}.{each}") for each in _QUANTITIES}
        valid = {each: list_ for each, list_ in given.items() if len(list_) == len(self._joints)}
        if not valid:
            self.get_logger().warning(
                f'Goal "{name}" definition is wrong. This goal will not be used. '
                f"It needs one of {', '.join(_QUANTITIES)}: a list of {len(self._joints)} numbers"
            )
            return None
        return JointTrajectoryPoint(time_from_start=Duration(sec=_REACHED_S), **valid)

    def _check_start(self, message: JointState) -> None:
        self.destroy_subscription(self._states)
        self._waits_for = ""
        for name, position in zip(message.name, message.position, strict=True):
            lower, upper = self._limits.get(name, (position, position))
            if not lower <= position <= upper:
                self.get_logger().warning(f"Starting point limits exceeded for joint {name} !")
                self._waits_for = "Start configuration is not within configured limits!"

    def _publish(self) -> None:
        if self._waits_for:
            self.get_logger().warning(self._waits_for)
            return
        goal = next(self._goals)
        self.get_logger().info(f"Sending goal {goal}.")
        self._publisher.publish(JointTrajectory(joint_names=self._joints, points=[goal]))


def publisher_forward_position_controller(args: Sequence[str] | None = None) -> None:
    """Publish the positions of the parameters to a controller, in turn, until Ctrl-C."""
    run(ForwardPositionPublisher, list(args) if args is not None else None)


def publisher_joint_trajectory_controller(args: Sequence[str] | None = None) -> None:
    """Publish the trajectories of the parameters to a controller, in turn, until Ctrl-C."""
    run(JointTrajectoryPublisher, list(args) if args is not None else None)
