"""Checks of the router, this machine, the graph and the clocks of its machines."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.cli.verbs.doctor.findings import Finding, warning
from teleopctl.errors import TeleopctlError
from teleopctl.wire import (
    EndpointToken,
    EntityKind,
    Graph,
    decode_attachment,
    encode_attachment,
    open_session,
    topic_key,
)

if TYPE_CHECKING:
    import zenoh

    from teleopctl.cli.verbs.topic.endpoints import QosPair


def check_router() -> Iterator[Finding]:
    """Yield faults of the router: not running, port taken, open to the network, wrong address."""
    from teleopctl.wire import (
        HOW_TO_CLOSE,
        daemon_address,
        port_holder,
        router_is_running,
        router_reach,
        session_config,
    )

    try:
        sessions, daemon = session_config("client").router, daemon_address()
        is_there = router_is_running(sessions)
    except TeleopctlError as error:
        yield Finding(error.message, error.hint or "")
        return
    if is_there:
        danger = router_reach(sessions).danger
        if danger is not None:
            yield warning(danger, HOW_TO_CLOSE)
    else:
        holder = port_holder(sessions)
        if holder is None:
            yield Finding(
                f"No router answers at {sessions}: nodes cannot discover each other.",
                "Start it with `teleopctl daemon start`; nodes and launches start it themselves."
                if daemon.serves(sessions)
                else "Start it there.",
            )
        else:
            port, name = holder
            yield Finding(
                f"Port {port} is taken by {name}, which does not answer as a Zenoh router.",
                f"End that program, or use another port: TELEOPCTL_ROUTER=tcp/HOST:{port + 1}",
            )
    if daemon.is_missed_by(sessions):
        yield warning(
            f"The daemon would listen at {daemon}, sessions connect to {sessions}.",
            "Their nodes do not discover each other unless the routers are connected.",
        )


# Run in a child process, since unsuitable graphics drivers end the process that loads them.
_DRAW = """
import sys
from teleopctl.errors import TeleopctlError
from teleopctl.sim import check_drawing, choose_backend
try:
    choose_backend()
    check_drawing()
except TeleopctlError as error:
    sys.exit(f"{error.message}\\n{error.hint or ''}")
"""


def check_packages() -> Iterator[Finding]:
    """Yield a warning for each ROS package whose manifest cannot be read."""
    from teleopctl.packages import faults_of_search, list_packages

    list_packages()
    yield from map(warning, faults_of_search())


def check_drawing() -> Iterator[Finding]:
    """Yield a warning with the reason if cameras cannot be rendered on this machine."""
    tried = subprocess.run(
        [sys.executable, "-P", "-c", _DRAW], capture_output=True, text=True, check=False
    )
    if tried.returncode != 0:
        text, _, hint = tried.stderr.strip().partition("\n")
        if tried.returncode < 0:
            text = f"Drawing ends a process by signal {-tried.returncode}"
        yield warning(f"{text}; cameras will have no pictures.", hint)


def check_shared_memory() -> Iterator[Finding]:
    """Yield a warning if there is too little shared memory for pictures."""
    from teleopctl.wire import has_room_for_shared_memory

    if not has_room_for_shared_memory():
        yield warning(
            "/dev/shm has little room: pictures are copied between processes.",  # noqa: S108
            "In a container: docker run --shm-size=1g …",
        )


def check_environment() -> Iterator[Finding]:
    """Yield findings for an RMW other than Zenoh, and an invalid domain or distribution."""
    asked = os.environ.get("RMW_IMPLEMENTATION", "")
    if asked not in ("", "rmw_zenoh_cpp"):
        yield warning(
            f"RMW_IMPLEMENTATION={asked}: ROS 2 nodes that use it do not discover the nodes "
            "of teleopctl.",
            "Start them with RMW_IMPLEMENTATION=rmw_zenoh_cpp.",
        )
    try:
        from teleopctl.interfaces import known_types
        from teleopctl.wire import domain_id

        domain_id()
        known_types()
    except TeleopctlError as error:
        yield Finding(error.message, error.hint or "")


# Topics that often have only publishers or only subscriptions.
_OFTEN_ALONE = {"/parameter_events", "/rosout"}


def check_topics(graph: Graph) -> Iterator[Finding]:
    """Yield a warning for each topic that has only publishers or only subscriptions."""
    for topic, _ in graph.topic_names_and_types():
        if topic in _OFTEN_ALONE:
            continue
        publishers, subscriptions = graph.publishers(topic), graph.subscriptions(topic)
        if publishers and not subscriptions:
            yield warning(f"Publisher without subscriber detected on {topic}.")
        elif subscriptions and not publishers:
            yield warning(f"Subscriber without publisher detected on {topic}.")


def check_nodes(graph: Graph) -> Iterator[Finding]:
    """Yield an error for each name that several nodes have."""
    for name, count in Counter(graph.node_names()).items():
        if count > 1:
            yield Finding(
                f"{count} nodes are called {name}: calls to their services and parameters are "
                "ambiguous.",
                f"Give each a unique name: --ros-args -r __node:={name.rsplit('/', 1)[1]}_2",
            )


def check_types(graph: Graph) -> Iterator[Finding]:
    """Yield an error for each topic or service with several types or type hashes."""
    for word, names, ends in (
        ("topic", graph.topic_names_and_types(), (graph.publishers, graph.subscriptions)),
        ("service", graph.service_names_and_types(), (graph.servers, graph.clients)),
    ):
        for name, types in names:
            endpoints = [endpoint for end in ends for endpoint in end(name)]
            # Simulators offer services of two types under one name: Gazebo's and the standard's.
            is_served = word == "service" and all(graph.servers(name, each) for each in types)
            if len(types) > 1 and not is_served:
                yield Finding(
                    f"The {word} {name} has several types: {', '.join(types)}. "
                    f"{_by(endpoints, lambda endpoint: endpoint.type_name)}",
                    "Endpoints of different types do not communicate: rename one topic.",
                )
            for type_name in types:
                alike = [each for each in endpoints if each.type_name == type_name]
                # ROS 2 before Jazzy has no type hashes, and receives messages of any hash.
                hashed = [each for each in alike if each.type_hash.startswith("RIHS")]
                if len({endpoint.type_hash for endpoint in hashed}) > 1:
                    yield Finding(
                        f"The {word} {name} has definitions of {type_name} that differ. "
                        f"{_by(hashed, lambda endpoint: endpoint.type_hash[:14] + '…')}",
                        "Build all with the same version of that package.",
                    )


def _by(endpoints: Sequence[EndpointToken], value: Callable[[EndpointToken], str]) -> str:
    """Return a text that lists the nodes of each value."""
    nodes: dict[str, set[str]] = {}
    for endpoint in endpoints:
        nodes.setdefault(value(endpoint), set()).add(endpoint.full_name)
    return "; ".join(f"{key}: {', '.join(sorted(names))}" for key, names in sorted(nodes.items()))


def check_qos(graph: Graph) -> Iterator[Finding]:
    """Yield a warning for each pair of publisher and subscription with QoS that may not match."""
    from teleopctl.cli.verbs.topic.endpoints import ON_ZENOH
    from teleopctl.node import QoSCompatibility

    for topic, pair in qos_pairs_by_topic(graph):
        if pair.verdict is not QoSCompatibility.OK:
            kind = "error" if pair.verdict is QoSCompatibility.ERROR else "warning"
            yield warning(
                f"QoS compatibility {kind} found on topic '{topic}': "
                f"{pair.publisher.full_name} and {pair.subscription.full_name}: {pair.reason}",
                ON_ZENOH,
            )


def qos_pairs_by_topic(graph: Graph) -> Iterator[tuple[str, QosPair]]:
    """Yield the topic and QoS compatibility of each pair of publisher and subscription."""
    from teleopctl.cli.verbs.topic.endpoints import qos_pairs

    for topic, _ in graph.topic_names_and_types():
        for pair in qos_pairs(graph.publishers(topic), graph.subscriptions(topic)):
            yield topic, pair


def parameter_service_by_session(graph: Graph) -> dict[str, EndpointToken]:
    """Return one get_parameters server of each Zenoh session, by session ID."""
    found: dict[str, EndpointToken] = {}
    for name, _ in graph.service_names_and_types(include_hidden=True):
        if name.endswith("/get_parameters"):
            for server in graph.servers(name):
                if server.kind is EntityKind.SS:
                    found.setdefault(server.zid, server)
    return found


_ANSWER_WITHIN_S = 1.0
# A larger offset makes tf reject transforms as too new or too old in lookups for the present time.
_LARGEST_OFFSET_NS = 10_000_000
_NOBODY = bytes(16)


def check_clocks(graph: Graph) -> Iterator[Finding]:
    """Yield an error for each Zenoh session with a clock over 10 ms off this machine's."""
    with open_session("client") as session:
        for server in parameter_service_by_session(graph).values():
            measured = _offset_ns(session, server)
            if measured is not None and abs(measured[0]) > _LARGEST_OFFSET_NS + measured[1]:
                ahead = "ahead of" if measured[0] > 0 else "behind"
                yield Finding(
                    f"The clock of {server.full_name} is {abs(measured[0]) / 1e9:.3f} s {ahead} "
                    "this machine's: its transforms and stamps seem to be old or in the future.",
                    "Synchronise the machines, with chrony for one.",
                )


def _offset_ns(session: zenoh.Session, server: EndpointToken) -> tuple[int, int] | None:
    """Return the offset of a server's clock from this clock and its uncertainty, or None."""
    from teleopctl.interfaces import get_service, serialize

    request = get_service(server.type_name).Request()
    key = topic_key(server.domain, server.name, server.type_name, server.type_hash)
    asked_ns = time.time_ns()
    replies = session.get(
        key,
        payload=serialize(request),
        attachment=encode_attachment(1, asked_ns, _NOBODY),
        timeout=_ANSWER_WITHIN_S,
    )
    for reply in replies:
        answered_ns = time.time_ns()
        if reply.ok is None or reply.ok.attachment is None:
            continue
        attachment = decode_attachment(reply.ok.attachment.to_bytes())
        if attachment is not None:
            middle_ns = (asked_ns + answered_ns) // 2
            return attachment.time_ns - middle_ns, (answered_ns - asked_ns) // 2
    return None
