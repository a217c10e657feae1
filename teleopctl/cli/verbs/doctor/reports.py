"""Reports on this machine and the graph that ``doctor --report`` prints."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Iterator
from importlib import metadata

from teleopctl.base.typed import NamedTuple
from teleopctl.cli.verbs.doctor.checks import qos_pairs_by_topic
from teleopctl.wire import Graph

_SMALLEST_WIDTH = 8
_BLANKS = 4


class Report(NamedTuple):
    """Report of ``doctor --report``: a title, and pairs of name and value.

    Attributes:
        title: Title of the report.
        items: Pairs of name and value, in order.
    """

    title: str
    items: list[tuple[str, str]]

    def lines(self) -> Iterator[str]:
        """Yield the lines of a report as `ros2 doctor --report` prints them."""
        yield ""
        yield f"   {self.title}"
        widest = max((len(name) for name, _ in self.items), default=0)
        width = widest + _BLANKS if widest >= _SMALLEST_WIDTH else _SMALLEST_WIDTH
        yield from (f"{name:<{width}}: {value}" for name, value in self.items)


def network_report(_: Graph) -> Report:
    """Return doctor's report on router addresses, domain ID and this machine's IPv4 addresses."""
    import psutil

    from teleopctl.wire import daemon_address, domain_id, session_config

    items = [
        ("sessions connect to", session_config("client").router.text),
        ("the daemon listens at", daemon_address().text),
        ("domain", str(domain_id())),
    ]
    for name, addresses in psutil.net_if_addrs().items():
        items += [(f"inet {name}", each.address) for each in addresses if "." in each.address]
    return Report("NETWORK CONFIGURATION", items)


def packages_report(_: Graph) -> Report:
    """Return doctor's report on the versions of teleopctl and its main dependencies."""
    names = ("teleopctl", "eclipse-zenoh", "numpy", "mujoco", "mcap", "rosbags", "viser")
    items = []
    for name in names:
        try:
            items.append((name, metadata.version(name)))
        except metadata.PackageNotFoundError:
            items.append((name, "not installed"))
    return Report("PACKAGE VERSIONS", items)


def machine_report(_: Graph) -> Report:
    """Return doctor's report on the operating system and the Python interpreter."""
    items = [
        ("system", platform.system()),
        ("platform info", platform.platform()),
        ("release", platform.release()),
        ("processor", platform.processor() or platform.machine()),
        ("python", f"{platform.python_version()} ({sys.executable})"),
    ]
    return Report("PLATFORM INFORMATION", items)


def qos_report(graph: Graph) -> Report:
    """Return doctor's report on the QoS compatibility of each publisher and subscription."""
    items: list[tuple[str, str]] = []
    for topic, pair in qos_pairs_by_topic(graph):
        items += [
            ("topic [type]", f"{topic} [{pair.publisher.type_name}]"),
            ("publisher node", pair.publisher.node),
            ("subscriber node", pair.subscription.node),
            ("compatibility status", pair.reason or "OK"),
        ]
    none = [("compatibility status", "No publisher/subscriber pairs found")]
    return Report("QOS COMPATIBILITY LIST", items or none)


def middleware_report(_: Graph) -> Report:
    """Return doctor's report on the RMW implementation that ROS 2 nodes must use to join."""
    return Report("RMW MIDDLEWARE", [("middleware name", "rmw_zenoh_cpp")])


def ros_report(_: Graph) -> Report:
    """Return doctor's report on the ROS distribution whose message definitions are used."""
    from teleopctl.interfaces import distribution

    return Report("ROS 2 INFORMATION", [("distribution name", distribution())])


def environment_report(_: Graph) -> Report:
    """Return doctor's report on the set variables of ROS 2, Zenoh and teleopctl."""
    beginnings = ("ROS_", "RMW_", "RCUTILS_", "AMENT_", "ZENOH_", "TELEOPCTL_", "MUJOCO_")
    items = [item for item in sorted(os.environ.items()) if item[0].startswith(beginnings)]
    return Report("ENVIRONMENT", items)


def topics_report(graph: Graph) -> Report:
    """Return doctor's report on the numbers of publishers and subscriptions of each topic."""
    items: list[tuple[str, str]] = []
    for topic, _ in graph.topic_names_and_types():
        items += [
            ("topic", topic),
            ("publisher count", str(len(graph.publishers(topic)))),
            ("subscriber count", str(len(graph.subscriptions(topic)))),
        ]
    none = [("topic", "none"), ("publisher count", "0"), ("subscriber count", "0")]
    return Report("TOPIC LIST", items or none)


def services_report(graph: Graph) -> Report:
    """Return doctor's report on the numbers of servers and clients of each service."""
    items: list[tuple[str, str]] = []
    for service, _ in graph.service_names_and_types():
        items += [
            ("service", service),
            ("service count", str(len(graph.servers(service)))),
            ("client count", str(len(graph.clients(service)))),
        ]
    none = [("service", "none"), ("service count", "0"), ("client count", "0")]
    return Report("SERVICE LIST", items or none)


REPORTS: dict[str, tuple[Callable[[Graph], Report], ...]] = {
    "network": (network_report,),
    "package": (packages_report,),
    "platform": (machine_report, ros_report, environment_report),
    "middleware": (middleware_report, qos_report),
    "topic": (topics_report,),
    "service": (services_report,),
}
"""Functions that make the reports of each category, in the order of printing."""
