"""The short-lived, hidden node that a verb uses to publish, subscribe and call services."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from teleopctl.base.typed import TYPE_CHECKING, Any, Literal

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
    """Yield the hidden node ``_ros2cli_PID`` of a verb, in a session of its own.

    Args:
        session_mode: ``client`` for a few exchanges through the router; ``peer`` for a stream,
            which then goes straight from process to process.
        name: Another name.
        use_sim_time: Let its clock follow ``/clock``.
        ros_args: What stands behind ``--ros-args``, such as ``-r __ns:=/left``.

    Raises:
        RouterNotRunning: A client finds no router.
        TeleopctlError: A ROS argument is malformed.
    """
    from teleopctl.node import Node, Parameter

    with (
        _command_context(session_mode, ros_args) as context,
        Node(
            name or _name(),
            context=context,
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=([Parameter("use_sim_time", value=True)] if use_sim_time else None),
        ) as node,
    ):
        yield node


@contextmanager
def brief_node(*, name: str | None = None, starts_router: bool = False) -> Iterator[BareNode]:
    """Yield a node without parameters, for a few exchanges through the router.

    Args:
        name: Another name.
        starts_router: Start the daemon where no router answers; see `ensure_router`.

    Raises:
        RouterNotRunning: There is no router.
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
        with BareNode(name or _name(), context) as node:
            yield node


def _name() -> str:
    return f"_ros2cli_{os.getpid()}"


@contextmanager
def _command_context(
    session_mode: Literal["peer", "client"], ros_args: Sequence[str] = ()
) -> Iterator[Context]:
    from teleopctl.node import Context, SignalHandlerOptions

    context = Context()
    # A command has nothing to put in order: SIGTERM may end it at once, wherever it is.
    context.init(
        ["--ros-args", *ros_args] if ros_args else [],
        # Its output is the command's, and the import of logging takes longer than some commands.
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
    """Call the same service of several nodes at once; return the response or error of each.

    Args:
        node: The node that asks.
        type_: The service's type.
        service: The service's name below that of the node, such as ``get_state``.
        node_names: Full names of those that are asked.
        request: What they are sent.
        timeout_s: Longest wait for all the answers, in seconds.

    Returns:
        The response of each, or an UnavailableError where one did not answer.
    """
    from teleopctl.wire import responses_of_nodes

    futures = {
        name: node.create_client(type_, f"{name}/{service}").call_async(request)
        for name in node_names
    }
    return responses_of_nodes(futures, timeout_s)
