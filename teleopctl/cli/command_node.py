"""The short-lived, hidden node that a verb uses to publish, subscribe and call services."""

from __future__ import annotations

import os

from teleopctl.base.typed import (
    TYPE_CHECKING,
    Any,
    Iterable,
    Iterator,
    Literal,
    Sequence,
    contextmanager,
)

if TYPE_CHECKING:
    from teleopctl.interfaces import ServiceType
    from teleopctl.node import BareNode, Context, Node


@contextmanager
def command_node(
    *,
    session_mode: Literal["peer", "client"] = "peer",
    name: str | None = None,
    use_sim_time: bool = False,
    ros_args: Sequence[str] = (),
) -> Iterator[Node]:
    """Yield a verb's hidden node (``_ros2cli_PID`` by default) in a context of its own.

    Args:
        session_mode: Mode of the Zenoh session: ``client`` for a few messages through the router,
            ``peer`` for a stream of messages directly between processes.
        name: Name of the node, instead of ``_ros2cli_PID``.
        use_sim_time: Whether the node's clock follows ``/clock``.
        ros_args: Arguments after ``--ros-args``, such as ``-r __ns:=/left``.

    Raises:
        RouterNotRunning: No router runs, and ``session_mode`` is ``client``.
        TeleopctlError: A ROS argument is malformed.
    """
    from teleopctl.node import Node, Parameter

    with (
        _command_context(session_mode, ros_args) as context,
        Node(
            name or command_node_name(),
            context=context,
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=([Parameter("use_sim_time", value=True)] if use_sim_time else None),
        ) as node,
    ):
        yield node


@contextmanager
def brief_node(*, name: str | None = None, starts_router: bool = False) -> Iterator[BareNode]:
    """Yield a verb's hidden node without parameters, connected as a client of the router.

    Args:
        name: Name of the node, instead of ``_ros2cli_PID``.
        starts_router: Whether to start the daemon if no router runs; see `ensure_router`.

    Raises:
        RouterNotRunning: No router runs, and ``starts_router`` is false.
    """
    from teleopctl.node import BareNode
    from teleopctl.wire import RouterNotRunning

    with _command_context("client") as context:
        try:
            _ = context.session
        except RouterNotRunning:
            if not starts_router:
                raise
            from teleopctl.wire import ensure_router

            ensure_router()
        with BareNode(name or command_node_name(), context) as node:
            yield node


def command_node_name() -> str:
    """Return the name of a verb's node, as ROS 2's: hidden, with the process's id."""
    return f"_ros2cli_{os.getpid()}"


@contextmanager
def _command_context(
    session_mode: Literal["peer", "client"], ros_args: Sequence[str] = ()
) -> Iterator[Context]:
    from teleopctl.node import Context, SignalHandlerOptions

    context = Context()
    # A command needs no cleanup: SIGTERM may end it at any time.
    context.init(
        ["--ros-args", *ros_args] if ros_args else [],
        # The command prints its output itself, and importing logging takes longer than some
        # commands.
        initialize_logging=False,
        session_mode=session_mode,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    try:
        yield context
    finally:
        context.try_shutdown()


# Any: requests and responses of any service.
def call_all(
    node: Node,
    type_: type[ServiceType[Any, Any]],
    service: str,
    node_names: Iterable[str],
    request: Any,
    timeout_s: float,
) -> dict[str, Any]:
    """Call a service of several nodes at once; return each response or error by node name.

    Args:
        node: Node that calls the services.
        type_: Type of the services.
        service: Name of the service relative to its node, such as ``get_state``.
        node_names: Full names of the nodes whose service is called.
        request: Request that is sent to each service.
        timeout_s: Longest wait for all responses, in seconds.

    Returns:
        Response by full node name, or an UnavailableError for a node that did not respond.
    """
    from teleopctl.wire import responses_of_nodes

    futures = {
        name: node.create_client(type_, f"{name}/{service}").call_async(request)
        for name in node_names
    }
    return responses_of_nodes(futures, timeout_s)
