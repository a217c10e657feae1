"""Follower arm: follows a leader arm by its joints, or by the pose of its gripper."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Mapping
from typing import Any

from teleopctl.commander import (
    CommandTopic,
    Controller,
    Controllers,
    StreamKind,
    choose_streams,
    gripper_positions,
)
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.node import Node
from teleopctl.nodes.teleop.driven_robot import DrivenArm, DrivenRobot
from teleopctl.nodes.teleop.gripper import opening_of
from teleopctl.nodes.teleop.hand_driver import HandDriver
from teleopctl.teleop import (
    DeviceError,
    HandSample,
    JointFollowing,
    LeaderMapping,
    LeaderState,
    PoseClutch,
)
from teleopctl.tf import Transform

# Displacement of a command as the time that servo takes for it, s: if this node dies, the arm moves
# on for that long; and as the least one, rad or m, below which the leader rests.
_AHEAD_S, _REST = 0.2, 0.0015
# Motion of a leader's gripper between two samples that counts as a jump, m.
_JUMP_M = 0.1
# Change of a gripper's opening that is passed on.
_OPENING_STEP = 0.01

# Any, here and below: message classes are generated at run time from definitions.


class ServoReference:
    """Newest position commands of servo, from the topics of the active controllers.

    Args:
        node: Node of the subscriptions.
        joints: Joints that servo moves.
    """

    def __init__(self, node: Node, joints: tuple[str, ...]) -> None:
        self._node, self._joints = node, joints
        self.positions: dict[str, float] = {}
        self._followed: dict[CommandTopic, Any] = {}
        self._controllers = Controllers(node, self._on_controllers)
        self._controllers.request()

    def _on_controllers(self, active: list[Controller]) -> None:
        topics = choose_streams(active, list(self._joints))
        for gone in self._followed.keys() - set(topics):
            self._node.destroy_subscription(self._followed.pop(gone))
        for topic in topics:
            if topic.quantity == "position" and topic not in self._followed:
                self._follow(topic)

    def _follow(self, topic: CommandTopic) -> None:
        is_array = topic.kind is StreamKind.ARRAY

        def received(message: Any) -> None:
            if is_array:
                names, values = topic.joints, message.data
            elif message.points:
                names, values = message.joint_names, message.points[-1].positions
            else:
                return
            self.positions.update(zip(names, map(float, values), strict=False))

        self._followed[topic] = self._node.create_subscription(
            get_message(topic.kind.value.replace("/", "/msg/")), topic.topic, received, 1
        )


class LeaderFollower:
    """Moves an arm with a leader arm, once it is engaged.

    Args:
        node: Node of the endpoints.
        driver: Driver of the arm.
        mapping: How the leader's joints move the arm's.
        namespace: Namespace of the leader.
        silence_s: Time without a sample after which the arm follows no more, s.

    Attributes:
        problem: Why it follows no more, in words; empty while it does.
    """

    def __init__(
        self,
        node: Node,
        driver: HandDriver,
        mapping: LeaderMapping,
        namespace: str,
        silence_s: float,
    ) -> None:
        self._node, self._driver, self._silence_s = node, driver, silence_s
        self._leader = DrivenRobot(
            node, f"{namespace}/servo_node", drives_gripper=False, namespace=namespace or "/"
        )
        self._namespace = namespace
        self.mapping = mapping
        self.problem = ""
        self._sample: HandSample | None = None
        self._following: JointFollowing | None = None
        self._reference: ServoReference | None = None
        self._has_begun = False
        self._clutch = PoseClutch(mapping.scale)
        self._tool: Transform | None = None
        self._opening: float | None = None
        driver.robot_state.need_states()
        self._ends: tuple[dict[str, float], dict[str, float]] | None = None
        self._seeks_ends = False

    @property
    def state(self) -> LeaderState:
        """State of the follower."""
        if self._clutch.is_held:
            return LeaderState.FOLLOWING
        return LeaderState.RELEASED if self._following is None else self._following.state

    @property
    def is_engaged(self) -> bool:
        """Whether the arm follows the leader, or moves to the leader's pose."""
        return self.state is not LeaderState.RELEASED

    # --- engage and release -----------------------------------------------------------------------

    def engage(self) -> str:
        """Start to follow; return why not, empty if it does."""
        try:
            self._engage()
        except TeleopctlError as error:
            self.problem = f"{error.message}{f' ({error.hint})' if error.hint else ''}"
            return self.problem
        self.problem = ""
        return ""

    def _engage(self) -> None:
        robot, arm = self._driver.robot_state, self._driver.arm
        if problem := self._driver.problem:
            raise DeviceError(problem)
        assert arm is not None
        if self._driver.is_stopped:
            raise DeviceError("The robot is stopped", hint="Release it: teleopctl stop --release")
        now_s = time.monotonic()
        if self._sample is None or now_s - self._sample.received_s > self._silence_s:
            raise DeviceError(
                f"The leader is silent on {self._namespace}/joint_states",
                hint="Start it, or name its namespace with the parameter leader.",
            )
        if missing := [name for name in arm.joints if name not in robot.measured]:
            raise DeviceError(f"The follower's joint_states have no {', '.join(missing)}")
        if self.mapping.by_pose:
            tool, at = self._leader.tool(self._sample.joints), robot.tool()
            if tool is None or at is None:
                raise DeviceError(
                    f"The gripper of the leader is unknown: {self._leader.problem or 'no states'}"
                )
            self._tool = tool
            self._driver.release()
            self._clutch.hold(tool, at)
            return
        self.mapping.check(self._sample.joints, arm.joints)
        if self._reference is None:
            self._reference = ServoReference(self._node, arm.joints)
        if self._following is None:
            self._following = JointFollowing(arm.joints, arm.sliding)
        self._has_begun = False
        self._driver.release()
        self._following.engage(robot.measured, now_s)

    def release(self, reason: str = "") -> None:
        """Stop following, and let the arm come to rest."""
        if not self.is_engaged:
            return
        if self._following is not None:
            self._following.release()
        self._clutch.release()
        self._driver.pull(None)
        self.problem = reason
        if reason:
            self._node.get_logger().warning(f"The arm follows no more: {reason}")

    def check(self) -> None:
        """Release the arm if the leader is silent or the robot stopped; call it often."""
        self._leader.ask_servo()
        self._driver.robot_state.need_states()
        self._seek_ends()
        if not self.is_engaged or self._sample is None:
            return
        if self._driver.is_stopped:
            self.release("the robot is stopped")
        elif time.monotonic() - self._sample.received_s > self._silence_s:
            self.release("the leader is silent: engage again")

    # --- samples ----------------------------------------------------------------------------------

    def receive(self, sample: HandSample) -> None:
        """Process a sample of the leader, and move the arm if it is engaged."""
        self._sample = sample
        if not self.is_engaged:
            return
        try:
            refusal = self._follow_pose(sample) if self._clutch.is_held else self._follow(sample)
        except DeviceError as error:
            # The state is RELEASED already.
            self._driver.pull(None)
            self._clutch.release()
            self.problem = error.message
            self._node.get_logger().warning(f"The arm follows no more: {error.message}")
            return
        if refusal:
            self.release(refusal)
            return
        self._pass_gripper(sample.joints)

    def _follow(self, sample: HandSample) -> str:
        arm, robot = self._driver.arm, self._driver.robot_state
        assert self._following is not None and self._reference is not None and arm is not None
        leader = self.mapping.of_follower(sample.joints)
        if missing := [name for name in arm.joints if name not in leader]:
            self._following.release()
            raise DeviceError(f"The leader's states have no {', '.join(missing)} any more")
        wanted = self._following.step(leader, sample.received_s)
        commanded = self._reference.positions if self._has_begun else {}
        self._has_begun = True
        if not {*arm.joints} <= commanded.keys():
            # Servo begins at the measured state.
            commanded = {**robot.measured, **commanded}
        most = robot.scales["joint"] * _AHEAD_S
        by = {name: min(max(wanted[name] - commanded[name], -most), most) for name in arm.joints}
        rests = all(abs(each) < _REST for each in by.values())
        return self._driver.jog({} if rests else by)

    def _follow_pose(self, sample: HandSample) -> str:
        tool = self._leader.tool(sample.joints)
        if tool is None or self._tool is None:
            self._clutch.release()
            raise DeviceError("The leader's states have not all of its joints any more")
        moved_m = math.dist(tool.translation, self._tool.translation)
        if not moved_m < _JUMP_M:
            self._clutch.release()
            raise DeviceError(f"The leader has jumped by {moved_m:.2f} m: engage again")
        self._tool = tool
        return self._driver.pull(self._clutch.hold(tool, tool))

    # --- the gripper ------------------------------------------------------------------------------

    def _pass_gripper(self, joints: Mapping[str, float]) -> None:
        given = self.mapping.gripper
        if given is not None:
            opening = given.opening(joints[given.joint]) if given.joint in joints else None
        elif self._ends is not None and self._ends[0].keys() <= joints.keys():
            opening = opening_of(joints, *self._ends)
        else:
            opening = None
        if opening is None:
            return
        if self._opening is None or abs(opening - self._opening) >= _OPENING_STEP:
            self._opening = opening
            self._driver.set_gripper(opening)

    def _seek_ends(self) -> None:
        """Start to compute the leader's closed and open gripper positions, by its shapes."""
        leader = self._leader
        if self._seeks_ends or self.mapping.gripper is not None or leader.arm is None:
            return
        self._seeks_ends = True
        if leader.groups is not None and leader.groups.gripper_of(leader.arm.group) is not None:
            arguments = (leader, leader.arm)
            threading.Thread(target=self._find_ends, args=arguments, daemon=True).start()

    def _find_ends(self, leader: DrivenRobot, arm: DrivenArm) -> None:
        # Nothing is rendered; mujoco reads the variable at import.
        os.environ.setdefault("MUJOCO_GL", "disable")
        from teleopctl.kinematics import KinematicModel

        assert leader.description is not None and leader.groups is not None
        try:
            model = KinematicModel(leader.description)
            closed, opened = (
                gripper_positions(model, leader.groups, arm.group, part) for part in (0.0, 1.0)
            )
        except TeleopctlError as error:
            text = f"The leader's gripper is not followed: {error.message}"
            self._node.get_logger().warning(text)
            return
        self._ends = closed, opened
