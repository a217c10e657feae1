"""A node's log messages on ``/rosout``."""

from __future__ import annotations

import contextlib

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_message, split
from teleopctl.node.endpoints.publisher import Publisher
from teleopctl.node.values import logging
from teleopctl.node.values.exceptions import InvalidHandle, RCLError
from teleopctl.node.values.qos import QoSProfile

if TYPE_CHECKING:
    from teleopctl.node.node_endpoints import NodeEndpoints


class RosoutPublisher:
    """Publishes the log messages of a node on /rosout."""

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
        # The console has the message already: text that no CDR string holds, and what is logged
        # after shutdown, ends there.
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
        """Destroy the publisher."""
        logging.remove_sink(self._logger_name)
        self._publisher.destroy()
