"""The programs of ``examples_rclpy_*`` for topics, services, executors and guard conditions.

ROS 2 has the same publisher, subscriber, service and client in several styles of code; the programs
of one kind do the same, and are one program here.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2, PointField
from sensor_msgs_py import point_cloud2
from std_msgs.msg import Header, String

from teleopctl.nodes.demos import run

_PERIOD_S = 0.5
_WAIT_S = 1.0
_A, _B = 41, 1


class MinimalPublisher(Node):
    """Node that publishes ``Hello World: N`` at periods.

    Args:
        name: Name of the node.
        topic: Topic to publish on.
        periods_s: Period of each of its timers, s.
    """

    def __init__(
        self,
        name: str = "minimal_publisher",
        topic: str = "topic",
        periods_s: tuple[float, ...] = (_PERIOD_S,),
    ) -> None:
        super().__init__(name)
        self._count = 0
        self._publisher = self.create_publisher(String, topic, 10)
        for period_s in periods_s:
            self.create_timer(period_s, self._publish)

    def _publish(self) -> None:
        message = String(data=f"Hello World: {self._count}")
        self._count += 1
        self._publisher.publish(message)
        self.get_logger().info(f'Publishing: "{message.data}"')


class MinimalSubscriber(Node):
    """Node that logs the texts of a topic."""

    def __init__(self, name: str = "minimal_subscriber", topic: str = "topic") -> None:
        super().__init__(name)
        self._subscription = self.create_subscription(String, topic, self._on_message, 10)

    def _on_message(self, message: String) -> None:
        self.get_logger().info(f'I heard: "{message.data}"')


class MinimalService(Node):
    """Node that serves ``add_two_ints``."""

    def __init__(self) -> None:
        super().__init__("minimal_service")
        self._service = self.create_service(AddTwoInts, "add_two_ints", self._add)

    def _add(
        self, request: AddTwoInts.Request, response: AddTwoInts.Response
    ) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        self.get_logger().info(f"Incoming request\na: {request.a} b: {request.b}")
        return response


class PointCloudPublisher(Node):
    """Node that publishes a grid of points whose heights move as a wave, 30 times a second."""

    _SIDE, _RATE_HZ = 50, 30

    def __init__(self) -> None:
        super().__init__("pc_publisher")
        self._publisher = self.create_publisher(PointCloud2, "test_cloud", 10)
        self._phase = 0
        names = ("x", "y", "z", "intensity")
        self._fields = [
            PointField(name=name, offset=4 * place, datatype=PointField.FLOAT32, count=1)
            for place, name in enumerate(names)
        ]
        self.create_timer(1.0 / self._RATE_HZ, self._publish)

    def _publish(self) -> None:
        places = [4.0 * step / (self._SIDE - 1) - 2.0 for step in range(self._SIDE)]
        points = []
        for x in places:
            for y in places:
                z = 0.5 * math.sin(2.0 * x - self._phase / 10.0) * math.sin(2.0 * y)
                points.append((x, y, z, z))
        header = Header(frame_id="map", stamp=self.get_clock().now().to_msg())
        self._publisher.publish(point_cloud2.create_cloud(header, self._fields, points))
        self._phase += 1


def publisher(args: list[str] | None = None) -> None:
    """Run ``minimal_publisher`` until Ctrl-C."""
    run(MinimalPublisher, args)


def subscriber(args: list[str] | None = None) -> None:
    """Run ``minimal_subscriber`` until Ctrl-C."""
    run(MinimalSubscriber, args)


def service(args: list[str] | None = None) -> None:
    """Run ``minimal_service`` until Ctrl-C."""
    run(MinimalService, args)


def client(args: list[str] | None = None) -> None:
    """Request the sum of 41 and 1, log it, and end."""
    _request("minimal_client", args)


def client_async(args: list[str] | None = None) -> None:
    """Request the sum of 41 and 1 as a node of another name, log it, and end."""
    _request("minimal_client_async", args)


def _request(name: str, args: list[str] | None) -> None:
    rclpy.init(args=args)
    node = rclpy.create_node(name)
    try:
        requests = node.create_client(AddTwoInts, "add_two_ints")
        while not requests.wait_for_service(timeout_sec=_WAIT_S):
            node.get_logger().info("service not available, waiting again...")
        future = requests.call_async(AddTwoInts.Request(a=_A, b=_B))
        rclpy.spin_until_future_complete(node, future)
        response = future.result()
        if response is not None:
            node.get_logger().info(f"Result of add_two_ints: for {_A} + {_B} = {response.sum}")
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C while waiting for the server
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def talker(args: list[str] | None = None) -> None:
    """Publish on ``chatter`` once a second until Ctrl-C."""
    run(lambda: MinimalPublisher("talker", "chatter", (1.0,)), args)


def listener(args: list[str] | None = None) -> None:
    """Log the texts of ``chatter`` until Ctrl-C."""
    run(lambda: MinimalSubscriber("listener", "chatter"), args)


def callback_group(args: list[str] | None = None) -> None:
    """Publish on ``chatter`` by two timers of one callback group until Ctrl-C."""
    run(lambda: MinimalPublisher("double_talker", "chatter", (1.0, 0.5)), args)


def composed(args: list[str] | None = None) -> None:
    """Run a talker and a listener in one executor until Ctrl-C."""
    _run_together(
        lambda: MinimalPublisher("talker", "chatter", (1.0,)),
        lambda: MinimalSubscriber("listener", "chatter"),
        args=args,
    )


def custom_executor(args: list[str] | None = None) -> None:
    """Run a talker, a listener and a listener of ``estop`` until Ctrl-C."""
    _run_together(
        lambda: MinimalSubscriber("estopper", "estop"),
        lambda: MinimalPublisher("talker", "chatter", (1.0,)),
        lambda: MinimalSubscriber("listener", "chatter"),
        args=args,
    )


def custom_callback_group(args: list[str] | None = None) -> None:
    """Publish on ``chatter`` twice a second until Ctrl-C."""
    run(lambda: MinimalPublisher("intermittent_talker", "chatter"), args)


def _run_together(*makers: Callable[[], Node], args: list[str] | None) -> None:
    rclpy.init(args=args)
    nodes = [make() for make in makers]
    executor = SingleThreadedExecutor()
    for node in nodes:
        executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end
    finally:
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()


def trigger_guard_condition(args: list[str] | None = None) -> None:
    """Trigger a guard condition by a timer, which ends the program."""
    rclpy.init(args=args)
    node = rclpy.create_node("demo_guard_condition")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    log = node.get_logger().info

    def guarded() -> None:
        rclpy.shutdown()
        log("guard callback called shutdown")

    guard = node.create_guard_condition(guarded)

    def trigger() -> None:
        guard.trigger()
        log("timer callback triggered guard condition")

    node.create_timer(2.0, trigger)
    try:
        while rclpy.ok():
            log("waiting for 'spin_once' to finish...")
            executor.spin_once()
            log("...'spin_once' finished!\n")
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C before the timer
    finally:
        rclpy.try_shutdown()


def pointcloud_publisher(args: list[str] | None = None) -> None:
    """Publish a moving cloud of points until Ctrl-C."""
    run(PointCloudPublisher, args)
