"""A node without a graph: what controllers and hardware do with their node, remembered.

A test of the house compares its methods with those of the real `Node`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from teleopctl.node import AllowableParameterValue, Parameter


class RecordedLog:
    """Logger that stores its lines.

    Attributes:
        lines: Severity (``debug`` to ``fatal``) and text of each.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.lines: list[tuple[str, str]] = []

    def texts(self, severity: str | None = None) -> list[str]:
        """Return the logged texts of a severity, or all of them."""
        return [text for kind, text in self.lines if severity in (None, kind)]

    def get_child(self, name: str) -> RecordedLog:
        """Return a child logger, whose lines are stored here too."""
        del name
        return self

    # Options, such as once=True, are accepted: every line counts.
    def debug(self, message: str, **_: object) -> None:
        """Store a line of severity DEBUG."""
        self.lines.append(("debug", message))

    def info(self, message: str, **_: object) -> None:
        """Store a line of severity INFO."""
        self.lines.append(("info", message))

    def warning(self, message: str, **_: object) -> None:
        """Store a line of severity WARN."""
        self.lines.append(("warning", message))

    warn = warning

    def error(self, message: str, **_: object) -> None:
        """Store a line of severity ERROR."""
        self.lines.append(("error", message))

    def fatal(self, message: str, **_: object) -> None:
        """Store a line of severity FATAL."""
        self.lines.append(("fatal", message))


# Any: an endpoint takes the callback and the messages of any type.
class RecordedEndpoint:
    """Publisher, subscription or service that stores its messages.

    Args:
        name: As the controller gave it.
        callback: Of a subscription or service.
        last_only: Whether it remembers the last message alone, and that without a copy.

    Attributes:
        name: As the controller gave it, ``~/commands`` say.
        callback: Of a subscription or service.
        messages: What has been published.
    """

    def __init__(
        self, name: str, callback: Callable[..., Any] | None = None, *, last_only: bool = False
    ) -> None:
        self.name = name
        self.callback = callback
        self.messages: list[Any] = []
        self._last_only = last_only

    def publish(self, msg: object) -> None:
        """Keep a copy of a message."""
        if self._last_only:
            self.messages = [msg]
        else:
            self.messages.append(copy.deepcopy(msg))

    def get_subscription_count(self) -> int:
        """Return 1."""
        return 1


class RecordedNode:
    """Node without a network, for controllers and hardware under test.

    Args:
        name: The node's name.
        parameters: What a parameter file would set, by dotted name.
        last_only: Whether of what is published only the last message is remembered.

    Attributes:
        log: Its logger.
        endpoints: Publishers, subscriptions and services by the name they were made with.
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

    # -- what the other side does ------------------------------------------------------------------

    def receive(self, topic: str, message: object) -> None:
        """Pass a message to a subscription's callback."""
        callback = self.endpoints[topic].callback
        if callback is None:
            raise AssertionError(f"{topic} is published, not subscribed to")
        callback(message)

    # Any: what it answers has the type of the service.
    def call(self, service: str, request: object, response: object) -> Any:
        """Call a service's callback."""
        callback = self.endpoints[service].callback
        if callback is None:
            raise AssertionError(f"{service} is no service")
        return callback(request, response)

    # Any: each topic has a type of its own.
    def published(self, topic: str) -> list[Any]:
        """Return the messages that were published on a topic."""
        return self.endpoints[topic].messages

    # -- what the node's owner uses ----------------------------------------------------------------

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
        """Return the given parameter values, as those of a parameter file."""
        return {name: Parameter(name, value=value) for name, value in self._given.items()}

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> None:
        """Set parameters and call the post-set callbacks."""
        self._parameters.update((parameter.name, parameter.value) for parameter in parameter_list)
        for callback in self._post_set:
            callback(list(parameter_list))

    def add_post_set_parameters_callback(  # noqa: D102
        self, callback: Callable[[list[Parameter]], None]
    ) -> None:
        self._post_set.append(callback)

    def create_publisher(  # noqa: D102
        self, msg_type: type[object], topic: str, qos_profile: object
    ) -> RecordedEndpoint:
        del msg_type, qos_profile
        return self._endpoint(topic)

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
        self, name: str, callback: Callable[..., object] | None = None
    ) -> RecordedEndpoint:
        endpoint = RecordedEndpoint(name, callback, last_only=self._last_only)
        return self.endpoints.setdefault(name, endpoint)
