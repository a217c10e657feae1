"""The parameter ``use_sim_time``: whether ``/clock`` drives a node's clock."""

from __future__ import annotations

import struct

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, get_message
from teleopctl.node.parameters.parameter_store import result
from teleopctl.node.values.parameter import Parameter, ParameterType
from teleopctl.node.values.qos import qos_profile_clock

if TYPE_CHECKING:
    from rcl_interfaces.msg import SetParametersResult
    from rosgraph_msgs.msg import Clock

    from teleopctl.node.endpoints.subscription import Subscription
    from teleopctl.node.node_parameters import NodeParameters

USE_SIM_TIME = "use_sim_time"

# rosgraph_msgs/msg/Clock as CDR, after the encapsulation: int32 sec, uint32 nanosec. Every node of
# a process reads each of these messages, so it is done without making a message of them.
_CLOCK_BY_ORDER = {
    b"\x00\x01": struct.Struct("<iI").unpack_from,
    b"\x00\x00": struct.Struct(">iI").unpack_from,
}
_ENCAPSULATION_SIZE = 4


class TimeSource:
    """Declares ``use_sim_time`` on a node and subscribes ``/clock`` while it is true."""

    def __init__(self, node: NodeParameters) -> None:
        self._node = node
        self._subscription: Subscription[Clock] | None = None
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

    def _set_active(self, active: bool) -> None:
        clock = self._node.get_clock()
        clock.set_simulated(active)
        if active and self._subscription is None:
            # On the transport's thread: time must move while a callback waits for it.
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

    def _move(self, data: bytes) -> None:
        try:
            sec, nanosec = _CLOCK_BY_ORDER[data[:2]](data, _ENCAPSULATION_SIZE)
        except (KeyError, struct.error):
            raise InvalidMessageError(f"{len(data)} bytes are no rosgraph_msgs/msg/Clock") from None
        if sec < 0 or nanosec >= NANOSECONDS_PER_SECOND:
            raise InvalidMessageError(f"{sec} s and {nanosec} ns are no time")
        self._node.get_clock().set_simulated_time(sec * NANOSECONDS_PER_SECOND + nanosec)
