"""Log lines of the simulator about its robot at the start, and ``/performance_metrics``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from teleopctl.interfaces import get_message, set_stamp
from teleopctl.mujoco_model import FixedBy, assumed_rotors_text
from teleopctl.node import Clock

if TYPE_CHECKING:
    from teleopctl.mujoco_model import RobotModel
    from teleopctl.node import Node
    from teleopctl.robot import RobotDescription
    from teleopctl.sim.lockstep import LockstepLoop
    from teleopctl.sim.simulation import Simulation


class Logger(Protocol):
    """Interface of a logger with levels INFO and WARN."""

    def info(self, message: str, /) -> object:
        """Log at level INFO."""
        ...

    def warning(self, message: str, /) -> object:
        """Log at level WARN."""
        ...


def report_robot(logger: Logger, description: RobotDescription, model: RobotModel) -> None:
    """Log a robot's joints, interfaces and root link, as gz_ros2_control does at its start.

    Args:
        logger: Logger of the lines.
        description: The robot.
        model: Simulated model of the robot.
    """
    by_name = {joint.name: joint for joint in model.joints}
    for component in description.ros2_control:
        for info in component.joints:
            joint = by_name.get(info.name)
            if joint is None:
                continue
            logger.info(f"Loading joint: {joint.name}")
            logger.info("\tState:")
            for interface in joint.state_interfaces:
                logger.info(f"\t\t {interface}")
            logger.info("\tCommand:")
            for interface in joint.command_interfaces:
                logger.info(f"\t\t {interface}")
            if joint.mimic is not None:
                logger.info(
                    f"Joint '{joint.name}' is mimicking joint '{joint.mimic.joint}' with "
                    f"multiplier: {joint.mimic.multiplier:g}"
                )
        for step, done in (
            ("Initialize", "initialization"),
            ("'configure'", "'configure'"),
            ("'activate'", "'activate'"),
        ):
            logger.info(f"{step} hardware '{component.name}'")
            logger.info(f"Successful {done} of hardware '{component.name}'")
    if rotors := model.assumed_rotors():
        logger.info(assumed_rotors_text(rotors))
    _report_base(logger, description, model)
    if not description.ros2_control:
        logger.warning("No <ros2_control> in the robot description: nothing holds its joints")


def _report_base(logger: Logger, description: RobotDescription, model: RobotModel) -> None:
    """Log whether the robot's root link is fixed or free."""
    link, base, fixed = description.root, model.base, model.fixed
    if fixed is not None:
        if fixed.by is FixedBy.SHAPES:
            logger.info(
                f"The root link '{link}' is fixed to the world, since {fixed.by.value}; "
                "fixed_base:=false frees it, and so does <static>false</static> in <gazebo>. In "
                "Gazebo it is free without a link named 'world'"
            )
        elif fixed.by is not FixedBy.NAME:
            logger.info(f"The root link '{link}' is fixed to the world, as {fixed.by.value}")
    if base is None:
        return
    start = "starts resting on the ground" if base.rests else f"starts at z = {base.height_m:g} m"
    logger.info(
        f"The root link '{link}' is free, as in Gazebo, and {start}; fixed_base:=true fixes it "
        "to the world"
    )
    if not base.can_touch:
        logger.warning("The robot has no collision shapes: it falls through the ground")


_PerformanceMetrics = get_message("gazebo_msgs/msg/PerformanceMetrics")
# Period of the messages, in seconds of wall time.
_PERIOD_S = 1.0


class PerformancePublisher:
    """Publisher of the measured real-time factor on ``/performance_metrics``, once a second.

    Args:
        node: Node of the publisher.
        simulation: Simulation whose time stamps the messages.
        loop: Loop that runs the simulation.
    """

    def __init__(self, node: Node, simulation: Simulation, loop: LockstepLoop) -> None:
        self._simulation, self._loop = simulation, loop
        self._message = _PerformanceMetrics()
        self._publisher = node.create_publisher(_PerformanceMetrics, "/performance_metrics", 10)
        node.create_timer(_PERIOD_S, self._publish, clock=Clock())

    def _publish(self) -> None:
        if self._publisher.get_subscription_count() > 0:
            set_stamp(self._message.header.stamp, self._simulation.time_ns)
            self._message.real_time_factor = self._loop.reached_factor
            self._publisher.publish(self._message)
