"""The teleoperated robot: its arm, gripper and states, and the status of its servo node."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import RobotGroups, StatusCode, find_groups, parse_srdf, read_srdf
from teleopctl.node import AsyncParameterClient, NewestMessage, Node, qos_profile_latched
from teleopctl.nodes.teleop.gripper import GripperDrive
from teleopctl.nodes.teleop.servo_words import hand_links, words_of_status
from teleopctl.packages import resolve_uri
from teleopctl.robot import Joints, RobotDescription, SegmentTree
from teleopctl.tf import Transform

_SEMANTICS = ("robot_description_semantic", "srdf", "moveit_servo.move_group_name")
# Scales of servo: m/s, rad/s, rad/s.
_SCALES = {"linear": 0.4, "rotational": 0.8, "joint": 0.5}
# Number of joints that position the tool, and least number that orient it freely, too.
_PLACING, _ORIENTING = 3, 6
# Time without a reader after which the subscription to joint states is paused, s.
_UNREAD_S = 2.0
# Time between two glances at the joint states, s.
_GLANCE_S = 0.5

# Any, here and below: message classes are generated at run time from definitions.
_JointState: Any = get_message("sensor_msgs/msg/JointState")
_ServoStatus: Any = get_message("moveit_msgs/msg/ServoStatus")


@dataclass(frozen=True, slots=True)
class DrivenArm:
    """Arm that is driven by teleoperation, from the robot's description.

    Attributes:
        robot: Name of the robot.
        root: Root link, in whose axes the tool moves.
        tip: Link that the arm moves.
        group: Name of the arm's group.
        joints: Names of the arm's independent joints.
        sliding: Those of them that slide, in m; the others turn, in rad.
        tool: Pose of the tool in the frame of the tip.
        forward: Direction in which the arm reaches with all joints at 0, in quarter turns about z
            from the root link's x axis.
        hand: Links that move with the tool: those behind the arm's last joint.
    """

    robot: str
    root: str
    tip: str
    group: str
    joints: tuple[str, ...]
    sliding: frozenset[str]
    tool: Transform
    forward: int
    hand: frozenset[str] = frozenset()

    @classmethod
    def of(cls, description: RobotDescription, groups: RobotGroups, name: str = "") -> DrivenArm:
        """Return the arm of a description.

        Args:
            description: The robot.
            groups: Its groups.
            name: Name of the arm's group; empty for the first one.

        Raises:
            TeleopctlError: The robot has no arm.
        """
        joints = Joints.of(description)
        group = groups.group(name)
        poses = SegmentTree(description, joints).link_poses(dict.fromkeys(description.joints, 0.0))
        x, y = (
            float(poses[group.tip].translation[axis] - poses[group.base].translation[axis])
            for axis in range(2)
        )
        forward = (0 if x >= 0.0 else 2) if abs(x) >= abs(y) else (1 if y >= 0.0 else 3)
        names = tuple(name for name in group.joints if joints[name].mimic is None)
        return cls(
            description.name,
            description.root,
            group.tip,
            group.name,
            names,
            frozenset(name for name in names if description.joints[name].type == "prismatic"),
            group.tool or Transform(),
            forward,
            hand_links(description, group.tip),
        )

    @property
    def turns(self) -> bool:
        """Whether it has more joints than the three that position the tool, to turn it by."""
        return len(self.joints) > _PLACING

    @property
    def orients_freely(self) -> bool:
        """Whether it has enough joints for any orientation of the tool at a position."""
        return len(self.joints) >= _ORIENTING

    def in_root(self, vector: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return a vector whose x is forward in the axes of the root link."""
        x, y, z = vector
        for _ in range(self.forward):
            x, y = -y, x
        return x, y, z


class DrivenRobot:
    """Subscriber of the description and states of a robot and of its servo node.

    Args:
        node: Node of the subscriptions.
        servo: Full name of the servo node.
        drives_gripper: Whether the gripper is to be moved, too.
        namespace: Namespace of the robot; by default the node's.

    Attributes:
        name: Name of the robot; empty before its description is known.
        arm: Its arm; None before it is known, and for a robot without one.
        gripper: Drive of its gripper; None without one.
        description: Its description; None before it is known.
        groups: Its groups.
        problem: Why it cannot be driven, in words; empty if it can.
        scales: Largest speeds of servo's commands: ``linear`` in m/s, ``rotational`` and
            ``joint`` in rad/s.
        is_unitless: Whether servo takes parts of these speeds.
        answered_s: When servo's newest status was read, on the monotonic clock, s.
    """

    def __init__(
        self, node: Node, servo: str, *, drives_gripper: bool = True, namespace: str = ""
    ) -> None:
        self._node = node
        self._drives_gripper = drives_gripper
        self.name = ""
        self.arm: DrivenArm | None = None
        self.gripper: GripperDrive | None = None
        self.description: RobotDescription | None = None
        self.groups: RobotGroups | None = None
        self._measured: dict[str, float] = {}
        self.problem = "The robot is not known yet: no robot_description has been received"
        self._status, self._status_code = "", int(StatusCode.NO_WARNING)
        self.answered_s = 0.0
        self.scales = dict(_SCALES)
        self.is_unitless = True
        self._urdf = ""
        # The servo node's SRDF as text and as file, and its group.
        self._of_servo = ("", "", "")
        self._segments: SegmentTree | None = None
        prefix = f"{namespace.rstrip('/')}/" if namespace else ""
        node.create_subscription(
            get_message("std_msgs/msg/String"),
            f"{prefix}robot_description",
            self._on_description,
            qos_profile_latched,
        )
        self._states = NewestMessage(node, _JointState, f"{prefix}joint_states", is_paused=True)
        self._states_read_s = 0.0
        # Whether a glance has begun that has not got a message yet, and when the last one began, s.
        self._is_glancing, self._glanced_s = False, 0.0
        self._glanced: dict[str, float] = {}
        self._states_lock = threading.Lock()
        self._servo_statuses = NewestMessage(node, _ServoStatus, f"{servo}/status")
        self._servo_parameters = AsyncParameterClient(node, servo)
        self._has_asked = False

    def _on_description(self, message: Any) -> None:
        self._urdf = message.data
        self._find_arm()

    def _find_arm(self) -> None:
        """Find the arm in the description, with the groups of the servo node."""
        if not self._urdf:
            return
        try:
            description = RobotDescription.from_urdf(self._urdf)
            joints = Joints.of(description)
            semantic, file, name = self._of_servo
            if semantic:
                groups = parse_srdf(semantic, description, joints)
            elif file:
                groups = read_srdf(resolve_uri(file), description, joints)
            else:
                groups = find_groups(description, joints)
            self.name = description.name
            self.description, self.groups = description, groups
            arm = DrivenArm.of(description, groups, name)
        except TeleopctlError as error:
            self.problem = error.message
            return
        self.problem = ""
        self._segments = SegmentTree(description, joints)
        self.arm = arm
        if not self._drives_gripper or self.gripper is not None:
            return
        if groups.gripper_of(arm.group) is not None:
            self.gripper = GripperDrive(self._node, description, groups, arm.group)

    @property
    def measured(self) -> dict[str, float]:
        """Measured positions by joint, rad or m; empty at first, and after 2 s without a call.

        States may arrive a thousand times a second: they are received only while they are read.
        """
        with self._states_lock:
            self._states_read_s = time.monotonic()
            self._measured = self._read_states() or self._measured
            return self._measured

    def glance(self) -> dict[str, float]:
        """Return measured positions for a display, at most 0.6 s old; empty at first.

        Call it ten times a second. Unless `measured` is read too, states are received for a moment
        of each half second only.
        """
        with self._states_lock:
            now_s = time.monotonic()
            if self._states_read_s:
                self._glanced = self._measured = self._read_states() or self._measured
            elif not self._is_glancing and now_s - self._glanced_s >= _GLANCE_S:
                self._is_glancing, self._glanced_s = True, now_s
                self._glanced = self._read_states() or self._glanced  # begins to receive
            elif self._is_glancing and (positions := self._read_states()):
                self._glanced, self._is_glancing = positions, False
                self._states.pause()
            return self._glanced

    def _read_states(self) -> dict[str, float]:
        """Return the positions of the newest joint states; empty if there are no new ones."""
        message = self._states.read()
        return {} if message is None else dict(zip(message.name, message.position, strict=False))

    def need_states(self) -> None:
        """Subscribe to the joint states, which are needed soon."""
        _ = self.measured

    def forget_states(self) -> None:
        """Pause the subscription to joint states if they are not read."""
        with self._states_lock:
            now_s = time.monotonic()
            if self._states_read_s and now_s - self._states_read_s > _UNREAD_S:
                self._states_read_s, self._measured = 0.0, {}
                self._states.pause()
            elif self._is_glancing and now_s - self._glanced_s > _UNREAD_S:
                self._is_glancing = False
                self._states.pause()

    @property
    def status(self) -> str:
        """Text of servo's status; empty if the motion is not slowed down."""
        self.read_status()
        return self._status

    @property
    def status_words(self) -> str:
        """Servo's status as one sentence for people; empty if the motion is not slowed down."""
        if not self.status:
            return ""
        hand = frozenset() if self.arm is None else self.arm.hand
        return words_of_status(self._status_code, self._status, hand)

    def read_status(self) -> None:
        """Read servo's newest status, if one has arrived since the last call."""
        if (message := self._servo_statuses.read()) is not None:
            # Without a warning, too, the text may have what the arm cannot do.
            is_news = message.code or message.message != StatusCode.NO_WARNING.text
            self._status = message.message if is_news else ""
            self._status_code = message.code
            self.answered_s = time.monotonic()

    def ask_servo(self) -> None:
        """Request the speed scales and groups of the servo node, once it is available."""
        if self._has_asked or not self._servo_parameters.services_are_ready():
            return
        self._has_asked = True
        names = ["command_in_type", *(f"scale.{name}" for name in self.scales)]
        future = self._servo_parameters.get_parameters([f"moveit_servo.{name}" for name in names])
        future.add_done_callback(self._on_scales)
        # By themselves: MoveIt's own servo has not all of them, and would answer none.
        future = self._servo_parameters.get_parameters(list(_SEMANTICS))
        future.add_done_callback(self._on_semantics)

    # Any: the future of a response.
    def _on_semantics(self, future: Any) -> None:
        response = future.result()
        if response is not None and len(response.values) == len(_SEMANTICS):
            semantic, file, name = (value.string_value for value in response.values)
            self._of_servo = (semantic, file, name)
            self._find_arm()

    # Any: the future of a response.
    def _on_scales(self, future: Any) -> None:
        response = future.result()
        if response is None:
            return
        kind, *scales = response.values
        self.is_unitless = kind.string_value != "speed_units"
        for name, value in zip(_SCALES, scales, strict=False):
            self.scales[name] = value.double_value or self.scales[name]

    def tool(self, positions: Mapping[str, float] | None = None) -> Transform | None:
        """Return the pose of the tool in the frame of the root link; None if it is unknown.

        Args:
            positions: Positions by joint, rad or m; the measured ones by default.
        """
        arm, segments = self.arm, self._segments
        at = self.measured if positions is None else positions
        if arm is None or segments is None or not {*arm.joints} <= at.keys():
            return None
        return segments.link_pose(arm.tip, at) @ arm.tool
