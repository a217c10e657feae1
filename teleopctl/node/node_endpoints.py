"""Methods of a node that create and destroy publishers, subscriptions, services and clients."""

from __future__ import annotations

import abc
from collections.abc import Sequence

from teleopctl.base.typed import TYPE_CHECKING, Any, Literal, Self, TypeVar, overload
from teleopctl.interfaces import MessageT, RequestT, ResponseT, get_message
from teleopctl.node.clock import Clock
from teleopctl.node.context import Context
from teleopctl.node.endpoints.endpoint import Endpoint
from teleopctl.node.endpoints.waitable import QueuingEntity
from teleopctl.node.node_timers import NodeTimers
from teleopctl.node.values.callback_groups import CallbackGroup
from teleopctl.node.values.handle import Handle
from teleopctl.node.values.qos import QoSProfile, as_qos_profile, qos_profile_services_default
from teleopctl.node.values.time import ClockType

if TYPE_CHECKING:
    from teleopctl.interfaces import Message, ServiceType
    from teleopctl.node.endpoints.client import Client
    from teleopctl.node.endpoints.events import (
        PublisherEventCallbacks,
        SubscriptionEventCallbacks,
    )
    from teleopctl.node.endpoints.publisher import Publisher
    from teleopctl.node.endpoints.qos_overrides import QoSOverridingOptions
    from teleopctl.node.endpoints.service import Service, ServiceCallback
    from teleopctl.node.endpoints.subscription import (
        ContentFilterOptions,
        RawCallback,
        Subscription,
        SubscriptionCallback,
    )
    from teleopctl.node.endpoints.topic_statistics import TopicStatisticsOptions


# Endpoint classes are imported where needed: most commands create endpoints of one kind only.

_EndpointT = TypeVar("_EndpointT", bound=Endpoint)


class NodeEndpoints(NodeTimers):
    """Base of nodes with methods for publishers, subscriptions, services and clients."""

    def __init__(
        self,
        node_name: str,
        context: Context | None,
        cli_args: Sequence[str] | None,
        namespace: str | None,
        use_global_arguments: bool,
    ) -> None:
        super().__init__(node_name, context, cli_args, namespace, use_global_arguments)
        self._endpoints: list[Endpoint] = []

    @property
    def itself(self) -> Self:
        """The node itself; differs from an object that only forwards attributes to it (ours)."""
        return self

    # -- creation --------------------------------------------------------------------------------

    def create_publisher(
        self,
        msg_type: type[MessageT],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        publisher_class: type[Publisher[MessageT]] | None = None,
    ) -> Publisher[MessageT]:
        """Create and return a publisher; an integer QoS is the depth of the default profile.

        Args:
            msg_type: Message class.
            topic: Relative, absolute or private name of the topic.
            qos_profile: QoS profile, or history depth.
            callback_group: Callback group of the event callbacks.
            event_callbacks: Callbacks for matched subscriptions, missed deadlines and other events.
            qos_overriding_options: QoS policies that parameters may override.
            publisher_class: Class of the publisher; `Publisher` if None.

        Raises:
            InvalidTopicNameException: The name is malformed.
        """
        name = self.resolve_topic_name(topic)
        qos = as_qos_profile(qos_profile)
        if qos_overriding_options is not None:
            qos = self._overridden_qos(qos, qos_overriding_options, "publisher", name)
        if publisher_class is None:
            from teleopctl.node.endpoints.publisher import Publisher

            publisher_class = Publisher
        publisher = self.add_endpoint(publisher_class(self, msg_type, name, qos))
        if event_callbacks is not None:
            self._add_event_callbacks(publisher, event_callbacks, callback_group)
        return publisher

    @abc.abstractmethod
    def _overridden_qos(
        self,
        profile: QoSProfile,
        options: QoSOverridingOptions,
        side: Literal["publisher", "subscription"],
        topic: str,
    ) -> QoSProfile:
        """Return a QoS profile with the overrides of the node's parameters."""

    def _add_event_callbacks(
        self,
        endpoint: Publisher[MessageT] | Subscription[MessageT],
        callbacks: Any,  # of the endpoint's kind
        group: CallbackGroup | None,
    ) -> None:
        try:
            endpoint.add_event_callbacks(callbacks, group or self._default_callback_group)
        except BaseException:
            self._remove_endpoint(endpoint)
            raise
        for event in endpoint.events:
            if event.pending():
                event.notify_executor()

    @overload
    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: SubscriptionCallback[MessageT],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        content_filter_options: ContentFilterOptions | None = None,
        topic_statistics: TopicStatisticsOptions | None = None,
        raw: Literal[False] = False,
        immediate: bool = False,
    ) -> Subscription[MessageT]: ...

    @overload
    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: RawCallback,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        content_filter_options: ContentFilterOptions | None = None,
        topic_statistics: TopicStatisticsOptions | None = None,
        raw: bool,
        immediate: bool = False,
    ) -> Subscription[MessageT]: ...

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: SubscriptionCallback[MessageT] | RawCallback,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        content_filter_options: ContentFilterOptions | None = None,  # noqa: ARG002
        topic_statistics: TopicStatisticsOptions | None = None,
        raw: bool = False,
        immediate: bool = False,
    ) -> Subscription[MessageT]:
        """Create and return a subscription, whose callback receives the topic's messages.

        Args:
            msg_type: Message class.
            topic: Relative, absolute or private name of the topic.
            callback: ``callback(msg)`` or ``callback(msg, info)`` with a `MessageInfo`; may be a
                coroutine function.
            qos_profile: QoS profile, or history depth.
            callback_group: Callback group of the callback and of the event callbacks; the node's
                default group if None.
            event_callbacks: Callbacks for matched publishers, missed deadlines and other events.
            qos_overriding_options: QoS policies that parameters may override.
            content_filter_options: Unused, for rclpy programs: as under rmw_zenoh all messages are
                received.
            topic_statistics: Options for publishing message statistics, as in rclcpp; nothing is
                published if None.
            raw: Whether the callback receives CDR bytes instead of a message.
            immediate: Whether to call the callback on Zenoh's receiving thread, without an
                executor; see `Subscription`.

        Raises:
            InvalidTopicNameException: The name is malformed.
            ValueError: The period of the statistics is not positive.
        """
        from teleopctl.node.endpoints.subscription import Subscription

        if topic_statistics is not None:
            topic_statistics.check()
        name = self.resolve_topic_name(topic)
        qos = as_qos_profile(qos_profile)
        if qos_overriding_options is not None:
            qos = self._overridden_qos(qos, qos_overriding_options, "subscription", name)
        subscription = self.add_endpoint(
            Subscription(
                self,
                msg_type,
                name,
                callback,
                callback_group or self._default_callback_group,
                qos,
                raw=raw,
                immediate=immediate,
            )
        )
        if event_callbacks is not None:
            self._add_event_callbacks(subscription, event_callbacks, callback_group)
        if topic_statistics is not None:
            self._publish_statistics(subscription, topic_statistics)
        return subscription

    def _publish_statistics(
        self, subscription: Subscription[MessageT], options: TopicStatisticsOptions
    ) -> None:
        from teleopctl.node.endpoints.topic_statistics import TopicStatistics

        metrics = get_message("statistics_msgs/msg/MetricsMessage")
        publisher = self.create_publisher(metrics, options.publish_topic, options.qos_profile)
        statistics = TopicStatistics(self.get_name(), publisher)
        timer = self.create_timer(
            options.publish_period_sec,
            statistics.publish,
            subscription.callback_group,
            Clock(clock_type=ClockType.STEADY_TIME),
        )

        def stop() -> None:
            self.destroy_timer(timer)
            self.destroy_publisher(publisher)

        subscription.set_measurement(statistics.on_message, stop)

    def create_service(
        self,
        srv_type: type[ServiceType[RequestT, ResponseT]],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
        immediate: bool = False,
    ) -> Service[RequestT, ResponseT]:
        """Create and return a service server, whose callback is called for each request.

        Args:
            srv_type: Service class with ``Request`` and ``Response``.
            srv_name: Relative, absolute or private name of the service.
            callback: ``callback(request, response) -> response``; may be a coroutine function.
            qos_profile: QoS profile.
            callback_group: Callback group of the callback; the node's default group if None.
            immediate: Whether to call the callback on Zenoh's receiving thread, without an
                executor; see `Service`.

        Raises:
            InvalidServiceNameException: The name is malformed.
        """
        from teleopctl.node.endpoints.service import Service

        return self.add_endpoint(
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
        srv_type: type[ServiceType[RequestT, ResponseT]],
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client[RequestT, ResponseT]:
        """Create and return a client of a service.

        Args:
            srv_type: Service class with ``Request`` and ``Response``.
            srv_name: Relative, absolute or private name of the service.
            qos_profile: QoS profile.
            callback_group: Callback group of the futures' done callbacks; the node's default group
                if None.

        Raises:
            InvalidServiceNameException: The name is malformed.
        """
        from teleopctl.node.endpoints.client import Client

        name = self.resolve_service_name(srv_name)
        group = callback_group or self._default_callback_group
        return self.add_endpoint(Client(self, srv_type, name, group, qos_profile))

    def _of_class(self, class_: type[_EndpointT]) -> list[_EndpointT]:
        with self._endpoints_lock:
            return [endpoint for endpoint in self._endpoints if isinstance(endpoint, class_)]

    def add_endpoint(self, endpoint: _EndpointT) -> _EndpointT:
        """Register an endpoint, to be served and destroyed with the node; return it (ours)."""
        with self._endpoints_lock:
            self._endpoints.append(endpoint)
        if isinstance(endpoint, QueuingEntity):
            endpoint.callback_group.add_entity(endpoint)
        if isinstance(endpoint, QueuingEntity) and endpoint.pending():
            # An executor that got the node in between did not check this endpoint.
            endpoint.notify_executor()
        return endpoint

    # -- entities --------------------------------------------------------------------------------

    def executor_entities(self) -> list[QueuingEntity]:
        """Return the node's entities whose queued items an executor takes and handles (ours)."""
        with self._endpoints_lock:
            receiving = [e for e in self._endpoints if isinstance(e, QueuingEntity)]
            events = [e for point in self._endpoints for e in point.events if e.is_served]
            return [*receiving, *self._guards, *events, *self._waitables]

    # Each endpoint has its own message type; `Message` is the base of all.

    @property
    def publishers(self) -> list[Publisher[Message]]:
        """Publishers of the node."""
        from teleopctl.node.endpoints.publisher import Publisher

        return self._of_class(Publisher)

    @property
    def subscriptions(self) -> list[Subscription[Message]]:
        """Subscriptions of the node."""
        from teleopctl.node.endpoints.subscription import Subscription

        return self._of_class(Subscription)

    @property
    def services(self) -> list[Service[Message, Message]]:
        """Service servers of the node."""
        from teleopctl.node.endpoints.service import Service

        return self._of_class(Service)

    @property
    def clients(self) -> list[Client[Message, Message]]:
        """Service clients of the node."""
        from teleopctl.node.endpoints.client import Client

        return self._of_class(Client)

    # -- destruction -----------------------------------------------------------------------------

    def _remove_endpoint(self, endpoint: Endpoint) -> bool:
        with self._endpoints_lock:
            if endpoint not in self._endpoints:
                return False
            self._endpoints.remove(endpoint)
        endpoint.destroy()
        return True

    def destroy_publisher(self, publisher: Publisher[MessageT]) -> bool:
        """Destroy a publisher of the node; return False if it is not the node's."""
        return self._remove_endpoint(publisher)

    def destroy_subscription(self, subscription: Subscription[MessageT]) -> bool:
        """Destroy a subscription of the node; return False if it is not the node's."""
        return self._remove_endpoint(subscription)

    def destroy_service(self, service: Service[RequestT, ResponseT]) -> bool:
        """Destroy a service server of the node; return False if it is not the node's."""
        return self._remove_endpoint(service)

    def destroy_client(self, client: Client[RequestT, ResponseT]) -> bool:
        """Destroy a service client of the node; return False if it is not the node's."""
        return self._remove_endpoint(client)

    @property
    def handle(self) -> Handle:
        """Handle of the node, as in rclpy."""
        return Handle(self, self.get_name())

    @property
    def is_destroyed(self) -> bool:
        """Whether the node was destroyed (ours)."""
        return self._token is None

    def destroy(self) -> None:
        """Destroy the node; same as `destroy_node`, for `Handle`."""
        self.destroy_node()

    def destroy_node(self) -> None:
        """Destroy the node with all its entities, and remove it from the graph. Idempotent."""
        self._remove_graph_callbacks()
        if self.executor is not None:
            self.executor.remove_node(self)
        self._destroy_all()
        self._withdraw()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy_node()

    def _destroy_all(self) -> None:
        """Destroy timers and endpoints, the newest endpoint first."""
        with self._endpoints_lock:
            timers, self._timers = self._timers, ()
            endpoints, self._endpoints = self._endpoints, []
            self._guards = []
            waitables, self._waitables = self._waitables, []
        for waitable in waitables:
            waitable.close()
        for timer in timers:
            timer.destroy()
        for endpoint in reversed(endpoints):
            endpoint.destroy()


class BareNode(NodeEndpoints):
    """Node without parameters, ``/rosout`` and ``/clock``, for short commands (ours).

    Starts in half the time of a `Node`. It has no parameter services, publishes no log messages and
    does not follow ``/clock``.

    Args:
        node_name: Name of the node; command-line arguments do not change it.
        context: Context of the node.

    Raises:
        NotInitializedException: The context is not initialized.
        InvalidNodeNameException: The name is malformed.
    """

    def __init__(self, node_name: str, context: Context) -> None:
        super().__init__(node_name, context, None, None, use_global_arguments=False)
        self._announce()

    def _overridden_qos(
        self,
        profile: QoSProfile,
        options: QoSOverridingOptions,  # noqa: ARG002 -- the node has no parameters
        side: Literal["publisher", "subscription"],  # noqa: ARG002
        topic: str,  # noqa: ARG002
    ) -> QoSProfile:
        return profile
