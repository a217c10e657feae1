"""Publishes what is measured: ``/joint_states`` and ``dynamic_joint_states``."""

from __future__ import annotations

from typing import Any

from teleopctl.control.controllers.base import ControllerInterface, InterfaceSelection
from teleopctl.control.interfaces import EFFORT, POSITION, VELOCITY, StateInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType

_FIELDS = (POSITION, VELOCITY, EFFORT)


class JointStateBroadcaster(ControllerInterface):
    """``joint_state_broadcaster/JointStateBroadcaster``."""

    def on_init(self) -> None:
        """Declare the parameters."""
        self.parameter("joints", [])
        self.parameter("interfaces", [])
        self.parameter("extra_joints", [])
        self.parameter("use_local_topics", False)
        self.parameter("use_urdf_to_filter", True)
        self.parameter("frame_id", "base_link")
        self.parameter("publish_dynamic_joint_states", True)
        for field in _FIELDS:
            self.parameter(f"map_interface_to_joint_state.{field}", field)

    def on_configure(self) -> None:
        """Read the parameters and make the publishers."""
        from teleopctl.interfaces.store import get_message

        self._joints: list[str] = self.parameter("joints", [])
        self._interfaces: list[str] = self.parameter("interfaces", [])
        self._extra_joints: list[str] = self.parameter("extra_joints", [])
        self._frame_id: str = self.parameter("frame_id", "base_link")
        if bool(self._joints) != bool(self._interfaces):
            self.logger.warning(
                "Only one of 'joints' and 'interfaces' is set: all available state interfaces "
                "will be published."
            )
        self._time: Any = get_message("builtin_interfaces/msg/Time")
        self._joint_state: Any = get_message("sensor_msgs/msg/JointState")
        prefix = "~/" if self.parameter("use_local_topics", False) else ""
        self._publisher = self.node.create_publisher(self._joint_state, f"{prefix}joint_states", 10)
        self._channel = self.env.outbox.channel(self._publish)
        self._dynamic: Any = None
        if self.parameter("publish_dynamic_joint_states", True):
            self._dynamic_state: Any = get_message("control_msgs/msg/DynamicJointState")
            self._interface_value: Any = get_message("control_msgs/msg/InterfaceValue")
            self._dynamic = self.node.create_publisher(
                self._dynamic_state, f"{prefix}dynamic_joint_states", 10
            )
            self._dynamic_channel = self.env.outbox.channel(self._publish_dynamic)

    def on_cleanup(self) -> None:
        """Remove the publishers."""
        self.node.destroy_publisher(self._publisher)
        if self._dynamic is not None:
            self.node.destroy_publisher(self._dynamic)

    def wanted_states(self) -> InterfaceSelection:
        """The selected interfaces, or all."""
        if self._joints and self._interfaces:
            return InterfaceSelection(
                [f"{joint}/{name}" for joint in self._joints for name in self._interfaces]
            )
        return InterfaceSelection(everything=True)

    def on_activate(self) -> CallbackReturn | None:
        """Lay out the messages."""
        states = [state for state in self.state_interfaces if state.data_type == "double"]
        if not states:
            self.logger.error("None of requested interfaces exist. Controller will not run.")
            return CallbackReturn.ERROR
        by_prefix: dict[str, dict[str, StateInterface]] = {}
        for state in states:
            by_prefix.setdefault(state.prefix, {})[state.name] = state
        mapping = [self.parameter(f"map_interface_to_joint_state.{name}", name) for name in _FIELDS]
        in_urdf = self.env.limits
        filtered = self.parameter("use_urdf_to_filter", True) and bool(in_urdf)
        joints = [
            prefix
            for prefix, interfaces in by_prefix.items()
            if any(name in interfaces for name in mapping)
            and (not filtered or prefix in in_urdf or bool(self._joints))
        ]
        extra = [joint for joint in self._extra_joints if joint not in joints]
        self._names = [*joints, *extra]
        # A quantity that no joint has stays NaN for all: the interface below is never written.
        unknown = StateInterface("", "unknown")
        zero = StateInterface("", "zero", initial_value=0.0)
        self._columns = [
            [by_prefix[joint].get(name, unknown) for joint in joints] + [zero] * len(extra)
            for name in mapping
        ]
        self._dynamic_layout = [
            (prefix, list(interfaces)) for prefix, interfaces in by_prefix.items()
        ] + [(joint, [POSITION]) for joint in extra if joint not in by_prefix]
        self._dynamic_states = [
            state for interfaces in by_prefix.values() for state in interfaces.values()
        ] + [zero for joint in extra if joint not in by_prefix]
        return None

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Offer the measured values to the outbox."""
        del period
        self._channel.offer(
            (time_ns, [[state.value for state in column] for column in self._columns])
        )
        if self._dynamic is not None:
            self._dynamic_channel.offer((time_ns, [s.value for s in self._dynamic_states]))
        return None

    def _header_into(self, message: Any, time_ns: int) -> None:
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        message.header.stamp = self._time(sec=sec, nanosec=nanosec)
        message.header.frame_id = self._frame_id

    def _publish(self, value: tuple[int, list[list[float]]]) -> None:
        time_ns, (position, velocity, effort) = value
        message = self._joint_state(
            name=self._names, position=position, velocity=velocity, effort=effort
        )
        self._header_into(message, time_ns)
        self._publisher.publish(message)

    def _publish_dynamic(self, value: tuple[int, list[float]]) -> None:
        if not self._dynamic.get_subscription_count():
            return
        time_ns, values = value
        message = self._dynamic_state()
        self._header_into(message, time_ns)
        start = 0
        for joint, names in self._dynamic_layout:
            end = start + len(names)
            message.joint_names.append(joint)
            message.interface_values.append(
                self._interface_value(interface_names=names, values=values[start:end])
            )
            start = end
        self._dynamic.publish(message)
