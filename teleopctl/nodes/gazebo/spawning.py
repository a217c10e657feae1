"""Executables ``create`` and ``remove`` of ros_gz_sim, and ``spawn_entity.py`` of gazebo_ros."""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from teleopctl.base import progress
from teleopctl.base.files import read_text
from teleopctl.errors import TeleopctlError, UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import (
    AsyncParameterClient,
    ExternalShutdownException,
    Node,
    Parameter,
    init,
    parse_ros_arguments,
    qos_profile_latched,
    spin,
    spin_once,
    spin_until_future_complete,
)
from teleopctl.nodes.argument_parser import ArgumentParser
from teleopctl.nodes.gazebo.entities import GazeboEntity
from teleopctl.nodes.gazebo.server import NAME
from teleopctl.robot import find_world

_NUMBERS = ("x", "y", "z", "R", "P", "Y")
_TEXTS = ("world", "file", "string", "topic", "name")
_NO = ("false", "f", "no", "n", "0")
# Period of the log lines while waiting, in seconds, as in the programs of ROS.
_TIMEOUT_S = 1.0


def create() -> int:
    """Run ``ros_gz_sim create``: spawn an entity by the node ``gazebo``; return the exit status.

    Raises:
        TeleopctlError: The command line, the file or the description is wrong.
    """
    parser = ArgumentParser(
        prog="create", description="Put a robot into the simulator.", allow_abbrev=False
    )
    source = parser.add_argument_group("source of the description")
    for name in ("file", "param", "string", "topic"):
        source.add_argument(f"-{name}", f"--{name}", default="")
    for name in ("name", "world"):
        parser.add_argument(f"-{name}", f"--{name}", default="")
    # A flag, or an option with a value: `-allow_renaming true`.
    parser.add_argument("-allow_renaming", "--allow_renaming", nargs="?", default="false")
    _add_pose(parser)
    options, unknown = parser.parse_known_args(_words())
    with _node("ros_gz_sim") as node:
        for name in _TEXTS:
            value = node.declare_parameter(name, "").value
            setattr(options, name, value or getattr(options, name))
        renames = node.declare_parameter("allow_renaming", False).value
        for name in _NUMBERS:
            value = node.declare_parameter(name, 0.0).value
            setattr(options, name, value or getattr(options, name))
        entity = _entity(node, options, options.name)
        if entity is None:
            node.get_logger().error("Must specify either -file, -param, -string or -topic")
            return 255
        _warn_unserved(
            node,
            [
                *_written(options, "world"),
                *filter(None, [" ".join(unknown)]),
            ],
        )
        # The flag may have no value, or any of gflags' words for false.
        renames = renames or str(options.allow_renaming).lower() not in _NO
        reason = _send_entity(node, entity._replace(renames=renames))
        if reason is None:
            node.get_logger().info("Entity creation successfull.")
            return 0
        node.get_logger().error(f"Entity creation failed.\n {reason}")
        return 1
    return 0


def spawn_entity() -> int:
    """Run ``spawn_entity.py``: spawn an entity by the node ``gazebo``; return the exit status.

    Raises:
        TeleopctlError: The command line, the file or the description is wrong.
    """
    parser = ArgumentParser(prog="spawn_entity.py", description="Put a robot into the simulator.")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("-file", default="")
    source.add_argument("-topic", default="")
    source.add_argument("-stdin", action="store_true")
    source.add_argument("-database", default="")
    parser.add_argument("-entity", required=True)
    for name in ("reference_frame", "gazebo_namespace", "robot_namespace", "wait"):
        parser.add_argument(f"-{name}", default="")
    parser.add_argument("-timeout", type=float, default=30.0)
    parser.add_argument("-spawn_service_timeout", type=float)
    for flag in ("unpause", "package_to_model", "b"):
        parser.add_argument(f"-{flag}", action="store_true")
    _add_pose(parser)
    options = parser.parse_args(_words())
    if options.database:
        raise UsageError("-database: there is no model database", hint="Give -file or -topic.")
    options.param = options.string = ""
    with _node("spawn_entity") as node:
        node.get_logger().info("Spawn Entity started")
        if options.stdin:
            options.string = sys.stdin.read()
        entity = _entity(node, options, options.entity) or GazeboEntity()
        unserved = _written(options, "reference_frame", "robot_namespace", "wait")
        _warn_unserved(node, [*unserved, *(["-b"] if options.b else [])])
        namespace = options.gazebo_namespace.rstrip("/")
        timeout_s = options.timeout
        if options.spawn_service_timeout is not None:
            node.get_logger().warning(
                "'-spawn_service_timeout' is deprecated, use '-timeout' instead"
            )
            timeout_s = options.spawn_service_timeout
        reason = _send_entity(node, entity, namespace, timeout_s)
        if reason is None:
            text = f"SpawnEntity: Successfully spawned entity [{options.entity}]"
            node.get_logger().info(f"Spawn status: {text}")
            if options.unpause:
                _set(node, "/mujoco_sim", [Parameter("paused", value=False)])
            if options.b:
                spin(node)
            return 0
        node.get_logger().error(f"Spawn status: {reason}")
        node.get_logger().error("Spawn service failed. Exiting.")
        return 1
    return 0


def remove() -> int:
    """Run ``ros_gz_sim remove``: delete an entity by the node ``gazebo``; return the status."""
    with _node("ros_gz_sim_remove_entity") as node:
        world = node.declare_parameter("world", "").value
        _warn_unserved(node, [f"world {world}"] if world else [])
        name = str(node.declare_parameter("entity_name", "").value)
        if not name:
            node.get_logger().info(
                "Entity to remove name is not provided, entity will not be removed."
            )
            return 255
        reason = _send_entity(node, GazeboEntity(name=name))
        if reason is None:
            node.get_logger().info("Entity removal successful.")
            return 0
        node.get_logger().error(f"Entity removal failed.\n {reason}")
        return 1
    return 0


def _add_pose(parser: argparse.ArgumentParser) -> None:
    pose = parser.add_argument_group("initial pose, in metres and radians")
    for name in _NUMBERS:
        pose.add_argument(f"-{name}", f"--{name}", type=float, default=0.0)


def _words() -> Sequence[str]:
    return parse_ros_arguments(sys.argv[1:]).program


@contextlib.contextmanager
def _node(name: str) -> Any:
    progress.report(progress.STARTING)
    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(),
        Node(name) as node,
    ):
        yield node


def _entity(node: Node, options: argparse.Namespace, name: str) -> GazeboEntity | None:
    """Return the entity to spawn, read from the source in the options; None without a source."""
    there = GazeboEntity(name=name, pose=tuple(float(getattr(options, key)) for key in _NUMBERS))
    if options.file:
        node.get_logger().info(f"Loading entity XML from file {options.file}")
        file = find_world(options.file, Path.cwd())
        return there._replace(text=read_text(file), file=str(file))
    if options.param:
        return there._replace(text=str(node.declare_parameter(options.param, "").value))
    if options.string:
        return there._replace(text=str(options.string))
    if options.topic:
        topic = node.resolve_topic_name(options.topic)
        return there._replace(text=_receive_text(node, options.topic), topic=topic)
    return None


def _receive_text(node: Node, topic: str) -> str:
    received: list[str] = []
    node.create_subscription(
        get_message("std_msgs/msg/String"),
        topic,
        lambda message: received.append(message.data),
        qos_profile_latched,
    )
    while not received:
        node.get_logger().info(f"Waiting messages on topic [{topic}].")
        spin_once(node, timeout_sec=_TIMEOUT_S)
    return received[0]


def _warn_unserved(node: Node, words: Sequence[str]) -> None:
    if words:
        node.get_logger().warning(f"Without effect, there is a single world: {', '.join(words)}")


def _written(options: argparse.Namespace, *names: str) -> list[str]:
    values = ((name, getattr(options, name)) for name in names)
    return [f"-{name} {value}" for name, value in values if value]


def _send_entity(
    node: Node, entity: GazeboEntity, namespace: str = "", timeout_s: float = math.inf
) -> str | None:
    """Set an entity as parameters of the node ``gazebo``; without a description, delete it.

    Returns:
        Reason of a failure, or None.
    """
    return _set(node, f"{namespace}/{NAME}", entity.as_parameters(), timeout_s)


def _set(
    node: Node, target: str, parameters: list[Parameter], timeout_s: float = math.inf
) -> str | None:
    """Set parameters of a node atomically; return the reason of a failure, or None."""
    simulator = AsyncParameterClient(node, target)
    deadline = time.monotonic() + timeout_s
    while not simulator.wait_for_services(min(_TIMEOUT_S, timeout_s)):
        if time.monotonic() >= deadline:
            return f"there is no simulator, node {target}, after {timeout_s:g} s"
        node.get_logger().info(f"Waiting for the simulator, node {target}")
    future = simulator.set_parameters_atomically(parameters)
    while not future.ended():
        spin_until_future_complete(node, future, timeout_sec=_TIMEOUT_S)
        if not future.ended() and target not in node.get_fully_qualified_node_names():
            return "the simulator has ended"
    try:
        response = future.result()
    except TeleopctlError as error:
        return error.message
    assert response is not None
    return None if response.result.successful else str(response.result.reason)
