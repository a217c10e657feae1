"""Nodes, endpoints and action servers in memory, for tests of controllers without a ROS graph."""

from __future__ import annotations

import copy
import inspect
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

from teleopctl.interfaces import (
    ActionType,
    AllowableParameterValue,
    Message,
    deserialize,
    get_message,
)
from teleopctl.node import CancelResponse, GoalResponse, Parameter, ServerGoalHandle


class RecordedLog:
    """Logger for tests that stores lines in memory.

    Attributes:
        lines: Severity (``debug`` to ``fatal``) and text of each log line.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.lines: list[tuple[str, str]] = []

    def texts(self, severity: str | None = None) -> list[str]:
        """Return the stored log texts of a severity, or all of them."""
        return [text for kind, text in self.lines if severity in (None, kind)]

    def get_child(self, name: str) -> RecordedLog:
        """Return this logger itself, so that lines of child loggers are stored here too."""
        del name
        return self

    # Options such as once=True are accepted but ignored: every line is stored.
    def debug(self, message: str, **_: object) -> None:
        """Append a line of severity ``debug`` to `lines`, in memory only."""
        self.lines.append(("debug", message))

    def info(self, message: str, **_: object) -> None:
        """Append a line of severity ``info`` to `lines`, in memory only."""
        self.lines.append(("info", message))

    def warning(self, message: str, **_: object) -> None:
        """Append a line of severity ``warning`` to `lines`, in memory only."""
        self.lines.append(("warning", message))

    warn = warning

    def error(self, message: str, **_: object) -> None:
        """Append a line of severity ``error`` to `lines`, in memory only."""
        self.lines.append(("error", message))

    def fatal(self, message: str, **_: object) -> None:
        """Append a line of severity ``fatal`` to `lines`, in memory only."""
        self.lines.append(("fatal", message))


def _takes_info(callback: Callable[..., object]) -> bool:
    """Return whether a subscription's callback needs the message's metadata."""
    try:
        inspect.signature(callback).bind(object())
    except TypeError:
        return True
    return False


# Any: callbacks and messages of any type.
class RecordedEndpoint:
    """Publisher, subscription or service in memory for tests, which stores published messages.

    Args:
        name: Name as passed by the controller.
        callback: Callback of a subscription or service; None for a publisher.
        last_only: Whether only the last message is stored, without a copy.
        msg_type: Message type of a publisher, for messages that are published serialized.

    Attributes:
        name: Name as passed by the controller, for example ``~/commands``.
        callback: Callback of a subscription or service; None for a publisher.
        messages: Published messages.
        has_subscribers: True, so that publishers that skip messages without subscribers publish.
    """

    has_subscribers = True

    def __init__(
        self,
        name: str,
        callback: Callable[..., Any] | None = None,
        *,
        last_only: bool = False,
        msg_type: type[Message] | None = None,
    ) -> None:
        self.name = name
        self.callback = callback
        self.messages: list[Any] = []
        self._last_only = last_only
        self._msg_type = msg_type

    def publish(self, msg: object) -> None:
        """Store a copy of a message in `messages`; with ``last_only``, the message itself alone."""
        if isinstance(msg, bytearray) and self._msg_type is not None:
            msg = deserialize(msg, self._msg_type)
        if self._last_only:
            self.messages = [msg]
        else:
            self.messages.append(copy.deepcopy(msg))

    def get_subscription_count(self) -> int:
        """Return 1, so that publishers that skip messages without subscribers publish."""
        return 1


class RecordedNode:
    """Node in memory, for tests of controllers and hardware without a ROS graph.

    Args:
        name: Name of the node.
        parameters: Parameters as from a parameter file, by dotted name.
        last_only: Whether only the last published message of each topic is stored.

    Attributes:
        log: Logger of the node.
        endpoints: Publishers, subscriptions and services by name as passed at creation.
    """

    def __init__(
        self,
        name: str,
        parameters: Mapping[str, AllowableParameterValue] | None = None,
        *,
        last_only: bool = False,
    ) -> None:
        self._name = name
        self._last_only = last_only
        self._parameters = dict(parameters or {})
        self._given = dict(self._parameters)
        self._post_set: list[Callable[[list[Parameter]], None]] = []
        self.log = RecordedLog(name)
        self.endpoints: dict[str, RecordedEndpoint] = {}

    # -- called by tests ---------------------------------------------------------------------------

    def receive(self, topic: str, message: object, sender: bytes = b"") -> None:
        """Call the callback of a subscription to a topic with a message.

        Args:
            topic: Topic as passed by the controller.
            message: The message.
            sender: GID of the publisher, for callbacks that take a message's metadata.
        """
        callback = self.endpoints[topic].callback
        if callback is None:
            raise AssertionError(f"{topic} is published, not subscribed to")
        if _takes_info(callback):
            callback(message, {"publisher_gid": sender})
        else:
            callback(message)

    # Any: the response has the type of the service.
    def call(self, service: str, request: object, response: object) -> Any:
        """Call a service's callback with request and response; return the callback's result."""
        callback = self.endpoints[service].callback
        if callback is None:
            raise AssertionError(f"{service} is no service")
        return callback(request, response)

    # Any: messages of any type.
    def published(self, topic: str) -> list[Any]:
        """Return the messages that the node has published on a topic."""
        return self.endpoints[topic].messages

    # -- methods of `Node` -------------------------------------------------------------------------

    def get_name(self) -> str:
        """Return the node's name."""
        return self._name

    def get_namespace(self) -> str:  # noqa: D102
        return "/"

    def get_logger(self) -> RecordedLog:  # noqa: D102
        return self.log

    def has_parameter(self, name: str) -> bool:  # noqa: D102
        return name in self._parameters

    def declare_parameter(  # noqa: D102
        self, name: str, value: AllowableParameterValue = None, descriptor: object = None
    ) -> Parameter:
        del descriptor
        self._parameters[name] = value
        return self.get_parameter(name)

    def get_parameter(self, name: str) -> Parameter:  # noqa: D102
        return Parameter(name, value=self._parameters[name])

    def get_parameter_overrides(self) -> dict[str, Parameter]:
        """Return the parameter values given to the constructor."""
        return {name: Parameter(name, value=value) for name, value in self._given.items()}

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[Any]:
        """Set parameters, call the callbacks for changed ones, and return successful results."""
        self._parameters.update((parameter.name, parameter.value) for parameter in parameter_list)
        for callback in self._post_set:
            callback(list(parameter_list))
        result = get_message("rcl_interfaces/msg/SetParametersResult")
        return [result(successful=True) for _ in parameter_list]

    def add_post_set_parameters_callback(  # noqa: D102
        self, callback: Callable[[list[Parameter]], None]
    ) -> None:
        self._post_set.append(callback)

    def remove_post_set_parameters_callback(  # noqa: D102
        self, callback: Callable[[list[Parameter]], None]
    ) -> None:
        self._post_set.remove(callback)

    def undeclare_parameter(self, name: str) -> None:  # noqa: D102
        del self._parameters[name]

    def create_publisher(  # noqa: D102
        self, msg_type: type[object], topic: str, qos_profile: object
    ) -> RecordedEndpoint:
        del qos_profile
        return self._endpoint(topic, msg_type=cast("type[Message]", msg_type))

    def create_subscription(  # noqa: D102
        self,
        msg_type: type[object],
        topic: str,
        callback: Callable[..., object],
        qos_profile: object,
        *,
        immediate: bool = False,
    ) -> RecordedEndpoint:
        del msg_type, qos_profile, immediate
        return self._endpoint(topic, callback)

    def create_service(  # noqa: D102
        self, srv_type: type[object], srv_name: str, callback: Callable[..., object]
    ) -> RecordedEndpoint:
        del srv_type
        return self._endpoint(srv_name, callback)

    def destroy_publisher(self, publisher: RecordedEndpoint) -> bool:  # noqa: D102
        return self.endpoints.pop(publisher.name, None) is not None

    def destroy_subscription(self, subscription: RecordedEndpoint) -> bool:  # noqa: D102
        return self.endpoints.pop(subscription.name, None) is not None

    def destroy_service(self, service: RecordedEndpoint) -> bool:  # noqa: D102
        return self.endpoints.pop(service.name, None) is not None

    def _endpoint(
        self,
        name: str,
        callback: Callable[..., object] | None = None,
        *,
        msg_type: type[Message] | None = None,
    ) -> RecordedEndpoint:
        endpoint = RecordedEndpoint(name, callback, last_only=self._last_only, msg_type=msg_type)
        return self.endpoints.setdefault(name, endpoint)


# Any: goals, results and feedback of any action.
class RecordedActionServer:
    """Action server in memory, for tests of controllers without a ROS graph.

    Args:
        action_type: Action class.
        action_name: Name as passed by the controller, for example ``~/follow_joint_trajectory``.
        goal_callback: Function called with a goal; accepts or rejects it.
        handle_accepted_callback: Function called with the handle of an accepted goal.
        cancel_callback: Function called with a goal's handle; accepts or rejects to cancel it.
        now_ns: Function that returns the present time in nanoseconds.

    Attributes:
        name: Name as passed by the controller.
        action_type: Action class.
        feedback: Feedback messages of all goals.
    """

    def __init__(
        self,
        action_type: type[ActionType[Any, Any, Any]],
        action_name: str,
        *,
        goal_callback: Callable[[Any], object],
        handle_accepted_callback: Callable[[Any], object],
        cancel_callback: Callable[[Any], object],
        now_ns: Callable[[], int],
    ) -> None:
        self.name = action_name
        self.action_type: Any = action_type
        self.feedback: list[Any] = []
        self.lock = threading.RLock()
        self.now_ns = now_ns
        self.elapsed_ns = now_ns
        self._goal_callback = goal_callback
        self._accepted_callback = handle_accepted_callback
        self._cancel_callback = cancel_callback
        self._count = 0
        self._handles: list[ServerGoalHandle[Any, Any, Any]] = []

    # -- called by tests ---------------------------------------------------------------------------

    def send_goal(self, goal: object) -> ServerGoalHandle[Any, Any, Any] | None:
        """Send a goal to the server's callbacks; return its handle, or None if rejected."""
        if self._goal_callback(goal) is not GoalResponse.ACCEPT:
            return None
        self._count += 1
        info = get_message("action_msgs/msg/GoalInfo")()
        info.goal_id.uuid = [*self._count.to_bytes(16, "big")]
        handle: ServerGoalHandle[Any, Any, Any] = ServerGoalHandle(self, info, goal)
        self._handles.append(handle)
        self._accepted_callback(handle)
        return handle

    def cancel(self, handle: ServerGoalHandle[Any, Any, Any]) -> bool:
        """Request to cancel a goal; return False if rejected or the goal has ended."""
        return self._cancel_callback(handle) is CancelResponse.ACCEPT and handle.begin_cancel()

    def result(self, handle: ServerGoalHandle[Any, Any, Any]) -> Any:
        """Return the result of a goal; None if the goal has not ended."""
        responses: list[Any] = []
        handle.when_finished(responses.append)
        return responses[0].result if responses else None

    # -- called by the controller, its manager and goal handles ------------------------------------

    def register_goal_callback(self, callback: Callable[[Any], object]) -> None:  # noqa: D102
        self._goal_callback = callback

    def register_handle_accepted_callback(  # noqa: D102
        self, callback: Callable[[Any], object]
    ) -> None:
        self._accepted_callback = callback

    def register_cancel_callback(self, callback: Callable[[Any], object]) -> None:  # noqa: D102
        self._cancel_callback = callback

    def active_goals(self) -> list[ServerGoalHandle[Any, Any, Any]]:
        """Return the handles of the goals that have not ended, the oldest first."""
        return [handle for handle in self._handles if handle.is_active]

    def destroy(self) -> None:
        """Do nothing: the server holds no resources."""

    def publish_status(self) -> None:  # noqa: D102
        pass

    def publish_feedback(self, goal_id: object, feedback: object) -> None:  # noqa: D102
        del goal_id
        self.feedback.append(copy.deepcopy(feedback))

    def notify_execute(self, goal_handle: object, execute_callback: object) -> None:  # noqa: D102
        pass

    def notify_goal_done(self) -> None:  # noqa: D102
        pass
