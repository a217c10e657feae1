"""PID controller of several degrees of freedom, chainable."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import fields
from typing import Any, NamedTuple

from teleopctl.control.controllers.base import InterfaceConfiguration, InterfaceConfigurationType
from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.control.controllers.pid import STRATEGIES, Pid, PidGains
from teleopctl.control.controllers.pid_state import PidStatePublisher, PidStep
from teleopctl.control.handles import (
    POSITION,
    CommandInterface,
    MeasuredValues,
    StateInterface,
)
from teleopctl.control.lifecycle import CallbackReturn, ReturnType
from teleopctl.control.realtime_publisher import realtime_log
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, get_service

# Any: message classes are generated at run time from definitions.

# Gains that only the PIDs of the joint trajectory controller have.
_NOT_HERE = ("ff_velocity_scale",)


class _InvalidPidError(Exception):
    """Raised when the controller's parameters are invalid; the message says why."""


class _Options(NamedTuple):
    """Options of a degree of freedom that are not gains of the PID."""

    feedforward_gain: float
    angle_wraparound: bool
    save_i_term: bool


class PidController(ChainableControllerInterface):
    """Chainable controller that commands each degree of freedom by a PID.

    Plug-in type ``pid_controller/PidController``.

    For each degree of freedom the controller measures one quantity and optionally its derivative,
    and commands ``PID(reference - measured)``. Feed-forward adds ``feedforward_gain`` times the
    reference, or times the reference of the derivative if it is used. While a reference or
    measurement is NaN, no command is written.

    The references are exported for other controllers; outside chained mode they are received on
    ``~/reference``. The measured values are exported as states.
    """

    def on_init(self) -> None:
        """Register for parameter changes; parameters are declared in ``on_configure``."""
        self._pids: list[Pid] = []
        self._feedforward = False
        self.get_node().add_post_set_parameters_callback(self._parameters_changed)

    # -- life cycle --------------------------------------------------------------------------------

    def on_configure(self) -> CallbackReturn | None:
        """Read the parameters; create the topics and ``~/set_feedforward_control``."""
        try:
            self._read_parameters()
            gains = self._read_gains()
        except _InvalidPidError as error:
            self.logger.error(str(error))
            return CallbackReturn.FAILURE
        self._pids = [Pid(one) for one, _ in gains]
        self._options = [options for _, options in gains]
        self._feedforward = self.auto_declare("enable_feedforward", False)
        self._open()
        self.logger.info("configure successful")
        return None

    def _read_parameters(self) -> None:
        read = self.auto_declare
        none: list[str] = []
        self._dofs: list[str] = read("dof_names", none)
        names: list[str] = read("reference_and_state_dof_names", none)
        self._command: str = read("command_interface", "")
        self._interfaces: list[str] = read("reference_and_state_interfaces", none)
        self._external = read("use_external_measured_states", False)
        self._first_setpoint = read("set_current_state_as_first_setpoint", True)
        for name, value in (
            ("dof_names", self._dofs),
            ("command_interface", self._command),
            ("reference_and_state_interfaces", self._interfaces),
        ):
            if not value:
                raise _InvalidPidError(f"Parameter '{name}' cannot be empty")
        if len(self._interfaces) > 2:
            raise _InvalidPidError(
                "Length of parameter 'reference_and_state_interfaces' is "
                f"{len(self._interfaces)} but must be less than 3"
            )
        for name, values in (("dof_names", self._dofs), ("reference_and_state_dof_names", names)):
            if len(set(values)) != len(values):
                raise _InvalidPidError(f"Value of parameter '{name}' must be unique")
        self._names = names or self._dofs
        if len(self._names) != len(self._dofs):
            raise _InvalidPidError(
                f"Size of 'dof_names' ({len(self._dofs)}) and 'reference_and_state_dof_names' "
                f"({len(self._names)}) parameters has to be the same!"
            )

    def _read_gains(self) -> list[tuple[PidGains, _Options]]:
        """Return the gains and options of each degree of freedom from the parameters."""
        read, found = self.auto_declare, []
        defaults = PidGains()
        for dof in self._dofs:
            values = {
                field.name: read(f"gains.{dof}.{field.name}", getattr(defaults, field.name))
                for field in fields(PidGains)
                if field.name not in _NOT_HERE
            }
            gains = PidGains(**values)
            strategy = gains.antiwindup_strategy
            if strategy not in STRATEGIES:
                raise _InvalidPidError(
                    f"Parameter 'gains.{dof}.antiwindup_strategy' with the value '{strategy}' is "
                    f"not in the set {{{', '.join(map(repr, STRATEGIES))}}}"
                )
            if problem := gains.problem():
                raise _InvalidPidError(f"Gains of '{dof}': {problem}")
            # Deprecated: clamping the integral or its part of the output, which is the same here.
            read(f"gains.{dof}.antiwindup", False)
            options = _Options(
                read(f"gains.{dof}.feedforward_gain", 0.0),
                read(f"gains.{dof}.angle_wraparound", False),
                read(f"gains.{dof}.save_i_term", True),
            )
            found.append((gains, options))
        return found

    def _parameters_changed(self, parameters: Sequence[Any]) -> None:
        """Set new gains, outside the control cycle; log an error and skip invalid gains."""
        if not self._pids:
            return
        try:
            gains = self._read_gains()
            if any(parameter.name == "enable_feedforward" for parameter in parameters):
                self._feedforward = self.auto_declare("enable_feedforward", False)
        except (_InvalidPidError, TeleopctlError) as error:
            self.logger.error(f"Received invalid gains: {error}. Skipping new gains.")
            return
        self._options = [options for _, options in gains]
        for pid, (one, _) in zip(self._pids, gains, strict=True):
            pid.gains = one

    def _open(self) -> None:
        from teleopctl.node import QoSProfile, ReliabilityPolicy

        node = self.get_node()
        latest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        kind = get_message("control_msgs/msg/MultiDOFCommand")
        self._incoming: deque[tuple[Sequence[float], Sequence[float]]] = deque(maxlen=1)
        self._measured: Sequence[float] = ()
        self._subscriptions = [
            node.create_subscription(kind, "~/reference", self._reference_received, latest)
        ]
        if self._external:
            self._subscriptions.append(
                node.create_subscription(kind, "~/measured_state", self._state_received, latest)
            )
        self._service = node.create_service(
            get_service("std_srvs/srv/SetBool"), "~/set_feedforward_control", self._set_feedforward
        )
        own = [
            self.auto_declare(f"gains.{dof}.activate_state_publisher", False) for dof in self._dofs
        ]
        self._state = PidStatePublisher(
            node,
            self.params.publish_queue,
            self._names,
            [dof for dof, wanted in zip(self._dofs, own, strict=True) if wanted],
            self._dofs,
        )

    def on_cleanup(self) -> None:
        """Destroy subscriptions, publishers and the feed-forward service."""
        node = self.get_node()
        for subscription in self._subscriptions:
            node.destroy_subscription(subscription)
        node.destroy_service(self._service)
        self._state.close()
        self._pids = []

    def command_interface_configuration(self) -> InterfaceConfiguration:
        """Return one command interface for each degree of freedom."""
        names = [f"{dof}/{self._command}" for dof in self._dofs]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def state_interface_configuration(self) -> InterfaceConfiguration:
        """Return the measured state interfaces, derivatives last; none if a topic gives states."""
        if self._external:
            return InterfaceConfiguration(InterfaceConfigurationType.NONE)
        names = [f"{name}/{interface}" for interface in self._interfaces for name in self._names]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    def on_export_reference_interfaces_list(self) -> list[CommandInterface]:
        """Return a new reference interface for each measured quantity."""
        return [
            CommandInterface(f"{self.name}/{name}", interface)
            for interface in self._interfaces
            for name in self._names
        ]

    def on_export_state_interfaces_list(self) -> list[StateInterface]:
        """Return a new exported state interface for each measured quantity."""
        return [
            StateInterface(f"{self.name}/{name}", interface)
            for interface in self._interfaces
            for name in self._names
        ]

    def on_activate(self) -> None:
        """Set references to measured values or NaN; reset the PIDs, by default not integrals."""
        self._watched = MeasuredValues(self.state_interfaces[: len(self._pids)])
        self._begin()
        for pid, options in zip(self._pids, self._options, strict=True):
            pid.reset(keep_integral=options.save_i_term)

    def export_state(self) -> dict[str, Any]:
        """Return the state of the PIDs, and what was received; references are kept anyway."""
        return {
            "pids": [pid.export_state() for pid in self._pids],
            "feedforward": self._feedforward,
            "measured": self._measured,
            "incoming": list(self._incoming),
        }

    def import_state(self, state: dict[str, Any]) -> None:
        """Continue with the integrals of the replaced instance."""
        for pid, of_pid in zip(self._pids, state["pids"], strict=True):
            pid.import_state(of_pid)
        self._feedforward = state["feedforward"]
        self._measured = state["measured"]
        self._incoming.extend(state["incoming"])

    def on_restart(self) -> None:
        """Set the references to measured values or NaN, and reset the PIDs with integrals."""
        self._begin()
        for pid in self._pids:
            pid.reset()

    def _begin(self) -> None:
        self._incoming.clear()
        unknown = [math.nan] * len(self.reference_interfaces)
        self._measured = unknown
        values = unknown
        if self._first_setpoint and not self._external:
            values = [state.value for state in self.state_interfaces]
        for reference, value in zip(self.reference_interfaces, values, strict=True):
            reference.value = value

    def on_stop(self) -> None:
        """Discard the received reference; references are refused while the robot is stopped."""
        self._incoming.clear()

    def on_release(self) -> None:
        """Do nothing: the references keep their values until the next one is received."""

    def interfaces_to_decelerate(self) -> Sequence[CommandInterface]:
        """Return the references; none in chained mode, where another controller decelerates."""
        return () if self.in_chained_mode else self.reference_interfaces

    def on_deactivate(self) -> None:
        """Command zero, unless positions are commanded."""
        if self._command != POSITION:
            for command in self.command_interfaces:
                command.value = 0.0

    # -- callbacks ---------------------------------------------------------------------------------

    def _set_feedforward(self, request: Any, response: Any) -> Any:
        self._feedforward = bool(request.data)
        self.logger.warning(
            "This service will be deprecated in favour of setting the ``feedforward_gain`` "
            "parameter to a non-zero value."
        )
        response.success = True
        return response

    def _reference_received(self, message: Any) -> None:
        if self.is_refused("The reference on ~/reference"):
            return
        names, values = list(message.dof_names), list(message.values)
        count = len(self._names)
        if not names and len(values) == count:
            self.logger.warning(
                "Reference massage does not have DoF names defined. Assuming that value have order "
                "as defined state DoFs"
            )
            names = self._names
        if len(names) != count or len(values) != count:
            self.logger.error(
                f"Size of input data names ({len(names)}) and/or values ({len(values)}) is not "
                f"matching the expected size ({count})."
            )
            return
        if (unknown := next((name for name in names if name not in self._names), None)) is not None:
            self.logger.warning(
                f"DoF name '{unknown}' not found in the defined list of state DoFs."
            )
            return
        rates = [*message.values_dot, *[math.nan] * count][:count]
        places = [names.index(name) for name in self._names if name in names]
        if len(places) != count:
            self.logger.error(f"A DoF name is given twice: {', '.join(names)}")
            return
        self._incoming.append(([values[place] for place in places], [rates[p] for p in places]))

    def _state_received(self, message: Any) -> None:
        count = len(self._names)
        rates = list(message.values_dot)
        for what, got in (("names", message.dof_names), ("values", message.values)):
            if len(got) != count:
                self.logger.error(
                    f"Size of input data {what} ({len(got)}) is not matching the expected size "
                    f"({count})."
                )
                return
        two = len(self._interfaces) > 1
        if rates and not two:
            self.logger.error(
                "The reference_and_state_interfaces parameter has to have two interfaces [the "
                "interface and the derivative of the interface], in order to use the values_dot "
                "field."
            )
            return
        if rates and len(rates) != count:
            self.logger.error(
                f"Size of input data values_dot ({len(rates)}) is not matching the expected size "
                f"({count})."
            )
            return
        self._measured = [*message.values, *(rates or ([math.nan] * count if two else []))]

    # -- control cycle -----------------------------------------------------------------------------

    def update_reference_from_subscribers(self, time_ns: int, period: float) -> ReturnType | None:
        """Set the references from the last ``~/reference`` message; NaN changes nothing."""
        del time_ns, period
        if not self._incoming:
            return None
        values, rates = self._incoming.popleft()
        references, count = self.reference_interfaces, len(self._names)
        for number, (value, rate) in enumerate(zip(values, rates, strict=True)):
            if math.isnan(value):
                continue
            references[number].value = value
            if len(references) > count and not math.isnan(rate):
                references[count + number].value = rate
        return None

    def update_and_write_commands(self, time_ns: int, period: float) -> ReturnType | None:
        """Write PID outputs unless an input is NaN; export measured states; queue the PID state.

        If a state is NaN for a tenth of a second, an output that is no position becomes 0.
        """
        if self._external:
            measured = self._measured
        else:
            measured = [state.value for state in self.state_interfaces]
            self._watch_states(period)
        for state, value in zip(self.exported_state_interfaces, measured, strict=True):
            state.value = value
        references = [reference.value for reference in self.reference_interfaces]
        count, steps = len(self._pids), []
        two = len(references) > count
        for number, pid in enumerate(self._pids):
            reference, value = references[number], measured[number]
            options = self._options[number]
            error, rate_error = reference - value, math.nan
            if options.angle_wraparound and math.isfinite(error):
                error = math.remainder(error, math.tau)
            if two:
                rate_error = references[count + number] - measured[count + number]
            if math.isfinite(error):
                output = (
                    pid.update(error, rate_error, period)
                    if math.isfinite(rate_error)
                    else pid.update_by_error(error, period)
                )
                if self._feedforward:
                    ahead = references[count + number] if two else reference
                    output += ahead * options.feedforward_gain if math.isfinite(ahead) else 0.0
                self.command_interfaces[number].value = output
            elif self._watched.lost and math.isnan(value):
                _write_zero(self.command_interfaces[number])
            steps.append(
                PidStep(
                    reference,
                    value,
                    measured[count + number] if two else math.nan,
                    error,
                    rate_error,
                    self.command_interfaces[number].value,
                    pid.integral,
                    pid.error_rate,
                    pid.gains,
                )
            )
        self._state.try_publish(time_ns, period, steps)
        return None

    def _watch_states(self, period: float) -> None:
        """Log once if a state is not measured any more."""
        values = self._watched.read()
        if not self._watched.watch(period) or not all(map(math.isfinite, values)):
            return
        if lost := self._watched.lost:
            log = realtime_log(self.params.publish_queue)
            sentence = f"{lost}: its command is 0, or stays if it is a position"
            log.try_publish((self.logger.error, sentence))


def _write_zero(command: CommandInterface) -> None:
    """Set a command to 0, unless it is a position or unknown."""
    if command.interface_name != POSITION and math.isfinite(command.value):
        command.value = 0.0
