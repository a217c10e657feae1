"""Demo of actions: server and client of the action ``fibonacci``."""

from __future__ import annotations

import time
from typing import Any

import rclpy
from action_tutorials_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future

from teleopctl.nodes.demos import run

_ORDER = 10
_STEP_S = 1.0


class FibonacciActionServer(Node):
    """Node whose action server computes a Fibonacci sequence, one number per second."""

    def __init__(self) -> None:
        super().__init__("fibonacci_action_server")
        self._server = ActionServer(self, Fibonacci, "fibonacci", self._execute)

    # Any, here and below: handles and messages of the action.
    def _execute(self, goal_handle: Any) -> Any:
        self.get_logger().info("Executing goal...")
        feedback = Fibonacci.Feedback(partial_sequence=[0, 1])
        numbers = [0, 1]
        for _ in range(1, goal_handle.request.order):
            numbers.append(numbers[-1] + numbers[-2])
            feedback.partial_sequence = numbers
            self.get_logger().info(f"Feedback: {feedback.partial_sequence}")
            goal_handle.publish_feedback(feedback)
            time.sleep(_STEP_S)
        goal_handle.succeed()
        return Fibonacci.Result(sequence=numbers)


class FibonacciActionClient(Node):
    """Node that sends a ``fibonacci`` goal, logs the result, and then shuts rclpy down."""

    def __init__(self) -> None:
        super().__init__("fibonacci_action_client")
        self._client = ActionClient(self, Fibonacci, "fibonacci")

    def send_goal(self, order: int) -> None:
        """Wait for the action server, and send a goal of an order; the result is logged later."""
        self._client.wait_for_server()
        sent = self._client.send_goal_async(
            Fibonacci.Goal(order=order), feedback_callback=self._take_feedback
        )
        sent.add_done_callback(self._take_answer)

    def _take_answer(self, future: Future[Any]) -> None:
        goal_handle: Any = future.result()
        if not goal_handle.accepted:
            self.get_logger().info("Goal rejected :(")
            return
        self.get_logger().info("Goal accepted :)")
        goal_handle.get_result_async().add_done_callback(self._take_result)

    def _take_result(self, future: Future[Any]) -> None:
        answer: Any = future.result()
        self.get_logger().info(f"Result: {answer.result.sequence}")
        rclpy.shutdown()

    def _take_feedback(self, message: Any) -> None:
        self.get_logger().info(f"Received feedback: {message.feedback.partial_sequence}")


def fibonacci_action_server(args: list[str] | None = None) -> None:
    """Run the node ``fibonacci_action_server`` until Ctrl-C: it computes sequences on request."""
    run(FibonacciActionServer, args)


def fibonacci_action_client(args: list[str] | None = None) -> None:
    """Run ``fibonacci_action_client``: send one goal, log feedback and result, and end."""
    rclpy.init(args=args)
    node = FibonacciActionClient()
    try:
        node.send_goal(_ORDER)
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the result was received, or Ctrl-C
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
