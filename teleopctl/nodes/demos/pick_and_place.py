"""Executable ``pick_and_place``: the teleop arm takes a cube from a table into a bin.

The cube is put to random places on the table, found by its pose on
``/mujoco_sim/free_joint_states``, grasped by friction, carried and dropped; the result says how
often it lay in the bin. A program of its own for another arm needs the same steps.
"""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import Arm, MotionPlan, MotionSettings
from teleopctl.node import (
    ExternalShutdownException,
    Node,
    SingleThreadedExecutor,
    init,
    parse_ros_arguments,
    qos_profile_latched,
)
from teleopctl.nodes.moveit.move_group.controllers import (
    Controllers,
    choose_controllers,
    goal_for,
)
from teleopctl.nodes.moveit.move_group.messages import write_trajectory
from teleopctl.nodes.teleop.gripper import GripperCommander
from teleopctl.robot import RobotDescription

# Point between the fingertips in the frame of claw_support, m.
_GRASP = (-0.13, 0.596, -0.106)
_GRIPPER, _OPEN, _CLOSED = "joint_4", -1.5, 0.0
# Places of the cube: angle about joint_1 from the arm's zero, distance from its axis, m, height, m,
# and how far it is turned from the direction of the fingers, rad.
_ANGLES, _DISTANCES = (-0.25, 0.22), (1.42, 1.56)
_CUBE_Z, _YAW = 0.171, 0.15
# Height, m, from which the fingers come down, and to which they lift the cube.
_ABOVE_M = 0.25
# Where the cube is dropped, in the world, m; the bin around it, half of its width.
_DROP, _BIN_HALF_M = (-1.3, 0.75, 0.5), 0.2
# Parts of the velocity limits: of free motions, and of those near the cube and with it.
_FREE, _CAREFUL = 0.1, 0.03
_LONGEST_S = 30.0
# action_msgs/msg/GoalStatus.STATUS_SUCCEEDED.
_SUCCEEDED = 4

# Any, here and below: message classes are generated at run time from definitions.


class PickAndPlace(Node):
    """Node that moves the arm and its gripper, and sees the cube."""

    def __init__(self) -> None:
        super().__init__("pick_and_place")
        self._urdf = ""
        self._positions: dict[str, float] = {}
        self._moved_s = 0.0
        self._cube: Any = None
        self._arm: Arm | None = None
        self.create_subscription(
            get_message("std_msgs/msg/String"),
            "robot_description",
            self._on_description,
            qos_profile_latched,
        )
        self.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "joint_states", self._on_states, 1
        )
        self.create_subscription(
            get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray"),
            "/mujoco_sim/free_joint_states",
            self._on_bodies,
            1,
        )
        self._place = self.create_client(
            get_service("mujoco_ros2_control_msgs/srv/SetFreeJointState"),
            "/mujoco_sim/set_free_joint_state",
        )
        self._controllers = Controllers(self)

    # --- what is received -------------------------------------------------------------------------

    def _on_description(self, message: Any) -> None:
        self._urdf = message.data

    def _on_states(self, message: Any) -> None:
        new = dict(zip(message.name, message.position, strict=False))
        if any(abs(at - self._positions.get(name, math.inf)) > 1e-4 for name, at in new.items()):
            self._moved_s = time.monotonic()
        self._positions = new

    def _on_bodies(self, message: Any) -> None:
        for body in message.free_joints:
            if body.name == "cube":
                self._cube = body.pose.pose

    def cube(self) -> np.ndarray:
        """Return the position of the cube in the world, (3,), m."""
        at = self._cube.position
        return np.array([at.x, at.y, at.z])

    # --- steps ------------------------------------------------------------------------------------

    def prepare(self) -> None:
        """Wait for the robot and its simulation.

        Raises:
            UnavailableError: They do not come.
        """
        self._wait(lambda: self._urdf, "the robot's description")
        description = RobotDescription.from_urdf(self._urdf)
        if _GRIPPER not in description.joints or "claw_support" not in description.links:
            raise NotFoundError(
                f"The robot '{description.name}' is not the teleop arm, for which this program is"
            )
        self._arm = Arm(description, tool=_GRASP)
        self._wait(lambda: self._positions, "the states of the joints")
        self._gripper = GripperCommander(self, _GRIPPER, 10.0)
        self._wait(lambda: self._cube is not None, "a cube in the simulation")
        self._wait(self._place.service_is_ready, "the simulator's services")
        self._wait(lambda: self._gripper.is_available, "an active controller of the gripper")

    def put(self, angle: float, distance_m: float, yaw: float) -> None:
        """Put the cube onto the table: at an angle about the arm's base, turned by a yaw, rad."""
        kind: Any = get_message("mujoco_ros2_control_msgs/msg/FreeJointState")
        body = kind(name="cube")
        body.pose.header.frame_id = "world"
        turned = math.atan2(1.5, -0.15) + angle
        at, rotation = body.pose.pose.position, body.pose.pose.orientation
        at.x, at.y, at.z = distance_m * math.cos(turned), distance_m * math.sin(turned), _CUBE_Z
        rotation.z, rotation.w = math.sin(0.5 * (angle + yaw)), math.cos(0.5 * (angle + yaw))
        request: Any = get_service("mujoco_ros2_control_msgs/srv/SetFreeJointState").Request()
        request.free_joints = [body]
        self._place.call(request)
        wanted = np.array([at.x, at.y])
        self._wait(lambda: bool(np.linalg.norm(self.cube()[:2] - wanted) < 0.01), "the cube")

    def take(self) -> None:
        """Grasp the cube from above, and lift it."""
        self._grip(_OPEN)
        cube = self.cube()
        self._move_to(cube + np.array([0.0, 0.0, _ABOVE_M]), _FREE)
        self._move_to(cube, _CAREFUL)
        self._grip(_CLOSED)
        self._move_to(cube + np.array([0.0, 0.0, _ABOVE_M]), _CAREFUL)

    def drop(self) -> bool:
        """Carry the cube over the bin, let it go, and return whether it lies there."""
        self._move_to(np.array(_DROP), _CAREFUL)
        self._grip(_OPEN)
        before = self.cube()

        def lies() -> bool:
            nonlocal before
            moved, before = float(np.linalg.norm(self.cube() - before)), self.cube()
            return moved < 1e-3 and bool(before[2] < 0.3)

        try:
            self._wait(lies, "the cube to lie", 5.0)
        except UnavailableError:
            return False
        away = np.abs(self.cube()[:2] - np.array(_DROP[:2]))
        return bool((away < _BIN_HALF_M).all())

    # --- motions ----------------------------------------------------------------------------------

    def _here(self) -> dict[str, float]:
        assert self._arm is not None
        return {name: self._positions[name] for name in self._arm.names}

    def _move_to(self, position: np.ndarray, speed: float) -> None:
        assert self._arm is not None
        settings = MotionSettings(velocity_scaling=speed, acceleration_scaling=speed)
        self._execute(self._arm.plan(position, self._here(), settings, is_position=True))

    def _execute(self, plan: MotionPlan) -> None:
        trajectory = write_trajectory(plan, "").joint_trajectory
        chosen, left = choose_controllers(plan.joint_names, self._controllers.available())
        if left:
            raise UnavailableError(f"No active controller takes trajectories of {', '.join(left)}")
        for controller in chosen:
            client = self._controllers.client(controller)
            sent = client.send_goal_async(goal_for(controller, trajectory, self._positions))
            self._wait(sent.done, f"an answer of '{controller.name}'")
            handle = sent.result()
            if handle is None or not handle.accepted:
                raise UnavailableError(f"'{controller.name}' has rejected a motion")
            ended = handle.get_result_async()
            self._wait(ended.done, f"the end of a motion of '{controller.name}'")
            response = ended.result()
            if response is None or response.status != _SUCCEEDED:
                raise UnavailableError(f"'{controller.name}' has not executed a motion to its end")

    def _grip(self, position: float) -> None:
        self._gripper.move(position, self._positions)
        begun = self._moved_s = time.monotonic()
        self._wait(
            lambda: time.monotonic() - max(begun, self._moved_s) > 0.5, "the gripper to stand"
        )

    def _wait(
        self, condition: Callable[[], object], what: str, timeout_s: float = _LONGEST_S
    ) -> None:
        end_s = time.monotonic() + timeout_s
        while not condition():
            if not self.context.ok():
                raise ExternalShutdownException
            if time.monotonic() > end_s:
                raise UnavailableError(f"Waited {timeout_s:g} s for {what} in vain")
            self.context.wait_for_change(lambda: bool(condition()), 0.05)


def main(args: Sequence[str] | None = None) -> int:
    """Take the cube as often as asked for, and return 0 if it came into the bin each time.

    Raises:
        TeleopctlError: The robot is another one, or does not come.
    """
    arguments = sys.argv if args is None else args
    parser = argparse.ArgumentParser(prog="pick_and_place", description="Take a cube into a bin.")
    parser.add_argument("--times", type=int, default=20, help="how often")
    parser.add_argument("--seed", type=int, default=0, help="seed of the cube's places")
    options = parser.parse_args(parse_ros_arguments(arguments).program[1:])
    random = np.random.default_rng(options.seed)
    done = 0
    with init(args=arguments):
        node = PickAndPlace()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        threading.Thread(target=executor.spin, daemon=True).start()
        try:
            node.prepare()
            for number in range(1, options.times + 1):
                node.put(
                    random.uniform(*_ANGLES),
                    random.uniform(*_DISTANCES),
                    random.uniform(-_YAW, _YAW),
                )
                try:
                    node.take()
                    succeeded = node.drop()
                except TeleopctlError as error:
                    node.get_logger().error(error.message)
                    succeeded = False
                done += succeeded
                where = "in the bin" if succeeded else f"at {np.round(node.cube(), 2).tolist()}"
                node.get_logger().info(f"{number} of {options.times}: the cube is {where}")
            node.get_logger().info(f"{done} of {options.times} cubes are in the bin")
        except (KeyboardInterrupt, ExternalShutdownException):
            return 130
        finally:
            executor.shutdown()
    return 0 if done == options.times else 1
