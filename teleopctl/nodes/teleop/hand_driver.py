"""From a hand's commands to messages: servo's twists, the gripper, and the stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import RobotGroups, find_groups, parse_srdf, read_srdf
from teleopctl.node import (
    SILENCE_S,
    AsyncParameterClient,
    Clock,
    ClockType,
    LeaseHolder,
    Node,
    StopButton,
    StopHolders,
    qos_profile_latched,
)
from teleopctl.nodes.teleop.gripper import GripperDrive
from teleopctl.packages import resolve_uri
from teleopctl.robot import Joints, RobotDescription, SegmentTree
from teleopctl.teleop import STALE_S, HandCommand
from teleopctl.tf import Transform

_DEPTH = 10
# Messages of standstill after a release: one may be lost.
_ZEROS = 3
# Period in which silence of a hand is noticed, s.
_PERIOD_S = 0.02
# Values of moveit_msgs/srv/ServoCommandType.
_TWIST, _POSE = 1, 2
_SEMANTICS = ("robot_description_semantic", "srdf", "moveit_servo.move_group_name")
# Time for which a note is shown, s.
_NOTE_S = 5.0
_SCALES = {"linear": 0.4, "rotational": 0.8}

# Any, here and below: message classes are generated at run time from definitions.


@dataclass(frozen=True, slots=True)
class DrivenArm:
    """Arm that a hand drives, as its description has it.

    Attributes:
        robot: Name of the robot.
        root: Root link, in whose axes the tool moves.
        tip: Link that the arm moves.
        group: Name of the arm's group.
        joints: Names of the arm's independent joints.
        tool: Pose of the tool in the frame of the tip.
        forward: Direction in which the arm reaches with all joints at 0, in quarter turns about z
            from the root link's x axis.
    """

    robot: str
    root: str
    tip: str
    group: str
    joints: tuple[str, ...]
    tool: Transform
    forward: int

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
        return cls(
            description.name,
            description.root,
            group.tip,
            group.name,
            tuple(name for name in group.joints if joints[name].mimic is None),
            group.tool or Transform(),
            forward,
        )

    def in_root(self, vector: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return a vector whose x is forward in the axes of the root link."""
        x, y, z = vector
        for _ in range(self.forward):
            x, y = -y, x
        return x, y, z


class HandDriver:
    """Publishes what a hand asks for, and knows what became of it.

    Without samples for `STALE_S` the hand counts as released. A release publishes zero three times.

    Args:
        node: Node of the endpoints; its executor must spin in another thread than `apply`'s.
        device: Name of the device that the hand holds.
        servo: Name of the servo node.
    """

    def __init__(self, node: Node, device: str, servo: str = "servo_node") -> None:
        self._node = node
        self.device = device
        self._servo = servo if servo.startswith("/") else f"/{servo}"
        self._lease = LeaseHolder(node, [self._servo], self._on_loss)
        # Whether another hand has taken over since this one began to hold something.
        self._is_taken = False
        self._refusal = ""
        self._moved_s = 0.0
        self._lock = threading.Lock()
        self._arm: DrivenArm | None = None
        self._urdf = ""
        # The servo node's SRDF as text and as file, and its group.
        self._of_servo = ("", "", "")
        self._segments: SegmentTree | None = None
        self._target: Transform | None = None
        self._note = ("", 0.0)
        self._problem = "no robot description has been received"
        self._gripper: GripperDrive | None = None
        self._is_gripping = False
        self._measured: dict[str, float] = {}
        self._status = ""
        self._is_unitless = True
        self._scales = dict(_SCALES)
        self._speed = 1
        self._frame = "base"
        self._pressed: frozenset[str] = frozenset()
        self._has_toggled = False
        self._is_moving = False
        self._applied_s = 0.0
        self._command = HandCommand()
        self._sent_ns = 0
        self._twist: Any = get_message("geometry_msgs/msg/TwistStamped")()
        self._pose: Any = get_message("geometry_msgs/msg/PoseStamped")()
        self._poses = node.create_publisher(
            type(self._pose), f"{self._servo}/pose_target_cmds", _DEPTH
        )
        self._twists = node.create_publisher(
            type(self._twist), f"{self._servo}/delta_twist_cmds", _DEPTH
        )
        node.create_subscription(
            get_message("moveit_msgs/msg/ServoStatus"),
            f"{self._servo}/status",
            self._on_status,
            _DEPTH,
        )
        node.create_subscription(
            get_message("std_msgs/msg/String"),
            "robot_description",
            self._on_description,
            qos_profile_latched,
        )
        node.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "joint_states", self._on_states, 1
        )
        self._servo_parameters = AsyncParameterClient(node, self._servo)
        self._has_asked = False
        self._kind = get_service("moveit_msgs/srv/ServoCommandType")
        self._switch = node.create_client(self._kind, f"{self._servo}/switch_command_type")
        self._chosen: int | None = None
        self._button = StopButton(node)
        self._stops = StopHolders(node, lambda _names: None)
        node.create_timer(_PERIOD_S, self._watch, clock=Clock(clock_type=ClockType.STEADY_TIME))

    # --- the robot --------------------------------------------------------------------------------

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
            arm = DrivenArm.of(description, groups, name)
        except TeleopctlError as error:
            self._problem = error.message
            self._node.get_logger().error(f"robot_description is not used: {error.message}")
            return
        self._problem = ""
        self._segments = SegmentTree(description, joints)
        self._arm = arm
        if self._gripper is None and groups.gripper_of(arm.group) is not None:
            self._gripper = GripperDrive(self._node, description, groups, arm.group)

    def _on_states(self, message: Any) -> None:
        self._measured = dict(zip(message.name, message.position, strict=False))

    def _on_status(self, message: Any) -> None:
        self._status = message.message if message.code else ""

    def _ask_servo(self) -> None:
        """Request the scales of the servo node, and its groups, once it is there."""
        if self._has_asked or not self._servo_parameters.services_are_ready():
            return
        self._has_asked = True
        names = ["command_in_type", *(f"scale.{name}" for name in self._scales)]
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
        self._is_unitless = kind.string_value != "speed_units"
        for name, value in zip(_SCALES, scales, strict=False):
            self._scales[name] = value.double_value or self._scales[name]

    def _choose(self, kind: int) -> None:
        """Choose the kind of commands at the beginning of a motion: another hand has chosen too."""
        if (kind != self._chosen or not self._is_moving) and self._switch.service_is_ready():
            self._chosen = kind
            self._switch.call_async(self._kind.Request(command_type=kind))

    def tool(self) -> Transform | None:
        """Return the measured pose of the tool in the frame of the root link; None if unknown."""
        arm, segments, measured = self._arm, self._segments, self._measured
        if arm is None or segments is None or not {*arm.joints} <= measured.keys():
            return None
        return segments.link_poses(measured)[arm.tip] @ arm.tool

    # --- commands ---------------------------------------------------------------------------------

    @property
    def arm(self) -> DrivenArm | None:
        """The arm that is driven; None before its description is known."""
        return self._arm

    @property
    def status(self) -> str:
        """What servo says about the motion; empty if nothing slows it down."""
        return self._status

    def note(self, text: str) -> None:
        """Show a text for some seconds."""
        self._note = (text, time.monotonic() + _NOTE_S)

    @property
    def robot(self) -> str:
        """Name of the robot that is driven; empty before its description is known."""
        return "" if self._arm is None else self._arm.robot

    def apply(self, command: HandCommand, speeds: tuple[float, ...]) -> None:
        """Publish a hand's command; call it with each sample, from any one thread.

        Args:
            command: What the hand asks for.
            speeds: Speed steps of its mapping.
        """
        with self._lock:
            self._applied_s = time.monotonic()
            for action in command.actions - self._pressed:
                self._act(action, len(speeds))
            self._pressed = command.actions
            wants = command.is_held or command.toggles_gripper
            if not self._may_move(wants=wants):
                command = HandCommand(actions=command.actions)
            if command.toggles_gripper and not self._has_toggled and self._gripper is not None:
                self._gripper.toggle()
            self._has_toggled = command.toggles_gripper
            if "stop" in command.actions:
                command = HandCommand()
            self._command = command
            self._hold_gripper(command.gripper)
            if self._target is not None:
                pass  # the handle is held
            elif any(command.linear) or any(command.angular):
                part = speeds[min(self._speed, len(speeds) - 1)] * (0.25 if command.is_slow else 1)
                self._publish(command, part)
                self._is_moving = True
            elif self._is_moving:
                self._stop_moving()

    def release(self) -> None:
        """Take the hand as released: publish that nothing moves."""
        with self._lock:
            self._pressed, self._has_toggled = frozenset(), False
            self._command = HandCommand()
            self._hold_gripper(0.0)
            if self._is_moving:
                self._stop_moving()

    def pull(self, target: Transform | None) -> str:
        """Move the tool to a pose for as long as it is held; return why not, empty if it moves.

        Args:
            target: Pose in the frame of the root link; None lets go.
        """
        with self._lock:
            if target is None:
                self._target = None
                if self._is_moving:
                    self._stop_moving()
                return ""
            if not self._may_move(wants=True):
                return self._refusal
            self._target = target
            self._send_target()
        return ""

    def _send_target(self) -> None:
        arm, target = self._arm, self._target
        if arm is None or target is None:
            return
        self._choose(_POSE)
        self._is_moving, self._applied_s = True, time.monotonic()
        header, pose = self._pose.header, self._pose.pose
        header.stamp, header.frame_id = self._node.get_clock().now().to_msg(), arm.root
        pose.position.x, pose.position.y, pose.position.z = target.translation
        orientation = pose.orientation
        orientation.x, orientation.y, orientation.z, orientation.w = target.rotation
        self._poses.publish(self._pose)

    def take_over(self) -> None:
        """Drive from now on, also if another node does."""
        with self._lock:
            self._is_taken = False
            self._moved_s = time.monotonic()
            self._refusal = self._lease.take(self.device, by_force=True)

    def _may_move(self, *, wants: bool) -> bool:
        """Return whether this hand drives: it takes the lease when it begins to hold something."""
        if not wants:
            self._is_taken = False
            self._refusal = ""
            return True
        self._lease.is_lost()
        if self._is_taken:
            return False
        self._refusal = self._lease.take(self.device)
        if not self._refusal:
            self._moved_s = time.monotonic()
        return not self._refusal

    def _on_loss(self) -> None:
        # It may be pressed again, not go on.
        self._is_taken = self._is_moving or self._is_gripping
        self._refusal = "another hand has taken over" if self._is_taken else ""
        self._command = HandCommand()
        self._hold_gripper(0.0)
        self._target = None
        # What is published is refused, and a message of standstill is no harm.
        self._is_moving = False

    def set_gripper(self, opening: float) -> None:
        """Move the gripper to an opening, from 0 (closed) to 1 (open)."""
        with self._lock:
            if self._gripper is not None and self._may_move(wants=True):
                self._gripper.wanted = max(0.0, min(1.0, opening))

    def press_stop(self) -> None:
        """Stop the robot at once, on ``/stop``."""
        self.release()
        self._lease.release()
        self._button.press()

    def close(self) -> None:
        """Take the hand as released, and end its lease."""
        self.release()
        self._lease.release()

    def release_stop(self) -> None:
        """Release the robot that was stopped here."""
        self._button.release()

    def _act(self, action: str, steps: int) -> None:
        if action in ("slower", "faster"):
            self._speed = max(0, min(steps - 1, self._speed + (1 if action == "faster" else -1)))
        elif action in ("base", "tip"):
            self._frame = action
        elif action == "stop":
            self._lease.release()
            self._button.press()

    def _stop_moving(self) -> None:
        for _ in range(_ZEROS):
            self._publish(HandCommand(), 0.0)
        self._is_moving, self._target = False, None

    def _publish(self, command: HandCommand, part: float) -> None:
        arm = self._arm
        if arm is None:
            return
        self._choose(_TWIST)
        linear, angular = command.linear, command.angular
        if self._frame == "base":
            linear, angular = arm.in_root(linear), arm.in_root(angular)
        of_linear = part * (1.0 if self._is_unitless else self._scales["linear"])
        of_angular = part * (1.0 if self._is_unitless else self._scales["rotational"])
        header, twist = self._twist.header, self._twist.twist
        now = self._node.get_clock().now()
        self._sent_ns = now.nanoseconds
        header.stamp = now.to_msg()
        header.frame_id = arm.root if self._frame == "base" else arm.tip
        twist.linear.x, twist.linear.y, twist.linear.z = (of_linear * value for value in linear)
        twist.angular.x, twist.angular.y, twist.angular.z = (
            of_angular * value for value in angular
        )
        self._twists.publish(self._twist)

    def _watch(self) -> None:
        """Release a hand that has fallen silent, and go on with the gripper."""
        self._ask_servo()
        with self._lock:
            if self._target is not None and not self._stops.names:
                # A handle that is held still sends nothing.
                if self._may_move(wants=True):
                    self._send_target()
                else:
                    self._target = None
        is_held = self._is_moving or self._is_gripping
        if is_held and time.monotonic() - self._applied_s > STALE_S:
            self.release()
        with self._lock:
            self._lease.is_lost()
            if self._stops.names or (
                not self._is_moving and time.monotonic() - self._moved_s > SILENCE_S
            ):
                self._lease.release()
            if self._gripper is not None and not self._stops.names:
                self._gripper.step(_PERIOD_S, self._measured)

    def _hold_gripper(self, speed: float) -> None:
        """Move the gripper while a button is held: 1 opens, -1 closes, 0 is its release."""
        if self._gripper is None:
            return
        if speed:
            self._gripper.wanted = 1.0 if speed > 0.0 else 0.0
        elif self._is_gripping:
            self._gripper.halt()
        self._is_gripping = bool(speed)

    # --- what is shown ----------------------------------------------------------------------------

    def state(self, speeds: tuple[float, ...]) -> Mapping[str, Any]:
        """Return what a person has to see, as values for JSON.

        Args:
            speeds: Speed steps of the mapping.
        """
        command = self._command
        part = speeds[min(self._speed, len(speeds) - 1)] * (0.25 if command.is_slow else 1.0)
        has_servo = self._twists.get_subscription_count() > 0
        problem = self._problem
        if not problem and not has_servo:
            problem = f"{self._servo} does not run: teleopctl launch servo.yaml"
        return {
            "robot": self.robot,
            "problem": problem,
            "status": self._status or (self._gripper.problem if self._gripper else ""),
            "is_moving": self._is_moving,
            "linear": list(command.linear),
            "angular": list(command.angular),
            "speed": part,
            "speed_step": self._speed,
            "speed_m_s": part * self._scales["linear"],
            "speed_rad_s": part * self._scales["rotational"],
            "frame": self._frame,
            "opening": None if self._gripper is None else self._gripper.opening(self._measured),
            "wanted_opening": None if self._gripper is None else self._gripper.wanted,
            "stopped_by": list(self._stops.names),
            "note": self._note[0] if time.monotonic() < self._note[1] else "",
            "holder": self._holder(),
            "refusal": self._refusal,
        }

    def _holder(self) -> Mapping[str, Any] | None:
        """Return who drives, for JSON; None if nobody does."""
        claim = self._lease.watch.holder
        if claim is None:
            return None
        return {
            "node": claim.holder,
            "device": claim.device,
            "host": claim.host,
            "since_ns": claim.since_ns,
            "is_this": self._lease.is_held,
        }
