"""Demo of the logger service: a node changes another node's log level."""

from __future__ import annotations

import time

import rclpy
from rcl_interfaces.msg import LoggerLevel
from rcl_interfaces.srv import GetLoggerLevels, SetLoggerLevels
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from std_msgs.msg import String

from teleopctl.node import spin_in_thread

_NAME = "LoggerServiceNode"
# Time for the other node to log the received message.
_PAUSE_S = 0.5
_LONGEST_WAIT_S = 10.0


class LoggerServiceNode(Node):
    """Node that logs each message of ``output`` at four levels, and has a logger service."""

    def __init__(self) -> None:
        super().__init__(_NAME, enable_logger_service=True)
        self._subscription = self.create_subscription(String, "output", self._on_message, 10)

    def _on_message(self, message: String) -> None:
        logger = self.get_logger()
        logger.debug(f"{message.data} with DEBUG logger level.")
        logger.info(f"{message.data} with INFO logger level.")
        logger.warning(f"{message.data} with WARN logger level.")
        logger.error(f"{message.data} with ERROR logger level.")


class TestNode(Node):
    """Node that sets the logger level of `LoggerServiceNode`, and publishes on ``output``."""

    __test__ = False  # not a test class of pytest

    def __init__(self) -> None:
        super().__init__("TestNode")
        self.publisher = self.create_publisher(String, "output", 10)
        self._get = self.create_client(GetLoggerLevels, f"{_NAME}/get_logger_levels")
        self._set = self.create_client(SetLoggerLevels, f"{_NAME}/set_logger_levels")

    def wait_for_services(self) -> None:
        """Wait up to 10 s for each of the two logger services of `LoggerServiceNode`."""
        self._get.wait_for_service(_LONGEST_WAIT_S)
        self._set.wait_for_service(_LONGEST_WAIT_S)

    def output(self, number: int) -> None:
        """Publish a numbered message on ``output``, and wait half a second for the log lines."""
        self.publisher.publish(String(data=f"Output {number}"))
        time.sleep(_PAUSE_S)

    def set_level(self, level: LoggingSeverity) -> bool:
        """Set the logger level of `LoggerServiceNode`; return whether that succeeded."""
        request = SetLoggerLevels.Request(levels=[LoggerLevel(name=_NAME, level=int(level))])
        future = self._set.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        response = future.result()
        if response is None:
            return False
        result = response.results[0]
        if not result.successful:
            self.get_logger().error(f"Failed to change logger level: {result.reason}")
        return bool(result.successful)

    def log_level(self) -> None:
        """Request and log the present logger level of `LoggerServiceNode`."""
        future = self._get.call_async(GetLoggerLevels.Request(names=[_NAME]))
        rclpy.spin_until_future_complete(self, future)
        response = future.result()
        if response is None:
            self.get_logger().error("Failed to get logger level via logger service !")
        else:
            self.get_logger().info(f"Current logger level: {response.levels[0].level}")


def use_logger_service(args: list[str] | None = None) -> None:
    """Run the demo ``use_logger_service``: set another node's log level, and show the effect."""
    rclpy.init(args=args)
    executor = SingleThreadedExecutor()
    other, node = LoggerServiceNode(), TestNode()
    executor.add_node(other)
    thread = spin_in_thread(executor)
    try:
        node.wait_for_services()
        _demonstrate(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C before the end
    finally:
        executor.shutdown()
        thread.join()
        other.destroy_node()
        node.destroy_node()
        rclpy.try_shutdown()


def _demonstrate(node: TestNode) -> None:
    say = node.get_logger()
    say.info("Output with default logger level:")
    node.output(1)
    node.log_level()
    levels = (LoggingSeverity.DEBUG, LoggingSeverity.WARN, LoggingSeverity.ERROR)
    for number, level in enumerate(levels, start=2):
        name = level.name.lower()
        say.info(f"Output with {name} logger level:")
        if node.set_level(level):
            node.output(number)
        else:
            say.error(f"Failed to set {name} logger level via logger service !")
        node.log_level()
