"""Time source, ``/rosout`` publisher, logger services and type descriptions of a node."""

from __future__ import annotations

import contextlib
import struct

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.errors import InvalidMessageError, InvalidTypeNameError, TeleopctlError
from teleopctl.interfaces import (
    NANOSECONDS_PER_SECOND,
    definition_text,
    get_message,
    get_service,
    split,
    type_description,
    type_hash,
)
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.parameters.store import result
from teleopctl.node.values import logging
from teleopctl.node.values.exceptions import InvalidHandle, RCLError
from teleopctl.node.values.parameter import Parameter, ParameterType
from teleopctl.node.values.qos import QoSProfile, qos_profile_clock, qos_profile_services_default

if TYPE_CHECKING:
    from rcl_interfaces.msg import SetParametersResult
    from rosgraph_msgs.msg import Clock

    from teleopctl.node.endpoints.service import Service
    from teleopctl.node.endpoints.subscription import Subscription
    from teleopctl.node.node_endpoints import NodeEndpoints
    from teleopctl.node.node_parameters import NodeParameters


USE_SIM_TIME = "use_sim_time"

# rosgraph_msgs/msg/Clock as CDR, after the encapsulation: int32 sec, uint32 nanosec. Every node of
# a process reads each of these messages, so they are decoded without creating message objects.
_CLOCK_BY_ORDER = {
    b"\x00\x01": struct.Struct("<iI").unpack_from,
    b"\x00\x00": struct.Struct(">iI").unpack_from,
}
_ENCAPSULATION_SIZE = 4


class TimeSource:
    """Time source of a node: simulated time from ``/clock`` while ``use_sim_time`` is true."""

    def __init__(self, node: NodeParameters) -> None:
        self._node = node
        self._subscription: Subscription[Clock] | None = None
        self._is_resting = self._reads_on_demand = False
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._follow)
        parameter = node.declare_parameter(USE_SIM_TIME, False)
        self._follow([parameter])

    @staticmethod
    def _check(parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name == USE_SIM_TIME and parameter.type_ != ParameterType.BOOL:
                return result(False, f"{USE_SIM_TIME} parameter set to something besides a bool")
        return result(True)

    def _follow(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == USE_SIM_TIME:
                self._set_active(bool(parameter.value))

    def rest(self, *, is_resting: bool) -> None:
        """Stop listening to ``/clock``, or listen again; meanwhile a simulated time stands still.

        For a node that has nothing to do for long: each message of ``/clock`` costs processor time.

        Args:
            is_resting: Whether to stop listening.
        """
        self._is_resting = is_resting
        self._listen(self._node.get_parameter(USE_SIM_TIME).value is True)

    def read_on_demand(self) -> None:
        """Read ``/clock`` when the time is asked for, instead of with each of its messages.

        For a node without timers, sleeps and jump callbacks in simulated time: Zenoh keeps the
        newest message, and no Python code runs for the others.
        """
        self.rest(is_resting=True)
        self._reads_on_demand = True
        self.rest(is_resting=False)

    def _set_active(self, active: bool) -> None:
        self._node.get_clock().set_simulated(active)
        self._listen(active)

    def _listen(self, is_simulated: bool) -> None:
        active = is_simulated and not self._is_resting
        if active and self._subscription is None and self._reads_on_demand:
            self._subscription = self._keep_newest()
        elif active and self._subscription is None:
            # On Zenoh's thread: the clock must be set while a callback waits for a time.
            self._subscription = self._node.create_subscription(
                get_message("rosgraph_msgs/msg/Clock"),
                "/clock",
                self._move,
                qos_profile_clock,
                raw=True,
                immediate=True,
            )
        elif not active and self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _keep_newest(self) -> Subscription[Clock]:
        """Return a subscription that is read whenever the clock is."""
        from teleopctl.node.newest_message import NewestMessage

        newest: NewestMessage[Clock] = NewestMessage(
            self._node, get_message("rosgraph_msgs/msg/Clock"), "/clock"
        )

        def read() -> None:
            if (data := newest.read_raw()) is not None:
                try:
                    self._move(data)
                except InvalidMessageError as error:
                    newest.refusals.refuse(error.message)

        self._node.get_clock().before_reading = read
        return newest

    def _move(self, data: bytes) -> None:
        try:
            sec, nanosec = _CLOCK_BY_ORDER[data[:2]](data, _ENCAPSULATION_SIZE)
        except (KeyError, struct.error):
            raise InvalidMessageError(
                f"{len(data)} bytes are not a rosgraph_msgs/msg/Clock"
            ) from None
        self._set(sec, nanosec)

    def _set(self, sec: int, nanosec: int) -> None:
        if sec < 0 or nanosec >= NANOSECONDS_PER_SECOND:
            raise InvalidMessageError(f"{sec} s and {nanosec} ns are not a valid time")
        self._node.get_clock().set_simulated_time(sec * NANOSECONDS_PER_SECOND + nanosec)


class RosoutPublisher:
    """Publisher of a node's log messages on ``/rosout``."""

    def __init__(self, node: NodeEndpoints, qos: QoSProfile) -> None:
        self._log = get_message("rcl_interfaces/msg/Log")
        self._time = get_message("builtin_interfaces/msg/Time")
        self._logger_name = node.get_logger().name
        # Not among the node's publishers, as in rclpy.
        self._publisher = Publisher(node, self._log, node.resolve_topic_name("/rosout"), qos)
        self._publisher.sends_while_ending = True
        logging.add_sink(self._logger_name, self._publish)

    def _publish(
        self,
        severity: logging.LoggingSeverity,
        name: str,
        message: str,
        caller: logging.Caller,
        time_ns: int,
    ) -> None:
        sec, nanosec = split(time_ns)
        # The console has the message already. Text that does not fit a CDR string, and messages
        # logged after shutdown, are not published.
        with contextlib.suppress(TeleopctlError, InvalidHandle, RCLError):
            self._publisher.publish(
                self._log(
                    stamp=self._time(sec=sec, nanosec=nanosec),
                    level=int(severity),
                    name=name,
                    msg=message,
                    file=caller.file,
                    function=caller.function,
                    line=caller.line,
                )
            )

    def destroy(self) -> None:
        """Unregister from the node's logger, and destroy the publisher."""
        logging.remove_sink(self._logger_name)
        self._publisher.destroy()


class LoggerService:
    """Services ``~/get_logger_levels`` and ``~/set_logger_levels`` of a node."""

    def __init__(self, node: NodeEndpoints) -> None:
        node.create_service(
            get_service("rcl_interfaces/srv/GetLoggerLevels"), "~/get_logger_levels", self._get
        )
        node.create_service(
            get_service("rcl_interfaces/srv/SetLoggerLevels"), "~/set_logger_levels", self._set
        )

    @staticmethod
    def _get(request: Any, response: Any) -> Any:
        level = get_message("rcl_interfaces/msg/LoggerLevel")
        response.levels = [
            level(name=name, level=int(logging.get_logger_level(name))) for name in request.names
        ]
        return response

    @staticmethod
    def _set(request: Any, response: Any) -> Any:
        outcome = get_message("rcl_interfaces/msg/SetLoggerLevelsResult")
        results = []
        for wanted in request.levels:
            try:
                logging.set_logger_level(wanted.name, wanted.level)
            except ValueError:
                results.append(
                    outcome(successful=False, reason="Failed reason: Invalid logger level.")
                )
            else:
                results.append(outcome(successful=True))
        response.results = results
        return response


_PARAMETER = "start_type_description_service"


# Any: the types of the service are made at run time.
def start_type_description_service(node: NodeParameters) -> Service[Any, Any] | None:
    """Start and return a node's ``~/get_type_description``; None if its parameter disables it."""
    descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")(
        description="Start the ~/get_type_description service for this node.", read_only=True
    )
    if not node.declare_parameter(_PARAMETER, True, descriptor).value:
        return None
    return node.create_service(
        get_service("type_description_interfaces/srv/GetTypeDescription"),
        "~/get_type_description",
        _answer,
        qos_profile=qos_profile_services_default,
    )


def _answer(request: Any, response: Any) -> Any:
    try:
        actual = type_hash(request.type_name)
        if request.type_hash not in ("", actual):
            raise InvalidTypeNameError(
                f"type '{request.type_name}' has the hash {actual} here, not {request.type_hash}"
            )
        response.type_description = _to_message(type_description(request.type_name))
        if request.include_type_sources:
            source = get_message("type_description_interfaces/msg/TypeSource")
            response.type_sources = [
                source(
                    type_name=request.type_name,
                    encoding=request.type_name.split("/")[1],
                    raw_file_contents=definition_text(request.type_name),
                )
            ]
        response.successful = True
    except TeleopctlError as error:
        response.successful = False
        response.failure_reason = error.message
    return response


def _to_message(description: dict[str, Any]) -> Any:
    """Return the message form of the JSON structure from which a type hash is computed."""
    return get_message("type_description_interfaces/msg/TypeDescription")(
        type_description=_individual_type_description(description["type_description"]),
        referenced_type_descriptions=[
            _individual_type_description(entry)
            for entry in description["referenced_type_descriptions"]
        ],
    )


def _individual_type_description(entry: dict[str, Any]) -> Any:
    package = "type_description_interfaces/msg"
    field_type = get_message(f"{package}/FieldType")
    field = get_message(f"{package}/Field")
    return get_message(f"{package}/IndividualTypeDescription")(
        type_name=entry["type_name"],
        fields=[
            field(name=item["name"], type=field_type(**item["type"])) for item in entry["fields"]
        ],
    )
