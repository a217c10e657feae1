"""``ros2topic.api``. Topics of the graph, and their message classes."""

import argparse
import copy
import time
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPresetProfiles,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.validate_full_topic_name import validate_full_topic_name
from rosidl_runtime_py import get_message_interfaces
from rosidl_runtime_py.utilities import get_message

from teleopctl.errors import TeleopctlError

__all__ = [
    "add_qos_arguments",
    "get_msg_class",
    "get_topic_names",
    "get_topic_names_and_types",
    "message_type_completer",
    "positive_float",
    "positive_int",
    "profile_configure_short_keys",
    "qos_profile_from_short_keys",
]

_LOOK_PERIOD_S = 0.1


def positive_int(string: str) -> int:
    """Return a positive integer of a command line.

    Raises:
        ArgumentTypeError: The text is none.
    """
    try:
        value = int(string)
    except ValueError:
        value = -1
    if value <= 0:
        raise argparse.ArgumentTypeError("value must be a positive integer")
    return value


def positive_float(inval: str) -> float:
    """Return a positive number of a command line.

    Raises:
        ArgumentTypeError: The text is none.
    """
    try:
        value = float(inval)
    except ValueError:
        raise argparse.ArgumentTypeError("Expects a floating point number") from None
    if not value > 0.0:
        raise argparse.ArgumentTypeError("Value must be positive")
    return value


# Any, here and below: a Node, or a node of ros2cli; a message class.


def get_topic_names_and_types(
    *, node: Any, include_hidden_topics: bool = False
) -> list[tuple[str, list[str]]]:
    """Return the topics of the graph with their types."""
    return [
        (name, types)
        for name, types in node.get_topic_names_and_types()
        if include_hidden_topics or not topic_or_service_is_hidden(name)
    ]


def get_topic_names(*, node: Any, include_hidden_topics: bool = False) -> list[str]:
    """Return the names of the topics of the graph."""
    found = get_topic_names_and_types(node=node, include_hidden_topics=include_hidden_topics)
    return [name for name, _ in found]


def message_type_completer(**_: object) -> list[str]:
    """Return the names of all message types."""
    return [
        f"{package}/{name}"
        for package, names in sorted(get_message_interfaces().items())
        for name in sorted(names)
    ]


def get_msg_class(
    node: Any, topic: str, blocking: bool = False, include_hidden_topics: bool = False
) -> Any:
    """Return the class of a topic's messages; None for a topic without publishers.

    Args:
        node: Node for the queries of the graph.
        topic: Name of the topic, relative to the node.
        blocking: Whether to wait until the topic is in the graph.
        include_hidden_topics: Whether to find hidden topics.

    Raises:
        RuntimeError: The name is invalid, or the topic has several types or an unknown one.
    """
    found = _message_class(node, topic, include_hidden_topics)
    if found is None:
        print(f"WARNING: topic [{topic}] does not appear to be published yet")  # noqa: T201 -- ros2topic does
    while blocking and found is None and rclpy.ok():
        time.sleep(_LOOK_PERIOD_S)
        found = _message_class(node, topic, include_hidden_topics)
    return found


def _message_class(node: Any, topic: str, include_hidden: bool) -> Any:
    try:
        full_name = expand_topic_name(topic, node.get_name(), node.get_namespace())
        validate_full_topic_name(full_name)
    except (ValueError, InvalidTopicNameException) as error:
        raise RuntimeError(str(error)) from error
    known = dict(get_topic_names_and_types(node=node, include_hidden_topics=include_hidden))
    types = known.get(full_name)
    if types is None:
        return None
    if len(types) > 1:
        listed = ", ".join(types)
        raise RuntimeError(
            f"Cannot echo topic '{topic}', as it contains more than one type: [{listed}]"
        )
    try:
        return get_message(types[0])
    except (AttributeError, ModuleNotFoundError, ValueError, TeleopctlError) as error:
        raise RuntimeError(f"The message type '{types[0]}' is invalid") from error


def profile_configure_short_keys(
    profile: QoSProfile,
    reliability: str | None = None,
    durability: str | None = None,
    depth: int | None = None,
    history: str | None = None,
    liveliness: str | None = None,
    liveliness_lease_duration_s: float | None = None,
) -> None:
    """Change policies of a QoS profile, given by names such as ``best_effort``."""
    if history:
        profile.history = HistoryPolicy.get_from_short_key(history)
    if durability:
        profile.durability = DurabilityPolicy.get_from_short_key(durability)
    if reliability:
        profile.reliability = ReliabilityPolicy.get_from_short_key(reliability)
    if liveliness:
        profile.liveliness = LivelinessPolicy.get_from_short_key(liveliness)
    if liveliness_lease_duration_s and liveliness_lease_duration_s >= 0:
        profile.liveliness_lease_duration = Duration(seconds=liveliness_lease_duration_s)
    if depth and depth >= 0:
        profile.depth = depth
    elif profile.durability == DurabilityPolicy.TRANSIENT_LOCAL and profile.depth == 0:
        profile.depth = 1


def qos_profile_from_short_keys(
    preset_profile: str,
    reliability: str | None = None,
    durability: str | None = None,
    depth: int | None = None,
    history: str | None = None,
    liveliness: str | None = None,
    liveliness_lease_duration_s: float | None = None,
) -> QoSProfile:
    """Return a QoS profile by the name of a preset, with some policies changed."""
    profile = copy.copy(QoSPresetProfiles.get_from_short_key(preset_profile))
    profile_configure_short_keys(
        profile, reliability, durability, depth, history, liveliness, liveliness_lease_duration_s
    )
    return profile


def add_qos_arguments(
    parser: argparse.ArgumentParser, subscribe_or_publish: str, default_profile_str: str
) -> None:
    """Add the options of a QoS profile to a command line.

    Args:
        parser: Parser of the command line.
        subscribe_or_publish: What the profile is for, in the help.
        default_profile_str: Name of the default preset.
    """
    parser.add_argument(
        "--qos-profile",
        choices=QoSPresetProfiles.short_keys(),
        default=default_profile_str,
        help=f"QoS preset to {subscribe_or_publish} with (default: {default_profile_str})",
    )
    parser.add_argument("--qos-depth", metavar="N", type=int, help="Depth of the history.")
    for name, policy in (
        ("history", HistoryPolicy),
        ("reliability", ReliabilityPolicy),
        ("durability", DurabilityPolicy),
        ("liveliness", LivelinessPolicy),
    ):
        parser.add_argument(
            f"--qos-{name}", choices=policy.short_keys(), help=f"The policy {name} of the profile."
        )
    parser.add_argument(
        "--qos-liveliness-lease-duration-seconds",
        type=float,
        help="Lease duration of the liveliness.",
    )
