"""The tutorial's publisher: counts aloud on ``/chatter``, once a second.

An ordinary ROS 2 source: it runs unchanged with rclpy too.
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String

PERIOD_S = 1.0


class SimplePublisher(Node):
    """Publishes ``Hello ROS 2 - counter: N`` at 1 Hz."""

    def __init__(self) -> None:
        super().__init__("simple_publisher")
        self._publisher = self.create_publisher(String, "chatter", 10)
        self._counter = 0
        self._timer = self.create_timer(PERIOD_S, self._publish)
        self.get_logger().info(f"Publishing at {1 / PERIOD_S} Hz")

    def _publish(self) -> None:
        message = String()
        message.data = f"Hello ROS 2 - counter: {self._counter}"
        self._publisher.publish(message)
        self._counter += 1


def main(args: list[str] | None = None) -> None:
    """Run the node until it is interrupted."""
    rclpy.init(args=args)
    node = SimplePublisher()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or a launch file's shutdown: the ordinary end of this node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
