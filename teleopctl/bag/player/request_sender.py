"""Services that are asked again what a bag has of their requests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.bag.player.options import RequestSource
from teleopctl.bag.player.selection import SERVICE_EVENT
from teleopctl.bag.records import BagMessage, BagTopic
from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import deserialize, get_message, get_service

if TYPE_CHECKING:
    from teleopctl.node import Node

_FIRST_LOOK_S = 1.0
# service_msgs/msg/ServiceEventInfo: where an event was noted.
_EVENTS = {"client_introspection": 0, "service_introspection": 1}


class RequestSender:
    """Sends the requests that recorded service events contain.

    Args:
        node: The node that asks.
        topic: The topic of the events.
        source: Which side's events count: each request is in the bag once for each.

    Raises:
        TeleopctlError: The type of the service is not known.
    """

    def __init__(self, node: Node, topic: BagTopic, source: RequestSource) -> None:
        self._node = node
        self._event_class = get_message(topic.type_name)
        self._event_type = _EVENTS[source]
        self._log = node.get_logger()
        self._told: set[str] = set()
        self._patience_s = _FIRST_LOOK_S
        # Any: of the service's own types.
        self._client: Any = node.create_client(
            get_service(topic.type_name.removesuffix("_Event")),
            topic.name.removesuffix(SERVICE_EVENT),
        )

    def send(self, message: BagMessage) -> bool:
        """Send the request of an event; return False if it has none or there is no server."""
        try:
            event = deserialize(message.data, self._event_class)
        except InvalidMessageError as error:
            self._log.error(
                f"Failed to deserialize service event message for '{self._name}' service! "
                f"{error.message}"
            )
            return False
        if event.info.event_type != self._event_type:
            return False
        if not event.request:
            self._warn_once(
                f"Can't send service request. The configuration of introspection for "
                f"'{self._name}' was metadata only!"
            )
            return False
        if not self._is_served():
            self._log.error(
                f"Service request hasn't been sent. The '{self._name}' service isn't ready !"
            )
            return False
        self._client.call_async(event.request[0])
        return True

    def _is_served(self) -> bool:
        # A player that has just begun may not have heard yet of a service that is there.
        patience_s, self._patience_s = self._patience_s, 0.0
        ready: bool = self._client.service_is_ready() or (
            patience_s > 0 and self._client.wait_for_service(timeout_sec=patience_s)
        )
        return ready

    def close(self) -> None:
        """Destroy the client."""
        self._node.destroy_client(self._client)

    @property
    def _name(self) -> str:
        return str(self._client.srv_name)

    def _warn_once(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            self._log.warning(text)
