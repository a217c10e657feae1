"""Components of ROS 2's ``composition`` tutorial, and ``demo_nodes_cpp``'s talker and listener."""

from __future__ import annotations

from example_interfaces.srv import AddTwoInts
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import String

from teleopctl.nodes.demos import run

_TALK_EVERY_S = 1.0
_ASK_EVERY_S = 2.0


class TalkerComponent(Node):
    """Component that publishes ``Hello World: N`` on ``chatter`` once a second."""

    def __init__(self) -> None:
        super().__init__("talker")
        self._count = 0
        self._publisher = self.create_publisher(String, "chatter", 10)
        self._timer = self.create_timer(_TALK_EVERY_S, self._publish_next)

    def _publish_next(self) -> None:
        self._count += 1
        message = String(data=f"Hello World: {self._count}")
        self.get_logger().info(f"Publishing: '{message.data}'")
        self._publisher.publish(message)


class ListenerComponent(Node):
    """Component that logs the messages of ``chatter``."""

    def __init__(self) -> None:
        super().__init__("listener")
        self._subscription = self.create_subscription(String, "chatter", self._on_message, 10)

    def _on_message(self, message: String) -> None:
        self.get_logger().info(f"I heard: [{message.data}]")


class ServerComponent(Node):
    """Component that serves ``add_two_ints``: returns the sum, and logs each request."""

    def __init__(self) -> None:
        super().__init__("Server")
        self._service = self.create_service(AddTwoInts, "add_two_ints", self._add)

    def _add(
        self, request: AddTwoInts.Request, response: AddTwoInts.Response
    ) -> AddTwoInts.Response:
        self.get_logger().info(f"Incoming request: [a: {request.a}, b: {request.b}]")
        response.sum = request.a + request.b
        return response


class ClientComponent(Node):
    """Component that calls ``add_two_ints`` with 2 and 3 every two seconds, and logs the sum."""

    def __init__(self) -> None:
        super().__init__("Client")
        self._client = self.create_client(AddTwoInts, "add_two_ints")
        self._timer = self.create_timer(_ASK_EVERY_S, self._call)

    def _call(self) -> None:
        if not self._client.service_is_ready():
            self.get_logger().info("Service not available after waiting")
            return
        self._client.call_async(AddTwoInts.Request(a=2, b=3)).add_done_callback(self._log_result)

    def _log_result(self, future: Future[AddTwoInts.Response]) -> None:
        response = future.result()
        if response is not None:
            self.get_logger().info(f"Got result: [{response.sum}]")


def talker(args: list[str] | None = None) -> None:
    """Run `TalkerComponent` as ``demo_nodes_cpp talker`` until Ctrl-C."""
    run(TalkerComponent, args)


def listener(args: list[str] | None = None) -> None:
    """Run `ListenerComponent` as ``demo_nodes_cpp listener`` until Ctrl-C."""
    run(ListenerComponent, args)
