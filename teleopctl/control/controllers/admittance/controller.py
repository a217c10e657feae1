"""Admittance controller: adds to joint references a motion that follows from measured forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from teleopctl.control.controllers.admittance.rule import AdmittanceRule, AdmittanceState
from teleopctl.control.controllers.admittance.settings import read_gains, read_settings
from teleopctl.control.controllers.base import InterfaceConfiguration, InterfaceConfigurationType
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.handles import POSITION, VELOCITY, CommandInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import RealtimePublisher
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message

_WRENCH = tuple(f"{part}.{axis}" for part in ("force", "torque") for axis in "xyz")
_NO_WRENCH = (0.0,) * 6


class AdmittanceController(ChainableControllerInterface):
    """Controller that gives way to measured forces around joint references.

    Plug-in type ``admittance_controller/AdmittanceController``.

    The commands are the references plus the offsets of an `AdmittanceRule`. References come from
    other controllers, or from ``~/joint_references``; without any, the joints stay. A wrench on
    ``~/wrench_reference``, in the sensor's frame, is added to the measured one.
    """

    def on_init(self) -> None:
        """Register for parameter changes; the parameters are declared in ``on_configure``."""
        self._rule: AdmittanceRule | None = None
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    # -- life cycle --------------------------------------------------------------------------------

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the subscriptions and the publisher of ``~/status``."""
        try:
            self._settings = read_settings(self)
            gains = read_gains(self)
        except TeleopctlError as error:
            self.logger.error(str(error))
            return CallbackReturn.FAILURE
        settings = self._settings
        self._updates_at_once = self.auto_declare(
            "enable_parameter_update_without_reactivation", True
        )
        self._rule = AdmittanceRule(settings.chain, settings.frames, settings.alpha, gains)
        self._forget()
        node = self.get_node()
        # Any: message classes are generated at run time. The message is reused.
        status: Any = get_message("control_msgs/msg/AdmittanceControllerState")
        self._message: Any = status()
        self._lay_out_message()
        self._publisher = node.create_publisher(status, "~/status", 10)
        self._realtime = RealtimePublisher(self.params.publish_queue, self._publish)
        self._subscriptions: list[Any] = [
            node.create_subscription(
                get_message("trajectory_msgs/msg/JointTrajectoryPoint"),
                "~/joint_references",
                self._references_received,
                10,
            ),
            node.create_subscription(
                get_message("geometry_msgs/msg/WrenchStamped"),
                "~/wrench_reference",
                self._wrench_received,
                10,
            ),
        ]
        return None

    def on_cleanup(self) -> None:
        """Destroy the subscriptions and the publisher."""
        for subscription in self._subscriptions:
            self.get_node().destroy_subscription(subscription)
        self.get_node().destroy_publisher(self._publisher)
        self._rule = None

    # Any: parameters of any type.
    def _parameters_changed(self, parameters: Sequence[Any]) -> None:
        del parameters
        if self._rule is None:
            return
        try:
            self._updates_at_once = self.auto_declare(
                "enable_parameter_update_without_reactivation", True
            )
            if self._updates_at_once:
                self._rule.gains = read_gains(self)
        except TeleopctlError as error:
            self.logger.error(f"{error}. The controller keeps the earlier parameters.")

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces of all joints, one kind after the other."""
        settings = self._settings
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL,
            [
                f"{j}/{kind}"
                for kind in settings.command_interfaces
                for j in settings.command_joints
            ],
        )

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces of all joints, then those of the force-torque sensor."""
        settings = self._settings
        return InterfaceConfiguration(
            InterfaceConfigurationType.INDIVIDUAL,
            [
                *(f"{j}/{kind}" for kind in settings.state_interfaces for j in settings.joints),
                *(f"{settings.sensor}/{part}" for part in _WRENCH),
            ],
        )

    def on_export_reference_interfaces_list(self) -> list[CommandInterface]:
        """Return a new reference interface for each joint and chainable quantity."""
        settings = self._settings
        return [
            CommandInterface(f"{self.name}/{joint}", kind)
            for kind in settings.references
            for joint in settings.joints
        ]

    def on_activate(self) -> CallbackReturn | None:
        """Take the measured positions as reference; return ERROR if the parameters are invalid."""
        rule, settings = self._rule, self._settings
        assert rule is not None
        try:
            rule.gains = read_gains(self)
        except TeleopctlError as error:
            self.logger.error(str(error))
            return CallbackReturn.ERROR
        count = len(settings.joints)
        start = settings.state_interfaces.index(POSITION) * count
        self._measured_positions = self.state_interfaces[start : start + count]
        self._measured_wrench = self.state_interfaces[-len(_WRENCH) :]
        self._forget()
        rule.reset()
        self._begin()
        return None

    def _begin(self) -> None:
        """Take the measured positions as reference, as soon as all of them are known.

        A paused simulation may not have published joint states yet.
        """
        positions = [state.value for state in self._measured_positions]
        self._awaits_state = any(map(math.isnan, positions))
        # The last references and position commands, for interfaces that are NaN.
        self._reference, self._speeds = positions, [0.0] * len(positions)
        self._commanded = positions

    def on_deactivate(self) -> None:
        """Set the references to NaN, and discard received messages."""
        for reference in self.reference_interfaces:
            reference.value = math.nan
        self._forget()

    def on_restart(self) -> None:
        """Take the measured positions as reference, after a simulation reset."""
        self.on_deactivate()
        self.on_activate()

    def on_stop(self) -> None:
        """Discard received messages; references are refused while the robot is stopped."""
        self._forget()

    def on_release(self) -> None:
        """Continue from the present commands, at rest; their distance to the references is kept."""
        rule, settings = self._rule, self._settings
        assert rule is not None
        places = [state.value for state in self._measured_positions]
        if POSITION in settings.command_interfaces:
            start = settings.command_interfaces.index(POSITION) * len(places)
            places = [one.value for one in self.command_interfaces[start : start + len(places)]]
        offsets = [
            place - reference if math.isfinite(place - reference) else 0.0
            for place, reference in zip(places, self._reference, strict=True)
        ]
        rule.hold([offsets[place] for place in settings.places])

    def export_state(self) -> object:
        """Return the offsets of the joints and the references."""
        assert self._rule is not None
        return list(self._rule.joint_positions), self._reference, self._speeds

    def import_state(self, state: tuple[list[float], list[float], list[float]]) -> None:
        """Continue with the offsets of the replaced instance, from rest."""
        assert self._rule is not None
        offsets, self._reference, self._speeds = state
        self._awaits_state = False
        self._rule.hold(offsets)

    def _forget(self) -> None:
        self._received: tuple[Sequence[float], Sequence[float]] | None = None
        self._wrench_reference: Sequence[float] = _NO_WRENCH

    # -- callbacks ---------------------------------------------------------------------------------

    # Any: message classes are generated at run time.
    def _references_received(self, message: Any) -> None:
        if self.is_refused("The reference on ~/joint_references"):
            return
        count = len(self._settings.joints)
        positions, velocities = list(message.positions), list(message.velocities)
        for field, values in (("positions", positions), ("velocities", velocities)):
            if values and len(values) != count:
                self.logger.error(
                    f"Ignoring joint reference with {len(values)} {field}: there are {count} "
                    f"joints ({', '.join(self._settings.joints)})"
                )
                return
        if any(map(math.isinf, (*positions, *velocities))):
            self.logger.warning("Non-finite value received. Dropping message")
            return
        self._received = (positions, velocities)

    def _wrench_received(self, message: Any) -> None:
        if self.is_refused("The wrench on ~/wrench_reference"):
            return
        frame, expected = message.header.frame_id, self._settings.sensor_frame
        if frame not in ("", expected):
            self.logger.error(
                "Ignoring wrench reference as it is on the wrong frame: "
                f"{frame}. Expected reference frame: {expected}"
            )
            return
        force, torque = message.wrench.force, message.wrench.torque
        wrench = (force.x, force.y, force.z, torque.x, torque.y, torque.z)
        if not all(map(math.isfinite, wrench)):
            self.logger.warning("Non-finite value received. Dropping message")
            return
        self._wrench_reference = wrench

    # -- control cycle -----------------------------------------------------------------------------

    def update_reference_from_subscribers(self, time_ns: int, period: float) -> ReturnType | None:
        """Set the references from the last message on ``~/joint_references``."""
        del time_ns, period
        received = self._received
        if received is None:
            return None
        count, references = len(self._settings.joints), self.reference_interfaces
        for number, kind in enumerate(self._settings.references):
            values = received[0] if kind == POSITION else received[1]
            for reference, value in zip(references[number * count :], values, strict=False):
                reference.value = value
        return None

    def update_and_write_commands(self, time_ns: int, period: float) -> ReturnType | None:
        """Advance the rule; write references plus offsets, and queue ``~/status``."""
        del time_ns
        rule, settings = self._rule, self._settings
        assert rule is not None
        if self._awaits_state:
            self._begin()
            if self._awaits_state:
                return None
        self._read_references()
        positions = [state.value for state in self._measured_positions]
        if any(map(math.isnan, positions)):
            positions = self._commanded
        wrench: Sequence[float] = [state.value for state in self._measured_wrench]
        if any(map(math.isnan, wrench)):
            wrench = _NO_WRENCH
        wrench = [a + b for a, b in zip(wrench, self._wrench_reference, strict=True)]
        places, reference = settings.places, self._reference
        moves = not self.params.robot_stop.is_stopped and rule.update(
            [positions[place] for place in places],
            wrench,
            [reference[place] for place in places],
            period,
        )
        if not moves:
            rule.hold(rule.joint_positions)
        commanded, speeds = list(reference), list(self._speeds)
        accelerations = [0.0] * len(reference)
        for number, place in enumerate(places):
            commanded[place] += rule.joint_positions[number]
            speeds[place] += rule.joint_velocities[number]
            accelerations[place] = rule.joint_accelerations[number]
        self._commanded = commanded
        commands = iter(self.command_interfaces)
        for kind in settings.command_interfaces:
            values = (
                commanded if kind == POSITION else speeds if kind == VELOCITY else accelerations
            )
            for value in values:
                next(commands).value = value
        self._realtime.try_publish(rule.state)
        return None

    def _read_references(self) -> None:
        """Take over the references that are not NaN; set the others to the last ones."""
        count = len(self._settings.joints)
        for number, kind in enumerate(self._settings.references):
            last = self._reference if kind == POSITION else self._speeds
            values: list[float] = []
            references = self.reference_interfaces[number * count : (number + 1) * count]
            for reference, before in zip(references, last, strict=True):
                if math.isnan(reference.value):
                    reference.value = before
                values.append(reference.value)
            if kind == POSITION:
                self._reference = values
            else:
                self._speeds = values

    # -- publishing --------------------------------------------------------------------------------

    def _lay_out_message(self) -> None:
        """Set the fields of the message that stay."""
        message, settings = self._message, self._settings
        message.ft_sensor_frame.data = settings.sensor_frame
        message.joint_state.name = list(settings.chain.joints)
        for stamped in (
            message.wrench_base,
            message.admittance_velocity,
            message.admittance_acceleration,
            message.admittance_position,
            message.ref_trans_base_ft,
        ):
            stamped.header.frame_id = settings.base
        message.admittance_position.child_frame_id = "admittance_offset"
        message.ref_trans_base_ft.child_frame_id = settings.sensor_frame

    def _publish(self, state: AdmittanceState) -> None:
        message, gains = self._message, state.gains
        for field in ("mass", "damping", "stiffness"):
            getattr(message, field).data = list(getattr(gains, field))
        message.selected_axes.data = [int(selected) for selected in gains.selected_axes]
        turn = message.rot_base_control
        turn.x, turn.y, turn.z, turn.w = state.control
        for stamped, pose in (
            (message.ref_trans_base_ft, state.reference),
            (message.admittance_position, state.offset),
        ):
            place, turn = stamped.transform.translation, stamped.transform.rotation
            place.x, place.y, place.z = pose.translation
            turn.x, turn.y, turn.z, turn.w = pose.rotation
        for (linear, angular), values in (
            (_twist(message.admittance_acceleration), state.acceleration),
            (_twist(message.admittance_velocity), state.velocity),
            ((message.wrench_base.wrench.force, message.wrench_base.wrench.torque), state.wrench),
        ):
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = values
        joints = message.joint_state
        joints.position = list(state.joint_positions)
        joints.velocity = list(state.joint_velocities)
        # As in ROS 2, the efforts are accelerations.
        joints.effort = list(state.joint_accelerations)
        self._publisher.publish(message)


# Any: message classes are generated at run time.
def _twist(stamped: Any) -> tuple[Any, Any]:
    return stamped.twist.linear, stamped.twist.angular
