"""Executable ``pick_and_place``: the teleop arm takes a cube from a table into a bin.

The cube is put to random places on the table, found by its pose on
``/mujoco_sim/free_joint_states``, grasped by friction, carried and dropped; the result says how
often it lay in the bin. A program of its own for another arm needs the same steps.

The program advances the simulation itself, which is paused while it plans: each decision is made at
a defined simulated time, so the same seed gives the same bits, on any machine load.
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

from teleopctl.commander import (
    Controllers,
    choose_controllers,
    goal_for,
    write_joint_trajectory,
)
from teleopctl.errors import NotFoundError, TeleopctlError, UnavailableError
from teleopctl.interfaces import from_seconds, get_message, get_service, set_stamp, to_nanoseconds
from teleopctl.kinematics import Arm, MotionSettings
from teleopctl.node import (
    ExternalShutdownException,
    Future,
    Node,
    SingleThreadedExecutor,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    spin_in_thread,
)
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
# Parts of the velocity limits: of free motions, and of those near the cube and with it; and the
# speed of the gripper, rad/s.
_FREE, _CAREFUL = 0.1, 0.03
_GRIPPER_SPEED = 5.0
# Longest wait for another process, s of wall time.
_LONGEST_S = 30.0
# Physics steps at once, and their time.
_STEPS, _STEP_NS = 50, 50_000_000
# Simulated time after a motion's last point at which its controller has ended it: two cycles, s.
_ENDED_S = 0.2
# Fingers stand if no joint moved by more than this (rad) for so long (s), and the cube lies if it
# moved less than this (m) in one advance; both are given up after some time, s.
_STILL_RAD, _STILL_S, _STILL_M, _GIVEN_UP_S = 1e-4, 0.5, 1e-3, 5.0
# Delay, s of wall time, that is made up.
_MOST_LAG_S = 0.25
# action_msgs/msg/GoalStatus.STATUS_SUCCEEDED.
_SUCCEEDED = 4

# Any, here and below: message classes are generated at run time from definitions.


class PickAndPlace(Node):
    """Node that moves the arm and its gripper, locates the cube, and advances the simulation.

    Args:
        real_time_factor: Simulated seconds per second of wall time; 0 for as fast as possible.
    """

    def __init__(self, real_time_factor: float = 1.0) -> None:
        super().__init__("pick_and_place")
        self._factor = real_time_factor
        self._urdf = ""
        self._positions: dict[str, float] = {}
        self._cube: Any = None
        self._arm: Arm | None = None
        # Simulated time of the program, and those of what was received; -1 before.
        self._now_ns = self._states_ns = self._bodies_ns = -1
        self._due_s = 0.0
        self.create_subscription(
            get_message("std_msgs/msg/String"),
            "robot_description",
            self._on_description,
            qos_profile_latched,
        )
        # The simulator's own states: controllers publish theirs only while time advances.
        self.create_subscription(
            get_message("sensor_msgs/msg/JointState"),
            "/mujoco_sim/joint_states",
            self._on_states,
            1,
        )
        self.create_subscription(
            get_message("mujoco_ros2_control_msgs/msg/FreeJointStateArray"),
            "/mujoco_sim/free_joint_states",
            self._on_bodies,
            1,
        )
        self._pause, self._step, self._place = (
            self.create_client(
                get_service(f"mujoco_ros2_control_msgs/srv/{kind}"), f"/mujoco_sim/{name}"
            )
            for kind, name in (
                ("SetPause", "set_pause"),
                ("StepSimulation", "step_simulation"),
                ("SetFreeJointState", "set_free_joint_state"),
            )
        )
        trigger = get_service("std_srvs/srv/Trigger")
        self._episodes = {
            name: self.create_client(trigger, f"/episode_recorder/{name}")
            for name in ("start", "success", "save")
        }
        self._controllers = Controllers(self)
        self._changed = threading.Condition()

    # --- what is received -------------------------------------------------------------------------

    def _on_description(self, message: Any) -> None:
        self._urdf = message.data
        self._notify()

    def _on_states(self, message: Any) -> None:
        self._positions = dict(zip(message.name, message.position, strict=False))
        self._states_ns = to_nanoseconds(message.header.stamp)
        self._notify()

    def _on_bodies(self, message: Any) -> None:
        for body in message.free_joints:
            if body.name == "cube":
                self._cube = body.pose.pose
        self._bodies_ns = to_nanoseconds(message.header.stamp)
        self._notify()

    def _notify(self, _: object = None) -> None:
        with self._changed:
            self._changed.notify_all()

    def cube(self) -> np.ndarray:
        """Return the position of the cube in the world, (3,), m."""
        at = self._cube.position
        return np.array([at.x, at.y, at.z])

    # --- steps ------------------------------------------------------------------------------------

    def prepare(self) -> None:
        """Wait for the robot and its simulation, and pause it.

        Raises:
            NotFoundError: The robot is another one.
            UnavailableError: They do not come.
        """
        self._wait(lambda: self._urdf, "the robot's description")
        description = RobotDescription.from_urdf(self._urdf)
        if _GRIPPER not in description.joints or "claw_support" not in description.links:
            raise NotFoundError(
                f"The robot '{description.name}' is not the teleop arm, for which this program is"
            )
        self._arm = Arm(description, tool=_GRASP)
        self._wait(self._place.service_is_ready, "the simulator's services")
        wanted = (*self._arm.names, _GRIPPER)
        self._wait(lambda: self._is_controlled(wanted), "active controllers of all joints")
        self._request(self._pause, paused=True)
        self._wait(lambda: self._positions, "the states of the joints")
        self._wait(lambda: self._cube is not None, "a cube in the simulation")
        self._now_ns = self._states_ns
        self._due_s = time.monotonic()
        self._advance()

    def put(self, angle: float, distance_m: float, yaw: float) -> None:
        """Put the cube onto the table: at an angle about the arm's base, turned by a yaw, rad."""
        kind: Any = get_message("mujoco_ros2_control_msgs/msg/FreeJointState")
        body = kind(name="cube")
        body.pose.header.frame_id = "world"
        turned = math.atan2(1.5, -0.15) + angle
        at, rotation = body.pose.pose.position, body.pose.pose.orientation
        at.x, at.y, at.z = distance_m * math.cos(turned), distance_m * math.sin(turned), _CUBE_Z
        rotation.z, rotation.w = math.sin(0.5 * (angle + yaw)), math.cos(0.5 * (angle + yaw))
        self._request(self._place, free_joints=[body])
        wanted = np.array([at.x, at.y])
        self._wait(lambda: bool(np.linalg.norm(self.cube()[:2] - wanted) < 0.01), "the cube")

    def record(self, *names: str) -> None:
        """Request a step of episode_recorder: ``start``, ``success``, ``save``."""
        for name in names:
            self._wait(self._episodes[name].service_is_ready, "episode_recorder")
            self._request(self._episodes[name])

    def take(self) -> None:
        """Grasp the cube from above, and lift it."""
        self._grip(_OPEN)
        cube = self.cube()
        self._move_to(cube + np.array([0.0, 0.0, _ABOVE_M]), _FREE)
        self._move_to(cube, _CAREFUL)
        self._grip(_CLOSED)
        self._move_to(cube + np.array([0.0, 0.0, _ABOVE_M]), _CAREFUL)

    def drop(self) -> bool:
        """Carry the cube over the bin, release it, and return whether it lies there."""
        self._move_to(np.array(_DROP), _CAREFUL)
        self._grip(_OPEN)
        end_ns = self._now_ns + round(_GIVEN_UP_S * 1e9)
        while self._now_ns < end_ns:
            before = self.cube()
            self._advance()
            if np.linalg.norm(self.cube() - before) < _STILL_M and before[2] < 2.0 * _CUBE_Z:
                away = np.abs(self.cube()[:2] - np.array(_DROP[:2]))
                return bool((away < _BIN_HALF_M).all())
        return False

    # --- motions ----------------------------------------------------------------------------------

    def _move_to(self, position: np.ndarray, speed: float) -> None:
        assert self._arm is not None
        settings = MotionSettings(velocity_scaling=speed, acceleration_scaling=speed)
        here = {name: self._positions[name] for name in self._arm.names}
        plan = self._arm.plan(position, here, settings, is_position=True)
        self._execute(write_joint_trajectory(plan, ""), plan.duration_s)

    def _grip(self, position: float) -> None:
        """Close or open the gripper, and wait until it stands, at its goal or on what it holds."""
        duration_s = max(0.2, abs(position - self._positions[_GRIPPER]) / _GRIPPER_SPEED)
        point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")()
        point.positions = [position]
        set_stamp(point.time_from_start, from_seconds(duration_s))
        trajectory: Any = get_message("trajectory_msgs/msg/JointTrajectory")()
        trajectory.joint_names, trajectory.points = [_GRIPPER], [point]
        self._execute(trajectory, duration_s)
        moved_ns = self._now_ns
        end_ns = moved_ns + round(_GIVEN_UP_S * 1e9)
        while self._now_ns - moved_ns < _STILL_S * 1e9 and self._now_ns < end_ns:
            before = self._positions
            self._advance()
            if any(abs(at - self._positions[name]) > _STILL_RAD for name, at in before.items()):
                moved_ns = self._now_ns

    def _execute(self, trajectory: Any, duration_s: float) -> None:
        """Send a trajectory to its controllers, and advance until they have executed it."""
        chosen, left = choose_controllers(trajectory.joint_names, self._controllers.available())
        if left:
            raise UnavailableError(f"No active controller takes trajectories of {', '.join(left)}")
        ends = []
        for controller in chosen:
            client = self._controllers.client(controller)
            sent = client.send_goal_async(goal_for(controller, trajectory, self._positions))
            handle = self._result(sent, f"an answer of '{controller.name}'")
            if handle is None or not handle.accepted:
                raise UnavailableError(f"'{controller.name}' has rejected a motion")
            ends.append((controller.name, handle.get_result_async()))
        # The manager serves one request after another: once it answers this one, the goals are with
        # its cycle.
        self._controllers.available()
        for _ in range(math.ceil((duration_s + _ENDED_S) * 1e9 / _STEP_NS)):
            self._advance()
        for name, ended in ends:
            # The result is on its way: time stands still until it is here.
            response = self._result(ended, f"the end of a motion of '{name}'")
            if response is None or response.status != _SUCCEEDED:
                raise UnavailableError(f"'{name}' has not executed a motion to its end")

    # --- time -------------------------------------------------------------------------------------

    def _advance(self) -> None:
        """Advance the simulation by some steps, at the requested speed, and receive its state."""
        self._request(self._step, steps=_STEPS)
        self._now_ns += _STEP_NS
        self._wait(
            lambda: min(self._states_ns, self._bodies_ns) >= self._now_ns,
            f"the states of {self._now_ns * 1e-9:.2f} s",
        )
        if self._factor > 0.0:
            now_s = time.monotonic()
            self._due_s = max(self._due_s + _STEP_NS * 1e-9 / self._factor, now_s - _MOST_LAG_S)
            if self._due_s > now_s:
                self.context.wait_for_change(lambda: False, self._due_s - now_s)

    def _request(self, client: Any, **fields: object) -> None:
        future = client.call_async(client.srv_type.Request(**fields))
        response = self._result(future, f"an answer of {client.srv_name}")
        if not response.success:
            raise UnavailableError(f"{client.srv_name}: {response.message}")

    def _result(self, future: Future[Any], what: str) -> Any:
        future.add_done_callback(self._notify)
        self._wait(future.done, what)
        return future.result()

    def _is_controlled(self, joints: Sequence[str]) -> bool:
        return not choose_controllers(joints, self._controllers.available())[1]

    def _wait(self, condition: Callable[[], object], what: str) -> None:
        end_s = time.monotonic() + _LONGEST_S
        while not condition():
            if not self.context.ok():
                raise ExternalShutdownException
            if time.monotonic() > end_s:
                raise UnavailableError(f"Waited {_LONGEST_S:g} s for {what} in vain")
            with self._changed:
                # Services and controllers that come and go do not notify.
                self._changed.wait_for(lambda: bool(condition()), 0.05)


def main(args: Sequence[str] | None = None) -> int:
    """Take the cube as often as requested; return 0 if it came into the bin each time.

    Raises:
        TeleopctlError: The robot is another one, or does not come.
    """
    arguments = sys.argv if args is None else args
    parser = argparse.ArgumentParser(prog="pick_and_place", description="Take a cube into a bin.")
    parser.add_argument("--times", type=int, default=20, help="how often")
    parser.add_argument("--seed", type=int, default=0, help="seed of the cube's places")
    parser.add_argument(
        "--real-time-factor",
        type=float,
        default=1.0,
        help="simulated seconds per second; 0 is as fast as the machine allows",
    )
    parser.add_argument(
        "--episodes", action="store_true", help="record each try by a running episode_recorder"
    )
    # The launch file's flag is an empty word where it is not set.
    words = filter(None, parse_ros_arguments(arguments).program[1:])
    options = parser.parse_args(list(words))
    random = np.random.default_rng(options.seed)
    done = 0
    with init(args=arguments):
        node = PickAndPlace(options.real_time_factor)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        spinning = spin_in_thread(executor)
        try:
            node.prepare()
            for number in range(1, options.times + 1):
                node.put(
                    random.uniform(*_ANGLES),
                    random.uniform(*_DISTANCES),
                    random.uniform(-_YAW, _YAW),
                )
                if options.episodes:
                    node.record("start")
                try:
                    node.take()
                    succeeded = node.drop()
                except TeleopctlError as error:
                    node.get_logger().error(error.message)
                    succeeded = False
                done += succeeded
                if options.episodes:
                    node.record(*(["success"] if succeeded else []), "save")
                where = "in the bin" if succeeded else f"at {np.round(node.cube(), 2).tolist()}"
                node.get_logger().info(f"{number} of {options.times}: the cube is {where}")
            node.get_logger().info(f"{done} of {options.times} cubes are in the bin")
        except (KeyboardInterrupt, ExternalShutdownException):
            return 130
        finally:
            executor.shutdown()
            spinning.join()
    return 0 if done == options.times else 1
