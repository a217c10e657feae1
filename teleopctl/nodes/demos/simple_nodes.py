"""Programs of this project's tutorial: ``simple_parameter``, ``_publisher`` and ``_subscriber``."""

from __future__ import annotations

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import String

from teleopctl.nodes.demos import run

_PERIOD_S = 1.0


class SimpleParameter(Node):
    """Node that declares two parameters and logs their changes."""

    def __init__(self) -> None:
        super().__init__("simple_parameter")
        self.declare_parameter("simple_int_param", 28)
        self.declare_parameter("simple_string_param", "Antonio")
        self.add_on_set_parameters_callback(self._on_change)

    def _on_change(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            self.get_logger().info(
                f"Param {parameter.name} changed! New value is {parameter.value}"
            )
        return SetParametersResult(successful=True)


class SimplePublisher(Node):
    """Node that publishes ``Hello ROS 2 - counter: N`` on ``chatter`` at 1 Hz."""

    def __init__(self) -> None:
        super().__init__("simple_publisher")
        self._publisher = self.create_publisher(String, "chatter", 10)
        self._counter = 0
        self._timer = self.create_timer(_PERIOD_S, self._publish)
        self.get_logger().info(f"Publishing at {1 / _PERIOD_S} Hz")

    def _publish(self) -> None:
        message = String()
        message.data = f"Hello ROS 2 - counter: {self._counter}"
        self._publisher.publish(message)
        self._counter += 1


class SimpleSubscriber(Node):
    """Node that logs each string of ``chatter``."""

    def __init__(self) -> None:
        super().__init__("simple_subscriber")
        self._subscription = self.create_subscription(String, "chatter", self._on_message, 10)

    def _on_message(self, message: String) -> None:
        self.get_logger().info(f"I heard: {message.data}")


def simple_parameter(args: list[str] | None = None) -> None:
    """Run the node ``simple_parameter`` until Ctrl-C: it logs changes of its parameters."""
    run(SimpleParameter, args)


def simple_publisher(args: list[str] | None = None) -> None:
    """Run the node ``simple_publisher`` until Ctrl-C: it publishes strings on ``chatter``."""
    run(SimplePublisher, args)


def simple_subscriber(args: list[str] | None = None) -> None:
    """Run the node ``simple_subscriber`` until Ctrl-C: it logs the strings of ``chatter``."""
    run(SimpleSubscriber, args)
