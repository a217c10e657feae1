"""Executable ``teleop_keyboard``: jogs a robot's gripper and joints by keys of the terminal."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Sequence
from typing import Any

from teleopctl.base.keyboard import (
    DOWN,
    LEFT,
    PAGE_DOWN,
    PAGE_UP,
    RIGHT,
    SPACE,
    UP,
    Key,
    Keyboard,
    require_keys,
)
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import StatusCode, find_groups
from teleopctl.node import (
    SILENCE_S,
    AsyncParameterClient,
    ExternalShutdownException,
    LeaseHolder,
    Node,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    spin,
)
from teleopctl.nodes.teleop.gripper import GripperDrive
from teleopctl.nodes.teleop.servo_words import hand_links, words_of_status
from teleopctl.nodes.teleop.status_lines import StatusLines, who_drives
from teleopctl.robot import Joints, RobotDescription
from teleopctl.teleop import HeldKeys

_DEPTH = 10
_SPEEDS = (0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)
_FIRST_SPEED = 3
# Messages of standstill after the last key: one may be lost.
_ZEROS = 3
# Linear and angular direction of each key.
_TWISTS = {
    UP: (1, 0, 0, 0, 0, 0),
    DOWN: (-1, 0, 0, 0, 0, 0),
    LEFT: (0, 1, 0, 0, 0, 0),
    RIGHT: (0, -1, 0, 0, 0, 0),
    PAGE_UP: (0, 0, 1, 0, 0, 0),
    PAGE_DOWN: (0, 0, -1, 0, 0, 0),
    # As in MoveIt's servo_keyboard_input.
    ";": (0, 0, 1, 0, 0, 0),
    ".": (0, 0, -1, 0, 0, 0),
    "u": (0, 0, 0, 1, 0, 0),
    "o": (0, 0, 0, -1, 0, 0),
    "i": (0, 0, 0, 0, 1, 0),
    "k": (0, 0, 0, 0, -1, 0),
    "j": (0, 0, 0, 0, 0, 1),
    "l": (0, 0, 0, 0, 0, -1),
}
_JOINTS = {UP: 1.0, "+": 1.0, "=": 1.0, DOWN: -1.0, "-": -1.0}
# Values of moveit_msgs/srv/ServoCommandType.
_JOINT_JOG, _TWIST = 0, 1
_HELP = """\
Move the gripper:  up/down arrow  x     left/right arrow  y     page up/down (or ; .)  z
Turn it:           u/o  about x         i/k  about y            j/l  about z
Axes of:           w  the robot's base  e  the gripper
Move one joint:    1 to 9 choose it, then up/down arrow or +/-;  w or e: back to the gripper
Gripper:           g  opens and closes
Speed:             [  slower            ]  faster
Stop:              space                q or Ctrl-C  quit
"""

# Any, here and below: message classes are generated at run time from definitions.


class KeyboardTeleop(Node):
    """Node that publishes commands to a servo node, by the keys of a terminal.

    Args:
        servo: Name of the servo node.
        rate_hz: Rate of the commands while a key is held, Hz.
    """

    def __init__(self, servo: str = "servo_node", rate_hz: float = 50.0) -> None:
        super().__init__("teleop_keyboard")
        self._servo = servo if servo.startswith("/") else f"/{servo}"
        self._rate_hz = rate_hz
        self._keys = HeldKeys()
        self._lease = LeaseHolder(self, [self._servo])
        self._held_s = 0.0
        self._mode = "base"
        self._joint = 0
        self._speed = _FIRST_SPEED
        self._zeros = 0
        self._names: tuple[str, ...] = ()
        self._root = self._tip = ""
        self._gripper: GripperDrive | None = None
        self._measured: dict[str, float] = {}
        # What servo says, with its words for people, and what this node itself has to say.
        self._status, self._words, self._fault = "", "", ""
        self._hand: frozenset[str] = frozenset()
        self._scales = {"linear": 0.4, "rotational": 0.8, "joint": 0.5}
        self._is_unitless = True
        self._is_done = self._is_toggled = False
        self._lines = StatusLines()
        self._twist: Any = get_message("geometry_msgs/msg/TwistStamped")()
        self._jog: Any = get_message("control_msgs/msg/JointJog")()
        self._twists = self.create_publisher(
            type(self._twist), f"{self._servo}/delta_twist_cmds", _DEPTH
        )
        self._jogs = self.create_publisher(
            type(self._jog), f"{self._servo}/delta_joint_cmds", _DEPTH
        )
        self.create_subscription(
            get_message("moveit_msgs/msg/ServoStatus"),
            f"{self._servo}/status",
            self._on_status,
            _DEPTH,
        )
        self.create_subscription(
            get_message("std_msgs/msg/String"),
            "robot_description",
            self._on_description,
            qos_profile_latched,
        )
        self.create_subscription(
            get_message("sensor_msgs/msg/JointState"), "joint_states", self._on_states, 1
        )
        self._servo_parameters = AsyncParameterClient(self, self._servo)
        self._asked = False
        self._kind = get_service("moveit_msgs/srv/ServoCommandType")
        self._switch = self.create_client(self._kind, f"{self._servo}/switch_command_type")
        self._chosen: int | None = None
        self._timer = self.create_timer(1.0 / rate_hz, self._tick)

    # --- what the robot is -----------------------------------------------------------------------

    def _on_description(self, message: Any) -> None:
        try:
            description = RobotDescription.from_urdf(message.data)
            joints = Joints.of(description)
            groups = find_groups(description, joints)
            group = groups.group()
        except TeleopctlError as error:
            self.get_logger().error(f"robot_description is not used: {error.message}")
            return
        self._root, self._tip = description.root, group.tip
        self._hand = hand_links(description, group.tip)
        self._names = tuple(name for name in group.joints if joints[name].mimic is None)
        if self._gripper is None and groups.gripper_of(group.name) is not None:
            self._gripper = GripperDrive(self, description, groups, group.name)

    def _on_states(self, message: Any) -> None:
        self._measured.update(zip(message.name, message.position, strict=False))

    def _on_status(self, message: Any) -> None:
        is_news = message.code or message.message != StatusCode.NO_WARNING.text
        self._status = message.message if is_news else ""
        self._words = words_of_status(message.code, self._status, self._hand) if is_news else ""

    def _request_scales(self) -> None:
        """Request the speed scales of the servo node, once it is available."""
        if self._asked or not self._servo_parameters.services_are_ready():
            return
        self._asked = True
        names = ["command_in_type", *(f"scale.{name}" for name in self._scales)]
        future = self._servo_parameters.get_parameters([f"moveit_servo.{name}" for name in names])

        # Any: the future of a response.
        def answered(future: Any) -> None:
            response = future.result()
            if response is None:
                return
            kind, *scales = response.values
            self._is_unitless = kind.string_value != "speed_units"
            for name, value in zip(self._scales, scales, strict=False):
                self._scales[name] = value.double_value or self._scales[name]

        future.add_done_callback(answered)

    # --- keys -------------------------------------------------------------------------------------

    def on_key(self, key: Key) -> None:
        """Process a key of the terminal; called on the thread that reads them."""
        name = key.name
        if not key.is_released:
            self._fault = ""
            if name == "q":
                self._is_done = True
                self._keys.release_all()
                return
            if name == SPACE:
                self._keys.release_all()
                self._zeros = _ZEROS
                if self._gripper is not None:
                    self._gripper.halt()
                return
            if name in ("w", "e"):
                self._mode = "base" if name == "w" else "gripper"
                return
            if name.isdigit() and name != "0":
                self._mode, self._joint = "joint", int(name) - 1
                return
            if name in ("[", "]"):
                step = 1 if name == "]" else -1
                self._speed = min(max(self._speed + step, 0), len(_SPEEDS) - 1)
                return
            if name == "g":
                self._is_toggled = True
                return
        moving = _JOINTS if self._mode == "joint" else _TWISTS
        if name in moving:
            self._keys.on_key(key, time.monotonic())

    def _toggle_gripper(self) -> None:
        """Close the gripper if it is open, else open it."""
        self._is_toggled = False
        if self._gripper is None:
            self._fault = "No gripper of the robot was found"
        elif refusal := self._lease.take("keyboard"):
            self._fault = refusal
        else:
            self._held_s = time.monotonic()
            self._gripper.toggle()

    # --- commands ---------------------------------------------------------------------------------

    def _tick(self) -> None:
        self._request_scales()
        held = self._keys.held(time.monotonic())
        if held and (refusal := self._lease.take("keyboard")):
            self._fault = refusal
            self._keys.release_all()
            held = frozenset()
        if held:
            self._held_s = time.monotonic()
        elif time.monotonic() - self._held_s > SILENCE_S:
            self._lease.release()
        if held:
            self._zeros = _ZEROS
            self._publish(held)
        elif self._zeros:
            self._zeros -= 1
            self._publish(held)
        if self._is_toggled:
            self._toggle_gripper()
        if self._gripper is not None:
            self._gripper.step(1.0 / self._rate_hz, self._measured)
        self._show(held)
        if self._is_done and not self._zeros:
            raise ExternalShutdownException

    def _choose(self, kind: int) -> None:
        """Set servo's command type; MoveIt's servo accepts no other, and none at the start."""
        if kind != self._chosen and self._switch.service_is_ready():
            self._chosen = kind
            self._switch.call_async(self._kind.Request(command_type=kind))

    def _publish(self, held: frozenset[str]) -> None:
        part = _SPEEDS[self._speed]
        stamp = self.get_clock().now().to_msg()
        self._choose(_JOINT_JOG if self._mode == "joint" else _TWIST)
        if self._mode == "joint":
            if not self._joint < len(self._names):
                self._fault = f"Joint {self._joint + 1} does not exist"
                return
            sign = max(-1.0, min(1.0, sum(_JOINTS.get(name, 0.0) for name in held)))
            factor = 1.0 if self._is_unitless else self._scales["joint"]
            self._jog.header.stamp = stamp
            self._jog.joint_names = [self._names[self._joint]]
            self._jog.velocities = [sign * part * factor]
            self._jogs.publish(self._jog)
            return
        sums = [
            max(-1.0, min(1.0, float(sum(_TWISTS[name][axis] for name in held if name in _TWISTS))))
            for axis in range(6)
        ]
        linear = part * (1.0 if self._is_unitless else self._scales["linear"])
        angular = part * (1.0 if self._is_unitless else self._scales["rotational"])
        header, twist = self._twist.header, self._twist.twist
        header.stamp, header.frame_id = stamp, self._tip if self._mode == "gripper" else self._root
        twist.linear.x, twist.linear.y, twist.linear.z = (linear * value for value in sums[:3])
        twist.angular.x, twist.angular.y, twist.angular.z = (angular * value for value in sums[3:])
        self._twists.publish(self._twist)

    def stop(self) -> None:
        """Publish zero motion, and end the lease."""
        self._lease.release()
        for _ in range(_ZEROS):
            self._publish(frozenset())

    # --- display ----------------------------------------------------------------------------------

    def _show(self, held: frozenset[str]) -> None:
        part = _SPEEDS[self._speed]
        if self._mode == "joint":
            known = self._joint < len(self._names)
            what = self._names[self._joint] if known else f"joint {self._joint + 1}?"
            speed = f"{part * self._scales['joint']:.2f} rad/s"
            count = self._jogs.get_subscription_count()
        else:
            what = f"gripper, axes of the {self._mode}"
            speed = (
                f"{part * self._scales['linear']:.2f} m/s, "
                f"{part * self._scales['rotational']:.2f} rad/s"
            )
            count = self._twists.get_subscription_count()
        doing = " ".join(sorted(name.lower().replace("_", " ") for name in held)) or "stopped"
        listeners = f"{count} subscriber{'' if count == 1 else 's'}"
        if not count:
            listeners = f"no subscriber: is {self._servo} running?"
        claim = self._lease.watch.holder
        fault = self._fault or (self._gripper.problem if self._gripper else "")
        self._lines.show(
            (
                f"{what} | {doing} | {speed}, step {self._speed + 1} of {len(_SPEEDS)}",
                f"{who_drives(f'{claim.holder} ({claim.device})' if claim else '')} | "
                f"{self._rate_hz:g} Hz, {listeners}",
                fault or self._words,
                "" if fault else self._status,
            )
        )

    def leave(self) -> None:
        """Leave the display as it is, with the cursor below it."""
        self._lines.end()


def main(args: Sequence[str] | None = None) -> None:
    """Steer a robot by the keys of the terminal until ``q`` or Ctrl-C.

    Raises:
        UsageError: Standard input is no terminal.
    """
    arguments = sys.argv if args is None else args
    parser = argparse.ArgumentParser(
        prog="teleop_keyboard",
        description="Steer a robot's gripper and joints by keys.",
        epilog=_HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--servo", default="servo_node", metavar="NAME", help="name of the servo node"
    )
    parser.add_argument(
        "--rate", type=float, default=50.0, metavar="HZ", help="commands per second"
    )
    options = parser.parse_args(parse_ros_arguments(arguments).program[1:])
    if not options.rate > 0.0:
        parser.error("--rate must be above 0")
    require_keys("teleop_keyboard", "/servo_node/delta_twist_cmds")
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException), init(args=arguments):
        node = KeyboardTeleop(options.servo, options.rate)
        sys.stdout.write(_HELP)
        with Keyboard(key=node.on_key):
            try:
                spin(node)
            finally:
                with contextlib.suppress(Exception):
                    node.stop()
                node.leave()
                sys.stdout.write("Stopped.\n")
