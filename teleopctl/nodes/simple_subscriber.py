"""The tutorial's subscriber: says what it hears on ``/chatter``.

An ordinary ROS 2 source: it runs unchanged with rclpy too.
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String


class SimpleSubscriber(Node):
    """Logs each received string."""

    def __init__(self) -> None:
        super().__init__("simple_subscriber")
        self._subscription = self.create_subscription(String, "chatter", self._hear, 10)

    def _hear(self, message: String) -> None:
        self.get_logger().info(f"I heard: {message.data}")


def main(args: list[str] | None = None) -> None:
    """Run the node until it is interrupted."""
    rclpy.init(args=args)
    node = SimpleSubscriber()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C or a launch file's shutdown: the ordinary end of this node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
