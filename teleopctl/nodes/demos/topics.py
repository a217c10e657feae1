"""Demos of topics: talkers and listeners on ``chatter``."""

from __future__ import annotations

import argparse
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from rclpy.utilities import remove_ros_args
from std_msgs.msg import String

from teleopctl.nodes.demos import run

_PERIOD_S = 1.0
_RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


class Talker(Node):
    """Node that publishes ``Hello World: N`` on ``chatter`` once a second."""

    def __init__(self, name: str = "talker", qos: QoSProfile | int = 10) -> None:
        super().__init__(name)
        _log_reliability(self, qos)
        self._count = 0
        self._publisher = self.create_publisher(String, "chatter", qos)
        self._timer = self.create_timer(_PERIOD_S, self._publish_next)

    def _publish_next(self) -> None:
        message = String(data=f"Hello World: {self._count}")
        self._count += 1
        self.get_logger().info(f'Publishing: "{message.data}"')
        self._publisher.publish(message)


class Listener(Node):
    """Node that logs the messages of ``chatter``."""

    def __init__(self, name: str = "listener", qos: QoSProfile | int = 10) -> None:
        super().__init__(name)
        _log_reliability(self, qos)
        self._subscription = self.create_subscription(String, "chatter", self._on_message, qos)

    def _on_message(self, message: String) -> None:
        self.get_logger().info(f"I heard: [{message.data}]")


class SerializedSubscriber(Node):
    """Node that logs the serialized bytes of the messages of ``chatter``."""

    def __init__(self) -> None:
        super().__init__("serialized_subscriber")
        self._subscription = self.create_subscription(
            String, "chatter", self._on_message, 10, raw=True
        )

    def _on_message(self, data: bytes) -> None:
        self.get_logger().info(f'I heard: "{data!r}"')


def talker(args: list[str] | None = None) -> None:
    """Run `Talker` as ``demo_nodes_py talker`` until Ctrl-C."""
    run(Talker, args)


def listener(args: list[str] | None = None) -> None:
    """Run `Listener` as ``demo_nodes_py listener`` until Ctrl-C."""
    run(Listener, args)


def listener_serialized(args: list[str] | None = None) -> None:
    """Run `SerializedSubscriber` as ``demo_nodes_py listener_serialized`` until Ctrl-C."""
    run(SerializedSubscriber, args)


def talker_qos(args: list[str] | None = None) -> None:
    """Run `Talker` as ``talker_qos``, with the command line's reliability and number of cycles."""
    _spin_some(Talker, "talker_qos", "number of sending attempts", args)


def listener_qos(args: list[str] | None = None) -> None:
    """Run `Listener` as ``listener_qos``, with the command line's reliability and cycles."""
    _spin_some(Listener, "listener_qos", "max number of spin_once iterations", args)


def _log_reliability(node: Node, qos: QoSProfile | int) -> None:
    if isinstance(qos, QoSProfile):
        kind = "Reliable" if qos is _RELIABLE else "Best effort"
        what = "listener" if isinstance(node, Listener) else "talker"
        node.get_logger().info(f"{kind} {what}")


def _spin_some(
    node_class: type[Talker] | type[Listener], name: str, cycles: str, args: list[str] | None
) -> None:
    """Spin a node with the QoS of the command line for the number of cycles given there."""
    words = sys.argv[1:] if args is None else args
    parser = argparse.ArgumentParser(prog=name)
    parser.add_argument("--reliable", action="store_true", help="set qos profile to reliable")
    parser.add_argument(
        "-n", "--number_of_cycles", type=int, default=20, help=f"{cycles} (%(default)s)"
    )
    options = parser.parse_args(remove_ros_args(args=words))
    rclpy.init(args=words)
    node = node_class(name, _RELIABLE if options.reliable else qos_profile_sensor_data)
    try:
        for _ in range(options.number_of_cycles):
            if not rclpy.ok():
                break
            rclpy.spin_once(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end of these nodes
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
