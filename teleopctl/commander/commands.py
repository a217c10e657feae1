"""Commands to controllers: streams of messages, and goals of their actions."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from teleopctl.commander.controllers import (
    ActionKind,
    CommandTopic,
    Controller,
    Controllers,
    StreamKind,
)
from teleopctl.interfaces import from_seconds, get_action, get_message, set_stamp
from teleopctl.node import STREAM_FRAME, ActionClient, GoalState, Node

_DEPTH = 10
# Longest time to wait until canceled joints have stopped, and time between two looks, s.
_STOP_S, _LOOK_S = 10.0, 0.02

# Any, here and below: message classes are generated at run time from definitions.


class CommandPublisher:
    """Publisher of joint commands to one controller.

    Args:
        node: Node of the publisher.
        target: The controller's topic.
        ahead_s: Time within which a trajectory controller reaches a position, s.
        gives_way: Whether trajectory controllers of teleopctl ignore the commands while they
            execute a goal; otherwise, as in ROS 2, a command replaces the trajectory of the goal.
    """

    def __init__(
        self, node: Node, target: CommandTopic, ahead_s: float, *, gives_way: bool = False
    ) -> None:
        self._node, self.target = node, target
        if target.kind is StreamKind.TRAJECTORY:
            self._message: Any = get_message("trajectory_msgs/msg/JointTrajectory")(
                joint_names=list(target.joints)
            )
            self._point: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")()
            set_stamp(self._point.time_from_start, from_seconds(ahead_s))
            self._message.points = [self._point]
            if gives_way:
                self._message.header.frame_id = STREAM_FRAME
        else:
            self._message = get_message("std_msgs/msg/Float64MultiArray")()
        self._publisher = node.create_publisher(type(self._message), target.topic, _DEPTH)

    def publish(
        self,
        positions: Mapping[str, float],
        velocities: Mapping[str, float],
        measured: Mapping[str, float],
    ) -> None:
        """Publish a command.

        Args:
            positions: Commanded positions by joint, rad or m.
            velocities: Commanded velocities by joint, rad/s or m/s.
            measured: Measured positions of all joints: those of the controller that are not
                commanded stay where they are.
        """
        names = self.target.joints
        is_array = self.target.kind is StreamKind.ARRAY
        if is_array and self.target.quantity == "velocity":
            self._message.data = [velocities.get(name, 0.0) for name in names]
        else:
            values = [positions.get(name, measured.get(name, 0.0)) for name in names]
            if is_array:
                self._message.data = values
            else:
                self._point.positions = values
        self._publisher.publish(self._message)

    @property
    def is_connected(self) -> bool:
        """Whether a controller would receive a message."""
        return self._publisher.has_subscribers

    def wait_for_subscriber(self, timeout_s: float) -> bool:
        """Wait until a controller would receive the messages; return False on timeout."""
        end_s = time.monotonic() + timeout_s
        while not self.is_connected:
            if time.monotonic() > end_s:
                return False
            time.sleep(_LOOK_S)
        return True

    def destroy(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)


def goal_for(controller: Controller, trajectory: Any, measured: Mapping[str, float]) -> Any:
    """Return the part of a JointTrajectory that a controller executes, as a goal of its action.

    Joints of a trajectory controller that the trajectory does not move stay where they are.

    Args:
        controller: The controller.
        trajectory: A ``trajectory_msgs/msg/JointTrajectory``.
        measured: Measured positions of all joints.
    """
    goal: Any = get_action(controller.kind.type_name).Goal()
    names = list(trajectory.joint_names)
    last = trajectory.points[-1]
    if controller.kind is not ActionKind.TRAJECTORY:
        joint = next(name for name in controller.joints if name in names)
        position = float(last.positions[names.index(joint)])
        if controller.kind is ActionKind.GRIPPER:
            goal.command.position, goal.command.max_effort = position, controller.max_effort
        else:
            goal.command.name, goal.command.position = [joint], [position]
            if controller.max_effort:
                goal.command.effort = [controller.max_effort]
        return goal
    joints = list(controller.joints)
    places = [names.index(name) if name in names else -1 for name in joints]
    goal.trajectory.header.frame_id = trajectory.header.frame_id
    goal.trajectory.joint_names = joints
    point_type: Any = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    for point in trajectory.points:
        made = point_type(time_from_start=point.time_from_start)
        made.positions = [
            float(point.positions[place]) if place >= 0 else measured.get(name, 0.0)
            for name, place in zip(joints, places, strict=True)
        ]
        for quantity in ("velocities", "accelerations"):
            values = getattr(point, quantity)
            if len(values):
                setattr(
                    made,
                    quantity,
                    [float(values[place]) if place >= 0 else 0.0 for place in places],
                )
        goal.trajectory.points.append(made)
    return goal


class RunningGoal:
    """Goal of an action that moves joints, from its request to its end.

    Args:
        client: Client of the action.
        goal: The goal, which is sent.
        who: Executing controller, as the beginning of a sentence.
        on_end: Called once at the end.

    Attributes:
        who: Executing controller.
        problem: Why it failed, as a sentence; empty if it did not.
        code: Error code of the result; 0 without one.
        ended: Whether it has ended.
        canceled: Whether it ended since it was canceled.
    """

    def __init__(
        self,
        client: ActionClient[Any, Any, Any],
        goal: Any,
        who: str,
        on_end: Callable[[], object],
    ) -> None:
        self.who = who
        self.problem = ""
        self.code = 0
        self.ended = self.canceled = False
        self._client, self._on_end = client, on_end
        self._handle: Any = None
        self._is_canceling = False
        self._lock = threading.Lock()
        client.send_goal_async(goal).add_done_callback(self._accepted)

    def cancel(self) -> None:
        """Stop the joints, also if the goal has not been accepted yet."""
        with self._lock:
            self._is_canceling = True
            handle = self._handle
        if handle is not None and not self.ended:
            handle.cancel_goal_async()

    def check_server(self) -> None:
        """End the goal with a problem if the action's server is gone."""
        if not self.ended and not self._client.server_is_ready():
            self._end(f"{self.who} has gone while it was moving the robot")

    # Any: futures of handles and results.
    def _accepted(self, future: Any) -> None:
        handle = None if future.exception() is not None else future.result()
        if handle is None or not handle.accepted:
            self._end(f"{self.who} rejected the trajectory")
            return
        with self._lock:
            self._handle = handle
            is_canceling = self._is_canceling
        handle.get_result_async().add_done_callback(self._finished)
        if is_canceling:
            handle.cancel_goal_async()

    def _finished(self, future: Any) -> None:
        response = None if future.exception() is not None else future.result()
        if response is None:
            self._end(f"{self.who} did not say how the motion ended")
            return
        result = response.result
        # Controllers have numbers, and 0 is good; move_group a message with one, and 1 is good.
        code = getattr(result, "error_code", 0)
        number, text = int(getattr(code, "val", code)), getattr(code, "message", "")
        text = getattr(result, "error_string", "") or text or _stalled_text(result)
        is_good = number in ((0, 1) if hasattr(code, "val") else (0,))
        self.canceled = response.status == GoalState.CANCELED
        if self.canceled or (response.status == GoalState.SUCCEEDED and is_good):
            self._end("")
            return
        self.code = number
        self._end(f"{self.who} failed: {text or f'error code {number}'}")

    def _end(self, problem: str) -> None:
        with self._lock:
            if self.ended:
                return
            self.problem, self.ended = problem, True
        self._on_end()


class RunningMotion:
    """Motion of one or several controllers at once.

    Attributes:
        goals: The goals, one for each controller.
    """

    def __init__(self) -> None:
        self.goals: list[RunningGoal] = []
        self._changed = threading.Event()

    @classmethod
    def of(
        cls,
        controllers: Controllers,
        chosen: Iterable[Controller],
        trajectory: Any,
        measured: Mapping[str, float],
    ) -> RunningMotion:
        """Send the parts of a JointTrajectory to controllers.

        Args:
            controllers: Clients of the controllers' actions.
            chosen: Controllers that execute it.
            trajectory: A ``trajectory_msgs/msg/JointTrajectory``.
            measured: Measured positions of all joints.
        """
        motion = cls()
        for one in chosen:
            goal = goal_for(one, trajectory, measured)
            motion.add(controllers.client(one), goal, f"Controller '{one.name}'")
        return motion

    def add(self, client: ActionClient[Any, Any, Any], goal: Any, who: str) -> None:
        """Send a goal; see `RunningGoal`."""
        self.goals.append(RunningGoal(client, goal, who, self._changed.set))

    @property
    def ended(self) -> bool:
        """Whether all goals have ended."""
        return all(goal.ended for goal in self.goals)

    @property
    def failed(self) -> RunningGoal | None:
        """The first goal that has a problem."""
        return next((goal for goal in self.goals if goal.problem), None)

    def wait(self, timeout_s: float) -> None:
        """Wait until a goal ends, at most for a time."""
        self._changed.wait(timeout_s)
        self._changed.clear()

    def cancel(
        self, now_s: Callable[[], float] = time.monotonic, longest_s: float = _STOP_S
    ) -> list[str]:
        """Stop the joints, and wait until the controllers report the end.

        Args:
            now_s: Clock of the longest time.
            longest_s: Longest time to wait, s.

        Returns:
            What has not confirmed in time.
        """
        for goal in self.goals:
            if not goal.ended:
                goal.cancel()
        end_s = now_s() + longest_s
        while not self.ended and now_s() < end_s:
            self.wait(_LOOK_S)
        return [goal.who for goal in self.goals if not goal.ended]


# Any: message classes are generated at run time from definitions.
def _stalled_text(result: Any) -> str:
    """Return where a gripper stopped short of its goal; empty for other results."""
    if not getattr(result, "stalled", False):
        return ""
    at = getattr(result, "position", None)
    if at is None:
        at = next(iter(result.state.position), None)
    return "it stalled short of its goal" + ("" if at is None else f", at {float(at):.4g}")
