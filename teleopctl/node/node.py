"""The node: one participant of the graph, with rclpy's methods."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from teleopctl.node import logging
from teleopctl.node.clock import ROSClock
from teleopctl.node.context import Context
from teleopctl.node.exceptions import NotInitializedException
from teleopctl.node.graph_view import GraphView
from teleopctl.node.names import (
    absolute_namespace,
    expand_name,
    fully_qualified,
    validate_node_name,
)
from teleopctl.node.node_endpoints import NodeEndpoints
from teleopctl.node.node_parameters import NodeParameters
from teleopctl.node.parameter import Parameter
from teleopctl.node.qos import (
    QoSProfile,
    qos_from,
    qos_profile_rosout_default,
)
from teleopctl.wire.tokens import NodeToken, format_token

if TYPE_CHECKING:
    import zenoh

    from teleopctl.node.rosout import RosoutPublisher


class Node(NodeEndpoints, NodeParameters, GraphView):
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
        NodeEndpoints.__init__(self)
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
        self._rosout: RosoutPublisher | None = None
        self._graph_callbacks = []
        try:
            self._announce()
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
        except BaseException:
            # A node that could not be made must not stay in the graph.
            self.destroy_node()
            raise

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

    def destroy_node(self) -> None:
        """Take the node and all that it has out of the graph; twice is once."""
        self._forget_graph_callbacks()
        if self.executor is not None:
            self.executor.remove_node(self)
        if self._rosout is not None:
            self._rosout.destroy()
        self._destroy_all()
        token, self._token = self._token, None
        if token is not None and self._context.session_is_open:
            token.undeclare()

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy_node()

    def __repr__(self) -> str:
        return f"<Node {self.get_fully_qualified_name()}>"
