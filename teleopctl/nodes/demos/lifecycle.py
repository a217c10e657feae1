"""Demo of lifecycle nodes: ``lifecycle_talker`` publishes while it is active."""

from __future__ import annotations

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import Node, Publisher, State, TransitionCallbackReturn
from rclpy.timer import Timer
from std_msgs.msg import String

_PERIOD_S = 1.0


class LifecycleTalker(Node):
    """Lifecycle node that publishes on ``lifecycle_chatter`` once a second while active.

    While the node is inactive, its lifecycle publisher drops the messages.
    """

    def __init__(self, node_name: str) -> None:
        self._count = 0
        self._publisher: Publisher[String] | None = None
        self._timer: Timer | None = None
        super().__init__(node_name)

    def on_configure(self, state: State) -> TransitionCallbackReturn:
        """Create the publisher and its timer; called on the transition ``configure``."""
        del state
        self._publisher = self.create_lifecycle_publisher(String, "lifecycle_chatter", 10)
        self._timer = self.create_timer(_PERIOD_S, self._publish)
        self.get_logger().info("on_configure() is called.")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: State) -> TransitionCallbackReturn:
        """Log, and enable the publisher by the base class; called on ``activate``."""
        self.get_logger().info("on_activate() is called.")
        return super().on_activate(state)

    def on_deactivate(self, state: State) -> TransitionCallbackReturn:
        """Log, and disable the publisher by the base class; called on ``deactivate``."""
        self.get_logger().info("on_deactivate() is called.")
        return super().on_deactivate(state)

    def on_cleanup(self, state: State) -> TransitionCallbackReturn:
        """Destroy the publisher and its timer; called on the transition ``cleanup``."""
        del state
        self._destroy_publisher()
        self.get_logger().info("on_cleanup() is called.")
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: State) -> TransitionCallbackReturn:
        """Destroy the publisher and its timer; called on the transition ``shutdown``."""
        del state
        self._destroy_publisher()
        self.get_logger().info("on_shutdown() is called.")
        return TransitionCallbackReturn.SUCCESS

    def _publish(self) -> None:
        message = String(data=f"Lifecycle HelloWorld #{self._count}")
        self._count += 1
        if self._publisher is None or not self._publisher.is_activated:
            self.get_logger().info("Lifecycle publisher is inactive. Messages are not published.")
        else:
            self.get_logger().info(f"Lifecycle publisher is active. Publishing: [{message.data}]")
        if self._publisher is not None:
            self._publisher.publish(message)

    def _destroy_publisher(self) -> None:
        if self._timer is not None:
            self.destroy_timer(self._timer)
        if self._publisher is not None:
            self.destroy_publisher(self._publisher)
        self._timer = self._publisher = None


def lifecycle_talker(args: list[str] | None = None) -> None:
    """Run the lifecycle node ``lc_talker``, which publishes while active, until Ctrl-C."""
    rclpy.init(args=args)
    node = LifecycleTalker("lc_talker")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end of this node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
