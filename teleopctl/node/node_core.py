"""Core of a node: name, namespace, context, logger, clock and name resolution."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.node.clock import ROSClock
from teleopctl.node.context import Context
from teleopctl.node.graph_view import GraphView
from teleopctl.node.values import logging
from teleopctl.node.values.names import (
    absolute_namespace,
    expand_name,
    fully_qualified,
    validate_node_name,
)
from teleopctl.node.values.ros_args import RosArguments, parse_ros_arguments
from teleopctl.wire import NodeToken, format_token

if TYPE_CHECKING:
    import zenoh

    from teleopctl.node.values.callback_groups import Scheduler


class NodeCore(GraphView):
    """Base of nodes: name, namespace, context, executor, logger and clock.

    Args:
        node_name: Name of the node, unless ``__node`` is remapped.
        context: Context of the node; the default context if None.
        cli_args: Command-line arguments of the node, with ``--ros-args`` groups.
        namespace: Namespace of the node, unless ``__ns`` is remapped.
        use_global_arguments: Whether the command-line arguments of ``init()`` apply.

    Attributes:
        failure: Exception that ended a thread of the node, see `fail`; None without one.
        enclave: Security enclave in the node's liveliness token.
        entity_id: Entity ID of the node within its session.

    Raises:
        NotInitializedException: The context is not initialized.
        InvalidNodeNameException: The name is malformed.
        InvalidNamespaceException: The namespace is malformed.
    """

    def __init__(
        self,
        node_name: str,
        context: Context | None,
        cli_args: Sequence[str] | None,
        namespace: str | None,
        use_global_arguments: bool,
    ) -> None:
        self._context = context or Context.default()
        if not self._context.ok():
            raise self._context.not_running_error()
        self._arguments = tuple(self._arguments_of(cli_args, use_global_arguments))
        # Rules of the node's arguments have priority over those of the process, as in rcl.
        names = (arguments.node_name(node_name) for arguments in self._arguments)
        spaces = (arguments.namespace(node_name) for arguments in self._arguments)
        name = next((found for found in names if found is not None), node_name)
        space = next((found for found in spaces if found is not None), namespace or "")
        validate_node_name(name)
        self._name = name
        self._namespace = absolute_namespace(space)
        self.enclave = self._context.arguments.enclave
        self._executor: Scheduler | None = None
        self.failure: BaseException | None = None
        self._clock = ROSClock()
        self._logger = logging.get_logger(
            fully_qualified(self._namespace, name).lstrip("/").replace("/", ".")
        )
        for arguments in self._arguments:
            for logger_name, level in arguments.log_levels:
                logging.set_logger_level(logger_name, logging.severity_from_name(level))
            if not arguments.stdout_logs:
                logging.set_console_enabled(False)
        self._context.add_node_logger(self._logger.name)
        self.entity_id = self._context.next_id()
        self._token: zenoh.LivelinessToken | None = None
        self._token_key = ""
        self._graph_callbacks: list[Callable[[], None]] = []

    def _arguments_of(
        self, cli_args: Sequence[str] | None, use_global: bool
    ) -> Iterable[RosArguments]:
        if cli_args is not None:
            yield parse_ros_arguments(cli_args)
        if use_global:
            yield self._context.arguments

    def _announce(self) -> None:
        """Declare the node's liveliness token."""
        token = NodeToken(
            domain=self._context.domain_id,
            zid=str(self._context.session.zid()),
            nid=self.entity_id,
            enclave=self.enclave,
            namespace=self._namespace,
            node=self._name,
        )
        self._token_key = format_token(token)
        self._token = self._context.announce(self._token_key)

    def _withdraw(self) -> None:
        """Remove the node from the graph. Idempotent."""
        self._context.remove_node_logger(self._logger.name)
        token, self._token = self._token, None
        if token is not None and self._context.session_is_open:
            self._context.withdraw(token, self._token_key)

    @property
    def executor(self) -> Scheduler | None:
        """Executor of the node or None; setting it moves the node to that executor."""
        return self._executor

    @executor.setter
    def executor(self, executor: Scheduler | None) -> None:
        before = self._executor
        if executor is before:
            return
        if before is not None:
            before.remove_node(self)
        self._executor = executor
        if executor is not None:
            executor.add_node(self)

    @property
    def context(self) -> Context:
        """Context of the node."""
        return self._context

    def get_name(self) -> str:
        """Return the node's name."""
        return self._name

    def get_namespace(self) -> str:
        """Return the node's absolute namespace."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Return the node's namespace and name, such as ``/arm/teleop``."""
        return fully_qualified(self._namespace, self._name)

    def get_logger(self) -> logging.RcutilsLogger:
        """Return the node's logger."""
        return self._logger

    def get_clock(self) -> ROSClock:
        """Return the node's clock: system time, or ``/clock`` with ``use_sim_time``."""
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

    def fail(self, error: BaseException) -> None:
        """Raise an exception in the thread that spins the node, now or later (ours)."""
        self.failure = error
        if self.executor is not None:
            self.executor.fail(error)

    def __repr__(self) -> str:
        return f"<Node {self.get_fully_qualified_name()}>"
