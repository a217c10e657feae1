"""Forward command controllers, which write each received command at once."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any, ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.handles import ACCELERATION, EFFORT, POSITION, VELOCITY
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.interfaces import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from teleopctl.node import MessageInfo

# Longest time between two commands that are streamed, in nanoseconds.
_STREAMED_NS = NANOSECONDS_PER_SECOND // 10


class ForwardCommandController(ControllerInterface):
    """Controller that writes the values on ``~/commands`` to one interface of each joint.

    Plug-in type ``forward_command_controller/ForwardCommandController``.

    With the parameter ``cmd_timeout``, in seconds, which is an extension of teleopctl, a command is
    valid that long: then velocities, efforts and accelerations are 0, and positions are held.
    """

    zero_on_deactivate: ClassVar[bool] = False

    def on_init(self) -> None:
        """Declare the parameters ``joints`` and ``interface_name``."""
        self.auto_declare("joints", [])
        self.auto_declare("interface_name", "")

    def interface_names(self) -> list[str]:
        """Return the full names of the command interfaces, in the order of message data."""
        name = self.auto_declare("interface_name", "")
        joints: list[str] = self.auto_declare("joints", [])
        return [f"{joint}/{name}" for joint in joints] if name else []

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters and subscribe to ``~/commands``; return ERROR without interfaces."""
        from teleopctl.interfaces import get_message

        self._names = self.interface_names()
        if not self._names:
            self.logger.error("Parameters that name joints and interfaces cannot be empty")
            return CallbackReturn.ERROR
        timeout = self.auto_declare("cmd_timeout", 0.0)
        if not 0.0 <= timeout < math.inf:
            self.logger.error(f"Parameter 'cmd_timeout' must be at least 0 s, got {timeout:g}")
            return CallbackReturn.FAILURE
        self._timeout_ns = round(timeout * NANOSECONDS_PER_SECOND)
        self._since_ns = self._now_ns = self._changed_ns = 0
        self._is_step = True
        self._limits = [self._velocity_limit(name) for name in self._names]
        self._log = realtime_log(self.params.publish_queue)
        self._incoming: deque[list[float]] = deque(maxlen=1)
        self._command: list[float] | None = None
        self._subscription = self.get_node().create_subscription(
            get_message("std_msgs/msg/Float64MultiArray"), "~/commands", self._received, 10
        )
        return None

    def on_cleanup(self) -> None:
        """Destroy the subscription to ``~/commands``."""
        self.get_node().destroy_subscription(self._subscription)

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces that the parameters name."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self._names)

    def on_activate(self) -> None:
        """Discard commands that were received earlier."""
        self._incoming.clear()
        self._command = None

    def on_deactivate(self) -> None:
        """Discard the last command; velocity and effort group controllers command zero."""
        self._incoming.clear()
        self._command = None
        if self.zero_on_deactivate:
            for interface in self.command_interfaces:
                interface.value = 0.0

    def _velocity_limit(self, interface: str) -> float:
        """Return the velocity limit of the joint of a position interface; infinite for others."""
        prefix, _, kind = interface.rpartition("/")
        limits = self.params.joint_limits.get(prefix.rpartition("/")[2])
        return limits.velocity if limits is not None and kind == POSITION else math.inf

    def export_state(self) -> object:
        """Return the last command, with its times, and one that has just been received."""
        times = self._since_ns, self._changed_ns, self._is_step
        return self._command, times, list(self._incoming)

    def import_state(
        self, state: tuple[list[float] | None, tuple[int, int, bool], list[list[float]]]
    ) -> None:
        """Continue with the last command of the replaced instance."""
        self._command, times, incoming = state
        self._since_ns, self._changed_ns, self._is_step = times
        self._incoming.extend(incoming)

    def on_restart(self) -> None:
        """Discard the last command after a simulation reset."""
        self._command = None

    @property
    def seconds_since_step(self) -> float:
        """Seconds since the last command, if it is a step; NaN if commands are streamed.

        A command is streamed if it is a tenth of a second old at most, came at most that long after
        the command before, and is no further from it than the joints move in that time.
        """
        age_ns = self._now_ns - self._changed_ns
        is_streamed = not self._is_step and age_ns <= _STREAMED_NS
        return math.nan if is_streamed else age_ns / NANOSECONDS_PER_SECOND

    def on_stop(self) -> None:
        """Discard received commands; commands are refused while the robot is stopped."""
        self._incoming.clear()
        self._command = None

    def on_release(self) -> None:
        """Do nothing: the interfaces keep their values until the next command."""

    def _received(self, message: Any, info: MessageInfo) -> None:
        if self.is_refused("The command on ~/commands", info["publisher_gid"]):
            return
        data = [float(value) for value in message.data]
        for index, value in enumerate(data):
            if not math.isfinite(value):
                name = self._names[index] if index < len(self._names) else f"value {index}"
                self.logger.warning(
                    f"Non-finite value received. Dropping message: {value} for {name}"
                )
                return
        self._incoming.append(data)

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Write the last received command to the interfaces; return ERROR for a wrong length."""
        self._now_ns = time_ns
        if self._incoming:
            self._take(self._incoming.pop(), time_ns, period)
        command = self._command
        if command is None:
            return None
        if self._timeout_ns and time_ns - self._since_ns > self._timeout_ns:
            self._end_command()
            return None
        if len(command) != len(self.command_interfaces):
            self.logger.error(
                f"command size ({len(command)}) does not match number of interfaces "
                f"({len(self.command_interfaces)}): {', '.join(self._names)}",
                throttle_duration_sec=1.0,
            )
            return ReturnType.ERROR
        for interface, value in zip(self.command_interfaces, command, strict=True):
            interface.value = value
        return None

    def _take(self, command: list[float], time_ns: int, period: float) -> None:
        """Make a received command the present one, and note whether it is a step."""
        before, self._command, self._since_ns = self._command, command, time_ns
        if command == before:
            return
        since_ns, self._changed_ns = time_ns - self._changed_ns, time_ns
        # Messages do not arrive in step with the cycles.
        longest_s = since_ns / NANOSECONDS_PER_SECOND + period
        self._is_step = (
            before is None
            or since_ns > _STREAMED_NS
            or any(
                abs(now - then) > limit * longest_s
                for now, then, limit in zip(command, before, self._limits, strict=False)
            )
        )

    def _end_command(self) -> None:
        """Command rest after the timeout, until the next command."""
        self._command = None
        for interface in self.command_interfaces:
            if interface.interface_name in (VELOCITY, EFFORT, ACCELERATION):
                interface.value = 0.0
        seconds = self._timeout_ns / NANOSECONDS_PER_SECOND
        self._log.try_publish(
            (
                self.logger.warning,
                f"No command on ~/commands for {seconds:g} s (cmd_timeout): velocities and efforts "
                "are 0, positions are held",
            )
        )


class MultiInterfaceForwardCommandController(ForwardCommandController):
    """Controller that writes the values on ``~/commands`` to several interfaces of one joint.

    Plug-in type ``forward_command_controller/MultiInterfaceForwardCommandController``.
    """

    def on_init(self) -> None:
        """Declare the parameters ``joint`` and ``interface_names``."""
        self.auto_declare("joint", "")
        self.auto_declare("interface_names", [])

    def interface_names(self) -> list[str]:
        """Return the full names of the joint's command interfaces."""
        joint = self.auto_declare("joint", "")
        names: list[str] = self.auto_declare("interface_names", [])
        return [f"{joint}/{name}" for name in names] if joint else []


class _JointGroupController(ForwardCommandController):
    """Base of forward command controllers for one fixed kind of interface."""

    interface: ClassVar[str]

    def on_init(self) -> None:
        """Declare the parameter ``joints``."""
        self.auto_declare("joints", [])

    def interface_names(self) -> list[str]:
        """Return the full names of the joints' position, velocity or effort interfaces."""
        joints: list[str] = self.auto_declare("joints", [])
        return [f"{joint}/{self.interface}" for joint in joints]


class JointGroupPositionController(_JointGroupController):
    """Controller that writes the values on ``~/commands`` to the joints' position interfaces.

    Plug-in type ``position_controllers/JointGroupPositionController``.
    """

    interface = "position"


class JointGroupVelocityController(_JointGroupController):
    """Controller that writes the values on ``~/commands`` to the joints' velocity interfaces.

    Plug-in type ``velocity_controllers/JointGroupVelocityController``.
    """

    interface = "velocity"
    zero_on_deactivate = True


class JointGroupEffortController(_JointGroupController):
    """Controller that writes the values on ``~/commands`` to the joints' effort interfaces.

    Plug-in type ``effort_controllers/JointGroupEffortController``.
    """

    interface = "effort"
    zero_on_deactivate = True
