"""Executable ``joint_state_publisher``: publishes positions of joints without sensors.

Publishes ``joint_states`` at ``rate`` (Hz): every movable joint of the description at its zero
position, or at the position received on the topics of ``source_list``.
"""

import argparse
import contextlib
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from teleopctl.base import progress
from teleopctl.base.files import read_text
from teleopctl.errors import InvalidParameterError, TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    Parameter,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    spin,
)
from teleopctl.robot import Joints, JointSet, Mimic, RobotDescription


class JointStatePublisher(Node):
    """Node that publishes ``joint_states``: default positions, or those of source topics.

    The description is read from a file, else from the parameter ``robot_description``, else from
    the topic of that name. A new description on the topic replaces the present one.

    Args:
        urdf: Robot description as URDF text; None for the parameter or topic.
        name: Name of the node.
        sources: Topics to subscribe to in addition to those of ``source_list``.
    """

    def __init__(
        self,
        urdf: str | None = None,
        *,
        name: str = "joint_state_publisher",
        sources: Sequence[str] = (),
    ) -> None:
        progress.report(progress.STARTING)
        super().__init__(
            name,
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        self._joints: JointSet | None = None
        self._delta = float(self._parameter("delta", 0.0))
        self._defaults = {
            quantity: bool(self._parameter(f"publish_default_{name}", quantity == "position"))
            for quantity, name in (
                ("position", "positions"),
                ("velocity", "velocities"),
                ("effort", "efforts"),
            )
        }
        self._received = {"position": False, "velocity": False, "effort": False}
        self._joint_state = get_message("sensor_msgs/msg/JointState")
        self._publisher = self.create_publisher(self._joint_state, "joint_states", 10)
        urdf = urdf or str(self._parameter("robot_description", ""))
        if urdf:
            self._take_description(urdf)
        else:
            progress.report(progress.WAITING, self.resolve_topic_name("robot_description"))
            self.get_logger().info(
                "Waiting for robot_description to be published on the robot_description topic..."
            )
        self.create_subscription(
            get_message("std_msgs/msg/String"),
            "robot_description",
            lambda message: self._take_description(message.data),
            qos_profile_latched,
        )
        for topic in dict.fromkeys((*(self._parameter("source_list", []) or ()), *sources)):
            self.create_subscription(self._joint_state, topic, self._take_source, 10)
        rate = float(self._parameter("rate", 10))
        if rate <= 0:
            raise InvalidParameterError(f"rate should be positive, got {rate}")
        self.create_timer(1.0 / rate, self._publish)

    def _parameter(self, name: str, default: Any) -> Any:
        """Return the value of a parameter; declare it unless an override has declared it."""
        if not self.has_parameter(name):
            self.declare_parameter(name, Parameter.Type.STRING_ARRAY if default == [] else default)
        return self.get_parameter_or(name, Parameter(name, value=default)).value

    def _take_description(self, urdf: str) -> None:
        try:
            description = RobotDescription.from_urdf(urdf)
            before, self._joints = self._joints, self._joint_set(description)
        except TeleopctlError as error:
            self.get_logger().error(f"robot_description is not used: {error.message}")
            progress.report(progress.FAILED, f"robot_description is not used: {error.message}")
            return
        progress.report(progress.READY)
        if before is not None:
            # A new description of the same robot keeps the joint positions.
            self._joints.update(before.names, before.positions())

    def _joint_set(self, description: RobotDescription) -> JointSet:
        zeros = {
            name: float(parameter.value)
            for name, parameter in self.get_parameters_by_prefix("zeros").items()
        }
        dependents: dict[str, Mimic] = {}
        for name, parameter in self.get_parameters_by_prefix("dependent_joints").items():
            joint, _, field = name.rpartition(".")
            if field == "parent":
                prefix = f"dependent_joints.{joint}"
                dependents[joint] = Mimic(
                    str(parameter.value),
                    float(self._parameter(f"{prefix}.factor", 1.0)),
                    float(self._parameter(f"{prefix}.offset", 0.0)),
                )
        return JointSet(
            Joints.for_display(description, self.get_logger().warning),
            zeros=zeros,
            dependents=dependents,
            use_mimic_tags=bool(self._parameter("use_mimic_tags", True)),
            use_smallest_limits=bool(self._parameter("use_smallest_joint_limits", True)),
        )

    def _take_source(self, state: Any) -> None:
        if self._joints is None:
            return
        self._joints.update(state.name, state.position, state.velocity, state.effort)
        for quantity, received in self._received.items():
            self._received[quantity] = received or len(getattr(state, quantity)) > 0

    def _publish(self) -> None:
        joints = self._joints
        if joints is None:
            return
        if self._delta > 0:
            joints.advance(self._delta)
        state = self._joint_state(name=joints.names)
        state.header.stamp = self.get_clock().now().to_msg()
        if self._defaults["position"] or self._received["position"] or self._delta > 0:
            state.position = joints.positions()
        for quantity in ("velocity", "effort"):
            if self._defaults[quantity] or self._received[quantity]:
                setattr(state, quantity, joints.derivatives(quantity))
        self._publisher.publish(state)


def main(args: list[str] | None = None) -> int:
    """Run ``joint_state_publisher`` until Ctrl-C or a shutdown; return the exit status.

    Args:
        args: Command line, optionally with the file of the description; None takes ``sys.argv``.

    Raises:
        TeleopctlError: The file cannot be read or a parameter is wrong.
    """
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(prog="joint_state_publisher")
    parser.add_argument("urdf_file", nargs="?", help="URDF file, instead of the topic")
    options = parser.parse_args(parse_ros_arguments(words).program)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=words),
        JointStatePublisher(read_description(options.urdf_file)) as node,
    ):
        spin(node)
    return 0


def read_description(file: str | None) -> str | None:
    """Return the robot description in a URDF or xacro file, as URDF; None if ``file`` is None.

    Raises:
        TeleopctlError: The file cannot be read.
    """
    if file is None:
        return None
    path = Path(file)
    if path.suffix == ".xacro":
        from teleopctl.robot import expand_xacro

        return expand_xacro(path)
    return read_text(path)
