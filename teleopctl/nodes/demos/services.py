"""Demos of services: server and clients of ``add_two_ints``."""

from __future__ import annotations

import sys

import rclpy
from example_interfaces.srv import AddTwoInts
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future

from teleopctl.nodes.demos import run

_AGAIN_AFTER_S = 1.0


class AddTwoIntsServer(Node):
    """Node that serves ``add_two_ints``; with the parameter ``one_shot`` for one request only."""

    def __init__(self) -> None:
        super().__init__("add_two_ints_server")
        self._service = self.create_service(AddTwoInts, "add_two_ints", self._add)
        # Parameter of demo_nodes_cpp: exit after the first request.
        self._one_shot = bool(self.declare_parameter("one_shot", False).value)

    def _add(
        self, request: AddTwoInts.Request, response: AddTwoInts.Response
    ) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        self.get_logger().info(f"Incoming request\na: {request.a} b: {request.b}")
        if self._one_shot:
            self._timer = self.create_timer(0.1, rclpy.shutdown)
        return response


def add_two_ints_server(args: list[str] | None = None) -> None:
    """Run the node ``add_two_ints_server`` until Ctrl-C: it returns sums of two integers."""
    run(AddTwoIntsServer, args)


def add_two_ints_client(args: list[str] | None = None) -> None:
    """Run ``add_two_ints_client``: request 2 + 3, wait for the response, and log the sum."""
    _run_client(args, is_async=False)


def add_two_ints_client_async(args: list[str] | None = None) -> None:
    """Run ``add_two_ints_client_async``: request 2 + 3, poll for the response, and log the sum."""
    _run_client(args, is_async=True)


def _run_client(args: list[str] | None, *, is_async: bool) -> None:
    rclpy.init(args=args)
    node = rclpy.create_node("add_two_ints_client")
    try:
        client = node.create_client(AddTwoInts, "add_two_ints")
        while not client.wait_for_service(timeout_sec=_AGAIN_AFTER_S):
            sys.stdout.write("service not available, waiting again...\n")
            sys.stdout.flush()
        future = client.call_async(AddTwoInts.Request(a=2, b=3))
        if is_async:
            while rclpy.ok() and not future.done():
                rclpy.spin_once(node)
        else:
            rclpy.spin_until_future_complete(node, future)
        _log_result(node, future)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # Ctrl-C while waiting for the server
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _log_result(node: Node, future: Future[AddTwoInts.Response]) -> None:
    response = future.result()
    if response is not None:
        node.get_logger().info(f"Result of add_two_ints: {response.sum}")
    else:
        node.get_logger().error(f"Exception while calling service: {future.exception()!r}")
