"""Executable ``teleop_device``: drives a robot by a teleoperation device, a plug-in."""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from teleopctl import plugins
from teleopctl.base import progress
from teleopctl.base.keyboard import SPACE, Keyboard
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import (
    Clock,
    ClockType,
    ExternalShutdownException,
    Node,
    Parameter,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    spin,
)
from teleopctl.nodes.single_instance import require_single_instance
from teleopctl.nodes.teleop.hand_driver import HandDriver
from teleopctl.nodes.teleop.leader_follower import LeaderFollower
from teleopctl.nodes.teleop.status_lines import StatusLines, who_drives
from teleopctl.teleop import (
    ANGULAR,
    LINEAR,
    DeviceError,
    HandCommand,
    HandMapping,
    HandSample,
    LeaderMapping,
    PoseClutch,
    TeleopDevice,
)
from teleopctl.tf import Transform

# Period in which a leader's silence is noticed, and in which the state is shown, s.
_CHECKED_S, _SHOWN_S = 0.05, 0.25
# Period in which it is noticed that the robot is gone, s.
_LOOK_S = 0.3
_KEYS = "Keys: space stops, r releases the stop, t takes over, q ends"
_LEADER_KEYS = "Keys: e begins and ends to follow, space stops, r releases the stop, q ends"

# Any, here and below: message classes are generated at run time from definitions.


class DeviceNode(Node):
    """Node that drives a robot by a teleoperation device.

    Its parameters are ``device``, ``mapping`` (a name or a file), ``servo`` (name of the servo
    node), ``cmd_vel`` (topic of a mobile base that is to be driven), ``leader_timeout`` (silence
    of a leader, s), and those of the device.

    Attributes:
        failure: Why the device cannot drive this robot; None if it can.
    """

    def __init__(self, overrides: Sequence[Parameter] = ()) -> None:
        super().__init__("teleop_device", parameter_overrides=list(overrides))
        name = str(self.declare_parameter("device", "gamepad").value)
        self._named = str(self.declare_parameter("mapping", "").value)
        servo = str(self.declare_parameter("servo", "servo_node").value)
        base = str(self.declare_parameter("cmd_vel", "").value)
        silence_s = float(self.declare_parameter("leader_timeout", 0.25).value)
        self.failure: TeleopctlError | None = None
        kind: type[TeleopDevice] = plugins.load(plugins.TELEOP_DEVICES, name)
        self.name = name
        self._mapping: HandMapping | None = None
        self._mapped_for: tuple[str, bool] | None = None
        # What was last logged of missing inputs.
        self._lacked = ""
        # Newest sample with its mapping, and its command.
        self._mapped: tuple[HandSample, HandMapping] | None = None
        self._command = HandCommand()
        self._clutch = PoseClutch()
        self.leader: LeaderFollower | None = None
        self._shown: dict[str, str] = {}
        self._shown_s = 0.0
        self.lines = StatusLines()
        self.driver = HandDriver(self, name, servo, base)
        self.driver.on_action = self.act
        self.device = kind(self, self._receive)
        if kind.gives_joints:
            self.leader = LeaderFollower(
                self,
                self.driver,
                LeaderMapping.load(self._named or kind.mapping),
                str(getattr(self.device, "namespace", "")).rstrip("/"),
                silence_s,
            )
            self.create_service(get_service("std_srvs/srv/SetBool"), "~/engage", self._on_engage)
        else:
            self._mapping = HandMapping.load(self._named or kind.mapping)
        self._state: Any = get_message("diagnostic_msgs/msg/DiagnosticStatus")(name=name)
        self._key_value: Any = get_message("diagnostic_msgs/msg/KeyValue")
        self._states = self.create_publisher(type(self._state), "~/state", qos_profile_latched)
        try:
            require_single_instance(self)
            self.device.start()
            self._check_inputs()
        except BaseException:
            self.destroy_node()
            raise
        self.driver.on_watch = self._show_in_time
        if self.leader is not None:
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self.create_timer(_CHECKED_S, self.leader.check, clock=steady)

    def _check_inputs(self) -> None:
        """Raise an error if the device lacks what its mapping uses to move and stop.

        What it lacks beyond that is named in the log.

        Raises:
            DeviceError: An input is missing.
        """
        known = self.device.inputs()
        if self._mapping is None or not known:
            return
        missing = sorted(self._mapping.all_inputs() - known)
        if not missing:
            return
        sentence = (
            f"The {self.name} has no {', '.join(missing)}, which its mapping uses; it has "
            f"{', '.join(sorted(known))}"
        )
        if self._mapping.inputs() - known:
            raise DeviceError(
                sentence,
                hint="Write a mapping for it, and name its file with the parameter mapping.",
            )
        if sentence != self._lacked:
            self._lacked = sentence
            self.get_logger().warning(sentence)

    # --- samples ----------------------------------------------------------------------------------

    def _receive(self, sample: HandSample) -> None:
        try:  # noqa: SIM105 -- with each sample
            self._on_sample(sample)
        except ExternalShutdownException:
            pass  # a device's own thread may still run when the program ends

    def _on_sample(self, sample: HandSample) -> None:
        if self.leader is not None:
            self.leader.receive(sample)
            return
        assert self._mapping is not None
        mapping = self._mapping
        mapped = self._mapped
        if mapped is None or sample is not mapped[0] or mapping is not mapped[1]:
            self._mapped, command = (sample, mapping), mapping.command(sample)
            # The driver knows a command that comes again by its identity.
            if command != self._command:
                self._command = command
        if sample.pose and self._pull(sample.pose, is_held=mapping.holds(sample)):
            return
        self.driver.apply(self._command, mapping.speeds)

    def _pull(self, pose: tuple[float, ...], *, is_held: bool) -> bool:
        """Move the tool with the device's pose while the clutch is held; return whether it is."""
        tool = self.driver.tool()
        if not is_held or tool is None:
            if self._clutch.is_held:
                self._clutch.release()
                self.driver.pull(None)
            return False
        x, y, z, *rotation = pose
        hand = Transform((x, y, z), (rotation[0], rotation[1], rotation[2], rotation[3]))
        self.driver.pull(self._clutch.hold(hand, tool))
        return True

    def act(self, action: str) -> str:
        """Execute an action of a button, key or service; return why not, empty if it is done."""
        if self.leader is None or action not in ("engage", "disengage"):
            return ""
        if action == "engage":
            return self.leader.engage()
        self.leader.release()
        return ""

    def _on_engage(self, request: Any, response: Any) -> Any:
        refusal = self.act("engage" if request.data else "disengage")
        response.success = not refusal
        response.message = refusal or self._doing(self.driver.state(self._speeds()))
        return response

    def on_key(self, key: str) -> None:
        """Process a key of the terminal."""
        if key == SPACE:
            self.driver.press_stop()
        elif key == "r":
            self.driver.release_stop()
        elif key == "t":
            self.driver.take_over()
        elif key == "e" and self.leader is not None:
            self.act("disengage" if self.leader.is_engaged else "engage")
        elif key == "q":
            self.context.try_shutdown()

    def close(self) -> None:
        """Release all inputs, and close the device."""
        if self.leader is not None:
            self.leader.release()
        self.device.stop()
        self.driver.close()

    # --- what is shown ----------------------------------------------------------------------------

    def _show_in_time(self) -> None:
        """Show the state if it was shown some time ago; with the driver's timer, to wake less."""
        now_s = time.monotonic()
        if now_s - self._shown_s >= _SHOWN_S:
            self._shown_s = now_s
            self._follow_robot()
            self._show()

    def _follow_robot(self) -> None:
        """Load the mapping for the robot once the robot's name is known."""
        robot = (self.driver.robot, self.driver.is_base)
        if not robot[0] or robot == self._mapped_for:
            return
        self._mapped_for = robot
        named = self._named or self.device.mapping
        try:
            if self.leader is not None:
                self.leader.mapping = LeaderMapping.load(named, robot[0])
            else:
                self._mapping = HandMapping.load(named, robot[0], is_base=robot[1])
                self._check_inputs()
        except TeleopctlError as error:
            self.failure = error
            raise ExternalShutdownException from error

    def _doing(self, state: Mapping[str, Any]) -> str:
        if self.leader is not None:
            following = self.leader.state
            return str(following) if self.leader.is_engaged else "released: e engages"
        values = zip((*LINEAR, *ANGULAR), (*state["linear"], *state["angular"]), strict=True)
        asked = [f"{name} {value:+.2f}" for name, value in values if value]
        return f"moves {', '.join(asked)}" if state["is_moving"] else "still"

    def _speeds(self) -> tuple[float, ...]:
        return (1.0,) if self._mapping is None else self._mapping.speeds

    def _show(self) -> None:
        speeds = self._speeds()
        state = self.driver.state(speeds)
        steps = f", step {state['speed_step'] + 1} of {len(speeds)}" if len(speeds) > 1 else ""
        texts = {
            "doing": self._doing(state),
            "robot": str(state["robot"]),
            "problem": str(state["problem"]) or (self.leader.problem if self.leader else ""),
            "speed": f"{state['speed_m_s']:.2f} m/s, {state['speed_rad_s']:.2f} rad/s{steps}",
            "words": str(state["words"]),
            "status": str(state["status"]),
            "refusal": str(state["refusal"]),
            "stopped_by": ", ".join(state["stopped_by"]),
            "holder": _holder_text(state["holder"]),
            "engaged": "true" if self.leader is not None and self.leader.is_engaged else "",
        }
        if texts == self._shown:
            return
        self._shown = texts
        self._state.level = b"\x01" if texts["problem"] or texts["refusal"] else b"\x00"
        self._state.message = texts["doing"]
        self._state.values = [
            self._key_value(key=name, value=value) for name, value in texts.items()
        ]
        self._states.publish(self._state)
        if sys.stdout is not None and sys.stdout.isatty():
            stopped = f"The robot is stopped by {texts['stopped_by']}" * bool(texts["stopped_by"])
            self.lines.show(
                (
                    f"{self.name}: {texts['doing']} | {texts['speed']}",
                    who_drives(texts["holder"]),
                    stopped or texts["refusal"] or texts["problem"] or texts["words"],
                    # The sentence of a refusal is servo's own.
                    "" if stopped or texts["status"] == texts["words"] else texts["status"],
                )
            )


def _holder_text(holder: Mapping[str, Any] | None) -> str:
    return "" if holder is None else f"{holder['node']} ({holder['device']})"


def check_device(name: str, mapping: str | None = None) -> None:
    """Check that a device and its mapping are there, before a robot is started for them.

    Args:
        name: Name of the device.
        mapping: Name or file of the mapping; None for the device's own.

    Raises:
        UnknownPluginError: There is no such device.
        BrokenPluginError: The device cannot be imported.
        DeviceError: The device is not there.
        NotFoundError: There is no such mapping.
        InvalidFileError: The mapping's file cannot be read, or is no mapping.
    """
    kind: type[TeleopDevice] = plugins.load(plugins.TELEOP_DEVICES, name)
    kind.check()
    if mapping is not None:
        (LeaderMapping if kind.gives_joints else HandMapping).load(mapping)


def main(args: Sequence[str] | None = None) -> None:
    """Drive a robot by a device until Ctrl-C.

    Raises:
        TeleopctlError: There is no such device, or it cannot drive this robot.
    """
    arguments = sys.argv if args is None else args
    parser = argparse.ArgumentParser(
        prog="teleop_device",
        description="Drive a robot by a device: " + ", ".join(plugins.available(_KIND)),
    )
    parser.add_argument("device", nargs="?", default="", help="name of the device; gamepad")
    parser.add_argument("--mapping", default="", help="a mapping's name, or its YAML file")
    parser.add_argument(
        "--leader", default="", metavar="NAMESPACE", help="namespace of a leader arm; /leader"
    )
    options = parser.parse_args(parse_ros_arguments(arguments).program[1:])
    given = {name: value for name, value in vars(options).items() if value}
    if "leader" in given:
        given.setdefault("device", "leader")
    drive([Parameter(name, value=value) for name, value in given.items()], arguments)


_KIND = plugins.TELEOP_DEVICES


def drive(
    overrides: Sequence[Parameter],
    args: Sequence[str] | None = None,
    is_wanted: Callable[[], bool] | None = None,
) -> None:
    """Drive a robot by a device until Ctrl-C.

    Args:
        overrides: Parameters of the node.
        args: ROS arguments.
        is_wanted: Function that returns False once the robot is gone, which ends it; None if it
            is not looked at.

    Raises:
        TeleopctlError: There is no such device, or it cannot drive this robot.
    """
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=args, publishes_after_signal=True),
    ):
        node = DeviceNode(overrides)

        def look(is_wanted: Callable[[], bool]) -> None:
            if not is_wanted():
                raise ExternalShutdownException

        if is_wanted is not None:
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            node.create_timer(_LOOK_S, partial(look, is_wanted), clock=steady)
        reads_keys = not node.device.reads_terminal
        if sys.stdout is not None and sys.stdout.isatty():
            keys = _KEYS if node.leader is None else _LEADER_KEYS
            texts = [node.device.help, keys if reads_keys else ""]
            sys.stdout.write("".join(f"{text}\n" for text in texts if text))
        progress.report(progress.READY)
        try:
            with Keyboard(node.on_key, wanted=reads_keys):
                spin(node)
        finally:
            with contextlib.suppress(Exception):
                node.lines.end()
                node.close()
            if node.failure is not None:
                raise node.failure
