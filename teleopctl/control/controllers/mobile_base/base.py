"""What controllers of wheeled bases have in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.mobile_base.odometry import Odometry
from teleopctl.control.controllers.mobile_base.odometry_publisher import OdometryPublisher
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity, VelocityInput
from teleopctl.control.handles import POSITION, VELOCITY, CommandInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType


class InvalidBaseError(Exception):
    """The parameters are invalid for a mobile base; the message says why."""


class MobileBaseController(ControllerInterface):
    """Base of controllers that drive a base by velocities and publish its odometry.

    It stands still until a velocity comes, and when none has come for the timeout. Its odometry
    starts at the origin when it is activated for the first time.
    """

    command_topic: ClassVar[str] = "~/cmd_vel"
    unstamped_topic: ClassVar[str] = "~/cmd_vel_unstamped"
    odometry_topic: ClassVar[str] = "~/odom"
    transform_topic: ClassVar[str] = "/tf"
    timeout_parameter: ClassVar[str] = "cmd_vel_timeout"
    default_timeout: ClassVar[float] = 0.5
    default_publish_rate: ClassVar[float] = 50.0

    # -- what a kind of base says ------------------------------------------------------------------

    def read_parameters(self) -> None:
        """Read the parameters of the base's geometry and interfaces.

        Raises:
            InvalidBaseError: It cannot be.
        """
        raise NotImplementedError

    def read_timeout(self) -> float:
        """Return the timeout of velocity commands in seconds; 0 is none."""
        return self.auto_declare(self.timeout_parameter, self.default_timeout)

    def command_names(self) -> Sequence[str]:
        """Return the command interfaces."""
        raise NotImplementedError

    def feedback_names(self) -> Sequence[str]:
        """Return the state interfaces for the odometry."""
        raise NotImplementedError

    def wanted_velocity(self, time_ns: int) -> BaseVelocity:
        """Return the requested velocity; by default that of the topic."""
        return self._input.read(time_ns)

    def limit(self, velocity: BaseVelocity, period: float) -> BaseVelocity:
        """Return the velocity that may be commanded; by default unlimited."""
        del period
        return velocity

    def moved(self, values: Sequence[float], last: Sequence[float], period: float) -> BaseVelocity:
        """Return the displacement of the base (m, m, rad) since the last update.

        Args:
            values: Of the state interfaces.
            last: What they were.
            period: Seconds since.
        """
        raise NotImplementedError

    def wheels(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return the command interfaces' values for a velocity of the base."""
        raise NotImplementedError

    def commanded(self, time_ns: int, velocity: BaseVelocity) -> None:
        """Handle the velocity that was commanded, such as by publishing it."""

    # -- life cycle --------------------------------------------------------------------------------

    def on_init(self) -> None:
        """Declare the parameters that all mobile bases have."""
        self.auto_declare("open_loop", False)
        self.auto_declare("position_feedback", True)

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters and make the topics."""
        try:
            self.read_parameters()
        except InvalidBaseError as error:
            self.logger.error(str(error))
            return CallbackReturn.ERROR
        self._open_loop = self.auto_declare("open_loop", False)
        self._odometry = Odometry(self.auto_declare("velocity_rolling_window_size", 10))
        self._input = VelocityInput(
            self,
            self.command_topic,
            self.unstamped_topic,
            self.read_timeout(),
        )
        self._publisher = OdometryPublisher(
            self,
            self.odometry_topic,
            self.transform_topic,
            self.auto_declare("publish_rate", self.default_publish_rate),
        )
        return None

    def on_cleanup(self) -> None:
        """Destroy the topics."""
        self._input.close()
        self._publisher.close()

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces of the wheels."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self.command_names())

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces of the odometry; none in open loop."""
        if self._open_loop:
            return InterfaceConfiguration(InterfaceConfigurationType.NONE)
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self.feedback_names())

    @property
    def feedback_type(self) -> str:
        """Kind of state interface of the driven wheels: position or velocity."""
        return POSITION if self.auto_declare("position_feedback", True) else VELOCITY

    def on_activate(self) -> None:
        """Set the base to rest."""
        self._input.forget()
        self._publisher.restart()
        self._last: list[float] | None = None
        self._input.active = True

    def on_restart(self) -> None:
        """Stop, and reset the odometry: the simulation was reset."""
        self._odometry.reset()
        self.on_activate()

    def on_deactivate(self) -> None:
        """Stop the wheels."""
        self._input.active = False
        for interface, value in zip(
            self.command_interfaces, self.wheels(BaseVelocity()), strict=True
        ):
            interface.value = value

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Command the wheels and publish the odometry."""
        velocity = self.limit(self.wanted_velocity(time_ns), period)
        if self._open_loop:
            self._odometry.advance(
                velocity.x * period, velocity.angular * period, period, velocity.y * period
            )
        elif not self._measure(period):
            if self._last is None:
                return None  # a simulation that is paused has not told yet where its wheels are
            self.logger.error(
                f"A wheel's {self.feedback_type} is not a number", throttle_duration_sec=1.0
            )
            return ReturnType.ERROR
        self._publisher.try_publish(time_ns, self._odometry)
        for interface, value in zip(self.command_interfaces, self.wheels(velocity), strict=True):
            interface.value = value
        self.commanded(time_ns, velocity)
        return None

    def _measure(self, period: float) -> bool:
        """Bring the odometry up to date; False where something is not measured."""
        values = [state.value for state in self.state_interfaces]
        if not all(map(math.isfinite, values)):
            return False
        if self._last is not None:
            way = self.moved(values, self._last, period)
            self._odometry.advance(way.x, way.angular, period, way.y)
        self._last = values
        return True


class ChainableBase(MobileBaseController, ChainableControllerInterface):
    """A base whose velocity is a reference: ``NAME/linear/velocity``, ``NAME/angular/velocity``.

    In chained mode the references are the velocity at each update, however old they are; while one
    of them is not a number the base stands still.
    """

    references: ClassVar[Sequence[str]] = ("linear", "angular")

    def on_export_reference_interfaces_list(self) -> list[CommandInterface]:
        """Return the reference interfaces of the velocity's components."""
        return [CommandInterface(f"{self.name}/{part}", VELOCITY) for part in self.references]

    def wanted_velocity(self, time_ns: int) -> BaseVelocity:
        """Return the references in chained mode, else the velocity of the topic."""
        if not self.in_chained_mode:
            return super().wanted_velocity(time_ns)
        values = [reference.value for reference in self.reference_interfaces]
        if not all(map(math.isfinite, values)):
            return BaseVelocity()
        x, *sideways, angular = values
        return BaseVelocity(x, sideways[0] if sideways else 0.0, angular)
