"""Callbacks for parameter changes of any node, as ``rclpy.parameter_event_handler``."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Iterator

from teleopctl.base.typed import TYPE_CHECKING, Any
from teleopctl.interfaces import get_message
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.names import fully_qualified
from teleopctl.node.values.qos import QoSProfile, qos_profile_parameter_events

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterEvent

    from teleopctl.node.node_endpoints import NodeEndpoints


@dataclasses.dataclass(frozen=True, eq=False)
class ParameterCallbackHandle:
    """Handle of a callback for new and changed values of one parameter."""

    parameter_name: str
    node_name: str
    callback: Callable[[ParameterMessage], object]


@dataclasses.dataclass(frozen=True, eq=False)
class ParameterEventCallbackHandle:
    """Handle of a callback for all parameter events."""

    callback: Callable[[ParameterEvent], object]


class ParameterEventHandler:
    """Subscriber of parameter events that calls registered callbacks, the newest first.

    Args:
        node: Node of the subscription.
        qos_profile: QoS profile of the subscription.
        callback_group: Callback group of the callbacks; the node's default group if None.
        options: Further options of ``Node.create_subscription``.
    """

    def __init__(
        self,
        node: NodeEndpoints,
        qos_profile: QoSProfile | int = qos_profile_parameter_events,
        callback_group: CallbackGroup | None = None,
        **options: Any,  # Any: `create_subscription` checks them
    ) -> None:
        self.node = node
        self.qos_profile = qos_profile
        self._lock = threading.Lock()
        self._of_parameter: list[ParameterCallbackHandle] = []
        self._of_all: list[ParameterEventCallbackHandle] = []
        self.parameter_event_subscription = node.create_subscription(
            get_message("rcl_interfaces/msg/ParameterEvent"),
            "/parameter_events",
            self._handle,
            qos_profile,
            callback_group=callback_group,
            **options,
        )

    def destroy(self) -> None:
        """Destroy the subscription to parameter events."""
        self.node.destroy_subscription(self.parameter_event_subscription)

    def _handle(self, event: ParameterEvent) -> None:
        with self._lock:
            of_parameter, of_all = list(self._of_parameter), list(self._of_all)
        for wanted in of_parameter:
            parameter = self.get_parameter_from_event(
                event, wanted.parameter_name, wanted.node_name
            )
            if parameter is not None:
                wanted.callback(parameter)
        for handle in of_all:
            handle.callback(event)

    @staticmethod
    def get_parameter_from_event(
        event: ParameterEvent, parameter_name: str, node_name: str
    ) -> ParameterMessage | None:
        """Return a node's parameter that an event reports as new or changed; None without one."""
        if event.node != node_name:
            return None
        changed = ParameterEventHandler.get_parameters_from_event(event)
        return next((each for each in changed if each.name == parameter_name), None)

    @staticmethod
    def get_parameters_from_event(event: ParameterEvent) -> Iterator[ParameterMessage]:
        """Yield the new and the changed parameters of an event, as messages."""
        yield from event.new_parameters
        yield from event.changed_parameters

    def add_parameter_callback(
        self, parameter_name: str, node_name: str, callback: Callable[[ParameterMessage], object]
    ) -> ParameterCallbackHandle:
        """Register a callback for new and changed values of a node's parameter; return a handle.

        Args:
            parameter_name: Name of the parameter.
            node_name: Name of the node that has the parameter, absolute or relative to this node's
                namespace; empty for this node.
            callback: Called with the parameter's message after each change.

        Returns:
            Handle for `remove_parameter_callback`.
        """
        handle = ParameterCallbackHandle(parameter_name, self._full_name(node_name), callback)
        with self._lock:
            self._of_parameter.insert(0, handle)
        return handle

    def add_parameter_event_callback(
        self, callback: Callable[[ParameterEvent], object]
    ) -> ParameterEventCallbackHandle:
        """Register a callback for every parameter event; return its handle."""
        handle = ParameterEventCallbackHandle(callback)
        with self._lock:
            self._of_all.insert(0, handle)
        return handle

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Unregister a callback of one parameter; raise RuntimeError if it is unknown."""
        self._remove(self._of_parameter, handle)

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Unregister a callback of all events; raise RuntimeError if it is unknown."""
        self._remove(self._of_all, handle)

    def _remove(self, handles: list[Any], handle: Any) -> None:
        with self._lock:
            if handle not in handles:
                raise RuntimeError("Callback doesn't exist")
            handles.remove(handle)

    def _full_name(self, node_name: str) -> str:
        if not node_name:
            return self.node.get_fully_qualified_name()
        if node_name.startswith("/"):
            return node_name
        return fully_qualified(self.node.get_namespace(), node_name)
