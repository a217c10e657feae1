"""Base classes of controllers for wheeled mobile bases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

from teleopctl.control.controllers.base import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
)
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.mobile_base.odometry import Odometry
from teleopctl.control.controllers.mobile_base.odometry_publisher import OdometryPublisher
from teleopctl.control.controllers.mobile_base.rate_limiter import RateLimiter
from teleopctl.control.controllers.mobile_base.velocity_input import BaseVelocity, VelocityInput
from teleopctl.control.handles import POSITION, VELOCITY, CommandInterface
from teleopctl.control.lifecycle import CallbackReturn, ReturnType

# Attributes of steered bases with the last steering angles, which new code takes over.
_STEERING = ("_angle", "_angles")

# Components of a pose and of a twist: x, y, z, roll, pitch, yaw.
_TWIST = 6


class InvalidBaseError(Exception):
    """Raised when the parameters of a mobile base are invalid; the message says why."""


class MobileBaseController(ControllerInterface):
    """Base class of controllers that command a mobile base's wheels and publish odometry.

    The base is at rest until a velocity command arrives, and after the timeout without one. The
    odometry starts at the origin on the first activation.
    """

    command_topic: ClassVar[str] = "~/cmd_vel"
    unstamped_topic: ClassVar[str] = "~/cmd_vel_unstamped"
    odometry_topic: ClassVar[str] = "~/odom"
    transform_topic: ClassVar[str] = "/tf"
    timeout_parameter: ClassVar[str] = "cmd_vel_timeout"
    default_timeout: ClassVar[float] = 0.5
    default_publish_rate: ClassVar[float] = 50.0
    default_window: ClassVar[int] = 10
    covariance_parameters: ClassVar[tuple[str, str]] = (
        "pose_covariance_diagonal",
        "twist_covariance_diagonal",
    )

    # -- overridden by kinds of bases --------------------------------------------------------------

    def read_parameters(self) -> None:
        """Called on configuring: read geometry and interface parameters; raise if invalid.

        Raises:
            InvalidBaseError: A parameter is missing or invalid.
        """
        raise NotImplementedError

    def read_timeout(self) -> float:
        """Return the velocity command timeout parameter in seconds; 0 is no timeout."""
        return self.auto_declare(self.timeout_parameter, self.default_timeout)

    def command_names(self) -> Sequence[str]:
        """Return the names of the wheels' command interfaces; implemented by each kind of base."""
        raise NotImplementedError

    def feedback_names(self) -> Sequence[str]:
        """Return the names of the odometry's state interfaces; implemented by each kind of base."""
        raise NotImplementedError

    def requested_velocity(self, time_ns: int) -> BaseVelocity:
        """Return the velocity to command; by default the last received, zero after the timeout."""
        return self._input.read(time_ns)

    def limit(self, velocity: BaseVelocity, period: float) -> BaseVelocity:
        """Return a requested velocity within the base's limits; by default unchanged."""
        del period
        return velocity

    def displacement(
        self, values: Sequence[float], last_values: Sequence[float], period: float
    ) -> BaseVelocity:
        """Return the base's displacement (m, m, rad) since the last update, from wheel states.

        Args:
            values: Values of the state interfaces.
            last_values: Values of the state interfaces at the last update.
            period: Seconds since the last update.
        """
        raise NotImplementedError

    def wheel_commands(self, velocity: BaseVelocity) -> Sequence[float]:
        """Return command interface values for a base velocity; implemented by each kind of base."""
        raise NotImplementedError

    def on_commanded(self, time_ns: int, velocity: BaseVelocity) -> None:
        """Called in each update with the commanded velocity; does nothing by default."""

    # -- life cycle --------------------------------------------------------------------------------

    def on_init(self) -> None:
        """Declare the parameters ``open_loop`` and ``position_feedback``."""
        self.auto_declare("open_loop", False)
        self.auto_declare("position_feedback", True)

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the velocity subscription and the odometry publishers."""
        try:
            self.read_parameters()
            for name in self.covariance_parameters:
                self._check_diagonal(name)
        except InvalidBaseError as error:
            self.logger.error(str(error))
            return CallbackReturn.ERROR
        self._open_loop = self.auto_declare("open_loop", False)
        self._odometry = Odometry(
            self.auto_declare("velocity_rolling_window_size", self.default_window)
        )
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
            self.covariance_parameters,
        )
        return None

    def _check_diagonal(self, parameter: str) -> None:
        length = len(self.auto_declare(parameter, [0.0] * _TWIST))
        if length != _TWIST:
            raise InvalidBaseError(
                f"Length of parameter '{parameter}' is {length} but must be equal to {_TWIST}"
            )

    def on_cleanup(self) -> None:
        """Destroy the velocity subscription and the odometry publishers."""
        self._input.close()
        self._publisher.close()

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return the command interfaces of the wheels."""
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self.command_names())

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the state interfaces of the wheels for odometry; none in open loop."""
        if self._open_loop:
            return InterfaceConfiguration(InterfaceConfigurationType.NONE)
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, self.feedback_names())

    @property
    def feedback_type(self) -> str:
        """State interface of driven wheels, ``position`` or ``velocity``, from the parameters."""
        return POSITION if self.auto_declare("position_feedback", True) else VELOCITY

    def on_activate(self) -> None:
        """Discard earlier velocity commands, and accept new ones."""
        self._input.clear()
        self._publisher.restart()
        self._last: list[float] | None = None
        self._input.active = True

    # Any, here and below: attributes of any type.
    def export_state(self) -> dict[str, Any]:
        """Return the odometry, the last velocity, and the states of limiters and steering."""
        return {
            "odometry": self._odometry.export_state(),
            "velocity": self._input.latest,
            "last": self._last,
            "limiters": [limiter.export_state() for limiter in self._rate_limiters()],
            "steering": {name: vars(self)[name] for name in _STEERING if name in vars(self)},
        }

    def import_state(self, state: dict[str, Any]) -> None:
        """Continue with the odometry and the velocity of the replaced instance."""
        self._odometry.import_state(state["odometry"])
        self._input.latest, self._last = state["velocity"], state["last"]
        for limiter, of_limiter in zip(self._rate_limiters(), state["limiters"], strict=True):
            limiter.import_state(of_limiter)
        vars(self).update(state["steering"])

    def _rate_limiters(self) -> list[RateLimiter]:
        """Return the rate limiters among the attributes, by the attributes' names."""
        found: list[RateLimiter] = []
        for _, value in sorted(vars(self).items()):
            several = value if isinstance(value, list) else [value]
            found += [one for one in several if isinstance(one, RateLimiter)]
        return found

    def on_restart(self) -> None:
        """Discard velocity commands and reset the odometry, after a simulation reset."""
        self._odometry.reset()
        self.on_activate()

    def on_stop(self) -> None:
        """Discard the received velocity; velocities are refused while the robot is stopped."""
        self._input.clear()

    def on_release(self) -> None:
        """Do nothing: the base is at rest until the next velocity command."""

    def on_deactivate(self) -> None:
        """Refuse further velocity commands, and command the wheels to stop."""
        self._input.active = False
        for interface, value in zip(
            self.command_interfaces, self.wheel_commands(BaseVelocity()), strict=True
        ):
            interface.value = value

    def update(self, time_ns: int, period: float) -> ReturnType | None:
        """Command the wheels by the limited velocity; update and queue the odometry."""
        velocity = self.limit(self.requested_velocity(time_ns), period)
        if self._open_loop:
            self._odometry.advance(
                velocity.x * period, velocity.angular * period, period, velocity.y * period
            )
        elif not self._measure(period):
            if self._last is None:
                return None  # a paused simulation has not published wheel states yet
            self.logger.error(
                f"A wheel's {self.feedback_type} is not a number", throttle_duration_sec=1.0
            )
            return ReturnType.ERROR
        self._publisher.try_publish(time_ns, self._odometry)
        for interface, value in zip(
            self.command_interfaces, self.wheel_commands(velocity), strict=True
        ):
            interface.value = value
        self.on_commanded(time_ns, velocity)
        return None

    def _measure(self, period: float) -> bool:
        """Update the odometry from the wheels; return False if a value is not finite."""
        values = [state.value for state in self.state_interfaces]
        if not all(map(math.isfinite, values)):
            return False
        if self._last is not None:
            way = self.displacement(values, self._last, period)
            self._odometry.advance(way.x, way.angular, period, way.y)
        self._last = values
        return True


class ChainableBase(MobileBaseController, ChainableControllerInterface):
    """Base class of mobile base controllers whose velocity other controllers can command.

    In chained mode the references are the velocity at each update, however old they are; while a
    reference is NaN the base is at rest.
    """

    references: ClassVar[Sequence[str]] = ("linear", "angular")

    def on_export_reference_interfaces_list(self) -> list[CommandInterface]:
        """Return a new reference interface for each component of the base velocity."""
        return [CommandInterface(f"{self.name}/{part}", VELOCITY) for part in self.references]

    def requested_velocity(self, time_ns: int) -> BaseVelocity:
        """Return the velocity from the references in chained mode, else the received one."""
        if not self.in_chained_mode:
            return super().requested_velocity(time_ns)
        values = [reference.value for reference in self.reference_interfaces]
        if not all(map(math.isfinite, values)):
            return BaseVelocity()
        x, *sideways, angular = values
        return BaseVelocity(x, sideways[0] if sideways else 0.0, angular)
