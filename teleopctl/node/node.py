"""The node: one participant of the graph, with rclpy's methods."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from teleopctl.node import logging
from teleopctl.node.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from teleopctl.node.client import Client
from teleopctl.node.clock import Clock, ROSClock
from teleopctl.node.context import Context
from teleopctl.node.endpoint import Endpoint
from teleopctl.node.exceptions import NotInitializedException
from teleopctl.node.graph_view import GraphView
from teleopctl.node.guard_condition import GuardCondition
from teleopctl.node.names import (
    absolute_namespace,
    expand_name,
    fully_qualified,
    validate_node_name,
)
from teleopctl.node.node_parameters import NodeParameters
from teleopctl.node.parameter import Parameter
from teleopctl.node.publisher import Publisher
from teleopctl.node.qos import (
    QoSProfile,
    qos_from,
    qos_profile_rosout_default,
    qos_profile_services_default,
)
from teleopctl.node.service import Service
from teleopctl.node.subscription import Subscription
from teleopctl.node.timer import Rate, Timer
from teleopctl.wire.tokens import NodeToken, format_token

if TYPE_CHECKING:
    import zenoh

    from teleopctl.node.executor import Executor, Waitable

_EndpointT = TypeVar("_EndpointT", bound=Endpoint)


class Node(NodeParameters, GraphView):
    """One participant of the graph.

    Args:
        node_name: Its name, unless ``__node`` is remapped.
        context: Where it lives; the default context if None.
        cli_args: A command line of its own, with ``--ros-args`` groups.
        namespace: Its namespace, unless ``__ns`` is remapped.
        use_global_arguments: Heed the command line that ``init()`` was given.
        enable_rosout: Publish log messages on ``/rosout``.
        rosout_qos_profile: For that.
        start_parameter_services: Offer the parameters to the graph.
        parameter_overrides: Values that replace the defaults of declarations, and are themselves
            replaced by the command line's.
        allow_undeclared_parameters: Let undeclared parameters be set.
        automatically_declare_parameters_from_overrides: Declare what the overrides name.
        enable_logger_service: Offer ``~/get_logger_levels`` and ``~/set_logger_levels``.

    Raises:
        NotInitializedException: The context does not run.
        InvalidNodeNameException: Or InvalidNamespaceException: a name breaks a rule.
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        rosout_qos_profile: QoSProfile | int = qos_profile_rosout_default,
        start_parameter_services: bool = True,
        parameter_overrides: Iterable[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        self._context = context or Context.default()
        if not self._context.ok():
            raise NotInitializedException
        self._arguments = tuple(self._arguments_of(cli_args, use_global_arguments))
        name = node_name
        space = namespace or ""
        for arguments in self._arguments:
            space = arguments.namespace(node_name, space)
            name = arguments.node_name(name)
        validate_node_name(name)
        self._name = name
        self._namespace = absolute_namespace(space)
        self.enclave = self._context.arguments.enclave
        self.executor: Executor | None = None
        self._endpoints: list[Endpoint] = []
        self._guards: list[GuardCondition] = []
        self.timers: list[Timer] = []
        self._endpoints_lock = threading.Lock()
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._clock = ROSClock()
        self._logger = logging.get_logger(
            fully_qualified(self._namespace, name).lstrip("/").replace("/", ".")
        )
        for arguments in self._arguments:
            for logger_name, level in arguments.log_levels:
                logging.set_logger_level(logger_name, logging.severity_from_name(level))
            if not arguments.stdout_logs:
                logging.set_console_enabled(False)
        self.entity_id = self._context.next_id()
        self._token: zenoh.LivelinessToken | None = None
        self._announce()
        self._rosout = None
        if enable_rosout and all(arguments.rosout_logs for arguments in self._arguments):
            from teleopctl.node.rosout import RosoutPublisher

            self._rosout = RosoutPublisher(self, qos_from(rosout_qos_profile))
        self._init_parameters(
            parameter_overrides or (),
            allow_undeclared=allow_undeclared_parameters,
            declare_overrides=automatically_declare_parameters_from_overrides,
            start_services=start_parameter_services,
        )
        if enable_logger_service:
            from teleopctl.node.logger_service import LoggerService

            LoggerService(self)
        self._context.on_shutdown(self._wake_executor)

    def _arguments_of(self, cli_args: Sequence[str] | None, use_global: bool) -> Iterable[Any]:
        from teleopctl.node.ros_args import parse_ros_arguments

        if cli_args is not None:
            yield parse_ros_arguments(cli_args)
        if use_global:
            yield self._context.arguments

    def _announce(self) -> None:
        session = self._context.session
        token = NodeToken(
            domain=self._context.domain_id,
            zid=str(session.zid()),
            nid=self.entity_id,
            enclave=self.enclave,
            namespace=self._namespace,
            node=self._name,
        )
        self._token = session.liveliness().declare_token(format_token(token))

    def _wake_executor(self) -> None:
        if self.executor is not None:
            self.executor.wake()

    # -- identity --------------------------------------------------------------------------------

    @property
    def context(self) -> Context:
        """Where the node lives."""
        return self._context

    def get_name(self) -> str:
        """Return the node's name."""
        return self._name

    def get_namespace(self) -> str:
        """Return the node's absolute namespace."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Return namespace and name, such as ``/arm/teleop``."""
        return fully_qualified(self._namespace, self._name)

    def get_logger(self) -> logging.RcutilsLogger:
        """Return the node's logger."""
        return self._logger

    def get_clock(self) -> ROSClock:
        """Return the node's clock: the system's time, or ``/clock``'s with ``use_sim_time``."""
        return self._clock

    @property
    def default_callback_group(self) -> CallbackGroup:
        """The group of callbacks that name none."""
        return self._default_callback_group

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a topic, remapped unless ``only_expand``."""
        return self._resolve(topic, is_service=False, remap=not only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the absolute name of a service, remapped unless ``only_expand``."""
        return self._resolve(service, is_service=True, remap=not only_expand)

    def _resolve(self, name: str, *, is_service: bool, remap: bool) -> str:
        resolved = expand_name(name, self._name, self._namespace, is_service=is_service)
        if remap:
            for arguments in self._arguments:
                renamed: str = arguments.remap(
                    resolved, self._name, self._namespace, is_service=is_service
                )
                if renamed != resolved:
                    return renamed
        return resolved

    # -- making endpoints ------------------------------------------------------------------------

    def create_publisher(
        self,
        msg_type: Any,
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,  # noqa: ARG002 (events have none)
        event_callbacks: Any = None,  # noqa: ARG002 (Zenoh reports no QoS events)
        qos_overriding_options: Any = None,  # noqa: ARG002 (rclpy's signature)
        publisher_class: type[Publisher] = Publisher,
    ) -> Publisher:
        """Make a publisher; an integer QoS is the depth of the default profile.

        Raises:
            InvalidTopicNameException: The name breaks a rule.
        """
        name = self.resolve_topic_name(topic)
        return self._keep(publisher_class(self, msg_type, name, qos_from(qos_profile)))

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: Any = None,  # noqa: ARG002 (Zenoh reports no QoS events)
        qos_overriding_options: Any = None,  # noqa: ARG002 (rclpy's signature)
        raw: bool = False,
        immediate: bool = False,
    ) -> Subscription:
        """Make a subscription; see :class:`Subscription` for the callback and ``immediate``.

        Raises:
            InvalidTopicNameException: The name breaks a rule.
        """
        return self._keep(
            Subscription(
                self,
                msg_type,
                self.resolve_topic_name(topic),
                callback,
                callback_group or self._default_callback_group,
                qos_from(qos_profile),
                raw=raw,
                immediate=immediate,
            )
        )

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
        immediate: bool = False,
    ) -> Service:
        """Make a service server: ``callback(request, response) -> response``.

        Raises:
            InvalidServiceNameException: The name breaks a rule.
        """
        return self._keep(
            Service(
                self,
                srv_type,
                self.resolve_service_name(srv_name),
                callback,
                callback_group or self._default_callback_group,
                qos_profile,
                immediate=immediate,
            )
        )

    def create_client(
        self,
        srv_type: Any,
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client:
        """Make a service client.

        Raises:
            InvalidServiceNameException: The name breaks a rule.
        """
        name = self.resolve_service_name(srv_name)
        group = callback_group or self._default_callback_group
        return self._keep(Client(self, srv_type, name, group, qos_profile))

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Make a timer on the node's clock, or on another.

        Args:
            timer_period_sec: Period in seconds.
            callback: Called each period.
            callback_group: For multi-threaded executors.
            clock: The node's clock if None, so simulated time counts where it is used.
            autostart: Start at once; else :meth:`Timer.reset` does.
        """
        timer = Timer(
            self,
            callback,
            callback_group or self._default_callback_group,
            int(timer_period_sec * 1_000_000_000),
            clock or self._clock,
            autostart=autostart,
        )
        self.timers.append(timer)
        if self.executor is not None:
            self.executor.recheck()
        return timer

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Make a rate in Hz, to sleep by in a thread that does not spin.

        Raises:
            ValueError: The frequency is not positive.
        """
        if frequency <= 0:
            raise ValueError("frequency must be positive")
        return Rate(self.create_timer(1.0 / frequency, None, clock=clock))

    def create_guard_condition(
        self, callback: Callable[[], Any], callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Make a condition that any thread can trigger to have ``callback`` run by the executor."""
        guard = GuardCondition(self, callback, callback_group or self._default_callback_group)
        self._guards.append(guard)
        return guard

    def _keep(self, endpoint: _EndpointT) -> _EndpointT:
        with self._endpoints_lock:
            self._endpoints.append(endpoint)
        if self.executor is not None and isinstance(endpoint, Subscription | Service):
            # What arrived before the node knew its endpoint has woken nobody.
            for _ in range(endpoint.pending()):
                self.executor.enqueue(endpoint)
        return endpoint

    # -- what there is ---------------------------------------------------------------------------

    def waitables(self) -> list[Waitable]:
        """Return what may have arrivals for an executor."""
        with self._endpoints_lock:
            receiving = [e for e in self._endpoints if isinstance(e, Subscription | Service)]
        return [*receiving, *self._guards]

    @property
    def publishers(self) -> list[Publisher]:
        """The node's publishers."""
        return [endpoint for endpoint in self._endpoints if isinstance(endpoint, Publisher)]

    @property
    def subscriptions(self) -> list[Subscription]:
        """The node's subscriptions."""
        return [endpoint for endpoint in self._endpoints if isinstance(endpoint, Subscription)]

    @property
    def services(self) -> list[Service]:
        """The node's service servers."""
        return [endpoint for endpoint in self._endpoints if isinstance(endpoint, Service)]

    @property
    def clients(self) -> list[Client]:
        """The node's service clients."""
        return [endpoint for endpoint in self._endpoints if isinstance(endpoint, Client)]

    # -- taking things down ----------------------------------------------------------------------

    def _forget(self, endpoint: Endpoint) -> bool:
        with self._endpoints_lock:
            if endpoint not in self._endpoints:
                return False
            self._endpoints.remove(endpoint)
        endpoint.destroy()
        return True

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher; False when it is not this node's."""
        return self._forget(publisher)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription; False when it is not this node's."""
        return self._forget(subscription)

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service server; False when it is not this node's."""
        return self._forget(service)

    def destroy_client(self, client: Client) -> bool:
        """Destroy a service client; False when it is not this node's."""
        return self._forget(client)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer; False when it is not this node's."""
        if timer not in self.timers:
            return False
        self.timers.remove(timer)
        timer.destroy()
        return True

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate and its timer."""
        rate.destroy()
        return self.destroy_timer(rate._timer)  # noqa: SLF001 (a rate is a part of its timer)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition; False when it is not this node's."""
        if guard not in self._guards:
            return False
        self._guards.remove(guard)
        return True

    def destroy_node(self) -> None:
        """Take the node and all that it has out of the graph; twice is once."""
        self._context.forget_on_shutdown(self._wake_executor)
        if self.executor is not None:
            self.executor.remove_node(self)
        if self._rosout is not None:
            self._rosout.destroy()
        for timer in tuple(self.timers):
            self.destroy_timer(timer)
        with self._endpoints_lock:
            endpoints, self._endpoints = self._endpoints, []
        for endpoint in reversed(endpoints):
            endpoint.destroy()
        token, self._token = self._token, None
        if token is not None and self._context.session_is_open:
            token.undeclare()  # type: ignore[no-untyped-call]

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy_node()

    def __repr__(self) -> str:
        return f"<Node {self.get_fully_qualified_name()}>"
