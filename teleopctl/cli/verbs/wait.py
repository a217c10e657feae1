"""``teleopctl wait``: waits, for scripts, until something is in the graph or a message comes."""

import threading
import time

from teleopctl.base.typed import TYPE_CHECKING, Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.options import AsJson, NodeName, ServiceName, TopicName, check_not_negative
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import UnavailableError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from teleopctl.wire import Graph

GROUP = VerbGroup(
    "Wait for nodes, topics, services, actions, transforms or messages, in scripts.",
    {
        "topic": Verb(
            f"{__name__}:wait_for_topic",
            "Wait until a topic has a publisher.",
            examples=("teleopctl wait topic /joint_states --timeout 10",),
        ),
        "node": Verb(f"{__name__}:wait_for_node", "Wait until a node is in the graph."),
        "service": Verb(f"{__name__}:wait_for_service", "Wait until a service has a server."),
        "action": Verb(f"{__name__}:wait_for_action", "Wait until an action has a server."),
        "tf": Verb(
            f"{__name__}:wait_for_transform", "Wait until a transform between two frames is known."
        ),
        "message": Verb(
            f"{__name__}:wait_for_message",
            "Wait for a message of a topic, optionally for one that fits an expression.",
            examples=("teleopctl wait message /odom --filter 'm.pose.pose.position.x > 1'",),
        ),
    },
)

Timeout = Annotated[
    float | None,
    Option("--timeout", help="Longest wait; by default for ever.", metavar="SECONDS"),
]
# Ctrl-C is looked for that often while a transform is waited for, s.
_LONGEST_STEP_S = 1.0


def wait_for_topic(topic_name: TopicName, timeout: Timeout = None, as_json: AsJson = False) -> None:
    """Wait until a topic has a publisher; exit status 1 after the timeout."""
    name = absolute_name(topic_name)
    _wait(
        f"Topic {name} has no publisher",
        lambda graph: bool(graph.publishers(name)),
        lambda graph: [topic for topic, _ in graph.topic_names_and_types()],
        name,
        timeout,
        as_json=as_json,
    )


def wait_for_node(node_name: NodeName, timeout: Timeout = None, as_json: AsJson = False) -> None:
    """Wait until a node is in the graph; exit status 1 after the timeout."""
    name = absolute_name(node_name)
    _wait(
        f"Node {name} is not there",
        lambda graph: graph.find_node(name) is not None,
        lambda graph: graph.node_names(),
        name,
        timeout,
        as_json=as_json,
    )


def wait_for_service(
    service_name: ServiceName, timeout: Timeout = None, as_json: AsJson = False
) -> None:
    """Wait until a service has a server; exit status 1 after the timeout."""
    name = absolute_name(service_name)
    _wait(
        f"Service {name} has no server",
        lambda graph: bool(graph.servers(name)),
        lambda graph: [service for service, _ in graph.service_names_and_types()],
        name,
        timeout,
        as_json=as_json,
    )


def wait_for_action(
    action_name: Annotated[str, Argument(help="The action.", complete="actions")],
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Wait until an action has a server; exit status 1 after the timeout."""
    name = absolute_name(action_name)
    _wait(
        f"Action {name} has no server",
        lambda graph: bool(graph.action_servers(name)),
        lambda graph: [action for action, _ in graph.action_names_and_types()],
        name,
        timeout,
        as_json=as_json,
    )


def _wait(
    missing: str,
    is_there: "Callable[[Graph], bool]",
    names: "Callable[[Graph], Iterable[str]]",
    name: str,
    timeout_s: float | None,
    *,
    as_json: bool,
) -> None:
    """Wait until the graph satisfies a predicate; report success to a program only.

    Raises:
        UnavailableError: The timeout has passed.
    """
    from teleopctl.cli.command_node import brief_node

    check_not_negative(timeout=timeout_s)
    begin = time.monotonic()
    with brief_node(starts_router=True) as node:
        if not node.context.wait_for_graph(is_there, timeout_s):
            raise _timeout_error(missing, timeout_s, did_you_mean(name, names(node.graph())))
    _report(name, begin, as_json=as_json)


def _timeout_error(missing: str, timeout_s: float | None, hint: str | None) -> UnavailableError:
    return UnavailableError(f"{missing} after {timeout_s or 0.0:g} s", hint=hint)


def _report(name: str, begin: float, *, as_json: bool) -> None:
    if as_json:
        console.out_json({"name": name, "waited_s": round(time.monotonic() - begin, 3)})


def wait_for_transform(
    source_frame: Annotated[
        str,
        Argument(help="Frame in which the transform is expressed.", complete="frames"),
    ],
    target_frame: Annotated[str, Argument(help="The other frame.", complete="frames")],
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Wait until the transform between two frames is known; exit status 1 after the timeout."""
    from teleopctl.cli.command_node import command_node
    from teleopctl.node import Duration, Time
    from teleopctl.tf import Buffer, TransformListener
    from teleopctl.wire import ensure_router

    check_not_negative(timeout=timeout)
    begin = time.monotonic()
    buffer = Buffer()
    frames = source_frame.lstrip("/"), target_frame.lstrip("/")
    ensure_router()
    with command_node() as node:
        TransformListener(buffer, node)
        step = Duration(seconds=_LONGEST_STEP_S if timeout is None else timeout)
        while not buffer.can_transform(*frames, Time(), step):
            if timeout is not None:
                unknown = [frame for frame in frames if frame not in buffer.frame_names()]
                raise _timeout_error(
                    f"No transform from {source_frame} to {target_frame}",
                    timeout,
                    f"Unknown: {', '.join(unknown)}." if unknown else None,
                )
    _report(f"{source_frame} {target_frame}", begin, as_json=as_json)


def wait_for_message(
    topic_name: TopicName,
    filter_expression: Annotated[
        str | None,
        Option("--filter", help="Python expression on the message, m.", metavar="EXPRESSION"),
    ] = None,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Wait for a message of a topic; exit status 1 after the timeout.

    Waits for a publisher first. To print the message: `teleopctl topic echo --once`.
    """
    from teleopctl.cli.command_node import command_node
    from teleopctl.cli.messages import filter_predicate
    from teleopctl.cli.verbs.topic.sources import find_source
    from teleopctl.wire import ensure_router

    check_not_negative(timeout=timeout)
    is_wanted = filter_predicate(filter_expression) if filter_expression else lambda _: True
    name = absolute_name(topic_name)
    begin = time.monotonic()
    ensure_router()
    with command_node() as node:
        if not node.context.wait_for_graph(lambda graph: bool(graph.publishers(name)), timeout):
            topics = [topic for topic, _ in node.graph().topic_names_and_types()]
            hint = did_you_mean(name, topics)
            raise _timeout_error(f"Topic {name} has no publisher", timeout, hint)
        source = find_source(name, graph=node.graph())
        came = threading.Event()
        failures: list[Exception] = []

        # Any: a message of any type.
        def receive(message: Any) -> None:
            try:
                if is_wanted(message):
                    came.set()
            except Exception as error:  # noqa: BLE001 -- raised again below
                failures.append(error)
                came.set()

        node.create_subscription(
            source.message_class, name, receive, source.compatible_qos(10), immediate=True
        )
        left_s = None if timeout is None else max(0.0, timeout - (time.monotonic() - begin))
        if not came.wait(left_s):
            what = "that fits came" if filter_expression else "came"
            raise _timeout_error(f"No message {what} on {name}", timeout, None)
        if failures:
            raise failures[0]
    _report(name, begin, as_json=as_json)
