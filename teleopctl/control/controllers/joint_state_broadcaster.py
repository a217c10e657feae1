"""Broadcaster of joint states."""

from __future__ import annotations

import math
from array import array
from typing import Any

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.handles import EFFORT, POSITION, VELOCITY, StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.interfaces import PreparedMessage, set_stamp

_FIELDS = (POSITION, VELOCITY, EFFORT)


class JointStateBroadcaster(ControllerInterface):
    """Controller that publishes joints' state interfaces as ``joint_states``.

    Plug-in type ``joint_state_broadcaster/JointStateBroadcaster``.
    """

    def on_init(self) -> None:
        """Declare the broadcaster's parameters, such as ``joints`` and ``interfaces``."""
        self.auto_declare("joints", [])
        self.auto_declare("interfaces", [])
        self.auto_declare("extra_joints", [])
        self.auto_declare("use_local_topics", False)
        self.auto_declare("use_urdf_to_filter", True)
        self.auto_declare("frame_id", "base_link")
        self.auto_declare("publish_dynamic_joint_states", True)
        for field in _FIELDS:
            self.auto_declare(f"map_interface_to_joint_state.{field}", field)

    def on_configure(self) -> None:
        """Read the parameters; create publishers of ``joint_states`` and dynamic_joint_states."""
        from teleopctl.interfaces import get_message

        self._joints: list[str] = self.auto_declare("joints", [])
        self._interfaces: list[str] = self.auto_declare("interfaces", [])
        self._extra_joints: list[str] = self.auto_declare("extra_joints", [])
        self._frame_id: str = self.auto_declare("frame_id", "base_link")
        if bool(self._joints) != bool(self._interfaces):
            self.logger.warning(
                "Only one of 'joints' and 'interfaces' is set: all available state interfaces "
                "will be published."
            )
        joint_state = get_message("sensor_msgs/msg/JointState")
        # Messages are created once and reused.
        self._message: Any = joint_state()
        self._message.header.frame_id = self._frame_id
        self._prepared: PreparedMessage | None = None
        prefix = "~/" if self.auto_declare("use_local_topics", False) else ""
        self._publisher = self.get_node().create_publisher(joint_state, f"{prefix}joint_states", 10)
        self._realtime_publisher = RealtimePublisher(self.params.publish_queue, self._publish)
        self._dynamic: Any = None
        if self.auto_declare("publish_dynamic_joint_states", True):
            dynamic_state = get_message("control_msgs/msg/DynamicJointState")
            self._interface_value: Any = get_message("control_msgs/msg/InterfaceValue")
            self._dynamic_message: Any = dynamic_state()
            self._dynamic_message.header.frame_id = self._frame_id
            self._dynamic = self.get_node().create_publisher(
                dynamic_state, f"{prefix}dynamic_joint_states", 10
            )
            self._realtime_dynamic = RealtimePublisher(
                self.params.publish_queue, self._publish_dynamic
            )

    def on_cleanup(self) -> None:
        """Destroy the publishers of joint states."""
        self.get_node().destroy_publisher(self._publisher)
        if self._dynamic is not None:
            self.get_node().destroy_publisher(self._dynamic)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces of ``joints`` times ``interfaces``, or all available ones."""
        if self._joints and self._interfaces:
            return InterfaceConfiguration(
                InterfaceConfigurationType.INDIVIDUAL,
                [f"{joint}/{name}" for joint in self._joints for name in self._interfaces],
            )
        return InterfaceConfiguration(InterfaceConfigurationType.ALL)

    def on_activate(self) -> CallbackReturn | None:
        """Set the joint names of the messages; return FAILURE if no interface has type double."""
        states = [state for state in self.state_interfaces if state.data_type == "double"]
        if not states:
            self.logger.error("None of requested interfaces exist. Controller will not run.")
            return CallbackReturn.FAILURE
        by_prefix: dict[str, dict[str, StateInterface]] = {}
        for state in states:
            by_prefix.setdefault(state.prefix_name, {})[state.interface_name] = state
        mapping = [
            self.auto_declare(f"map_interface_to_joint_state.{name}", name) for name in _FIELDS
        ]
        in_urdf = self.params.joint_limits
        filtered = self.auto_declare("use_urdf_to_filter", True) and bool(in_urdf)
        joints = [
            prefix
            for prefix, interfaces in by_prefix.items()
            if any(name in interfaces for name in mapping)
            and (not filtered or prefix in in_urdf or bool(self._joints))
        ]
        extra = [joint for joint in self._extra_joints if joint not in joints]
        self._message.name = [*joints, *extra]
        # The value of a missing interface stays NaN: the interface below is never written.
        unknown = StateInterface("", "unknown")
        zero = StateInterface("", "zero", initial_value=0.0)
        self._columns = [
            [by_prefix[joint].get(name, unknown) for joint in joints] + [zero] * len(extra)
            for name in mapping
        ]
        unmeasured = [math.nan] * len(self._message.name)
        for field in _FIELDS:
            setattr(self._message, field, unmeasured)
        self._prepared = PreparedMessage(self._message, _FIELDS)
        if self._dynamic is not None:
            self._lay_out_dynamic(
                by_prefix | {joint: {POSITION: zero} for joint in extra if joint not in by_prefix}
            )
        return None

    def _lay_out_dynamic(self, by_prefix: dict[str, dict[str, StateInterface]]) -> None:
        self._dynamic_message.joint_names = list(by_prefix)
        self._dynamic_message.interface_values = [
            self._interface_value(interface_names=list(interfaces))
            for interfaces in by_prefix.values()
        ]
        self._dynamic_rows = [list(interfaces.values()) for interfaces in by_prefix.values()]

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Queue the values of the state interfaces for publishing to the subscribers, if any."""
        del period
        if self._publisher.has_subscribers:
            self._realtime_publisher.try_publish(
                (time_ns, [[state.value for state in column] for column in self._columns])
            )
        if self._dynamic is not None and self._dynamic.has_subscribers:
            self._realtime_dynamic.try_publish(
                (time_ns, [[state.value for state in row] for row in self._dynamic_rows])
            )
        return None

    def _publish(self, value: tuple[int, list[list[float]]]) -> None:
        time_ns, columns = value
        prepared = self._prepared
        assert prepared is not None
        prepared.set_stamp(time_ns)
        for numbers, column in zip(prepared.numbers.values(), columns, strict=True):
            numbers[:] = memoryview(array("d", column))
        self._publisher.publish(prepared.data)

    def _publish_dynamic(self, value: tuple[int, list[list[float]]]) -> None:
        time_ns, rows = value
        message = self._dynamic_message
        set_stamp(message.header.stamp, time_ns)
        for interfaces, values in zip(message.interface_values, rows, strict=True):
            interfaces.values = values
        self._dynamic.publish(message)
