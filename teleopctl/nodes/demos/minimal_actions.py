"""The programs of ``examples_rclpy_minimal_action_server`` and ``…_client``: Fibonacci sequences.

The servers differ in what they do with a goal that comes during another one.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

from teleopctl.nodes.demos import run

_ORDER = 10
_STEP_S, _DEFER_S, _CANCEL_AFTER_S = 1.0, 3.0, 2.0

# Any, here and below: handles and messages of the action.


class MinimalActionServer(Node):
    """Node that computes sequences, those of several goals at the same time."""

    def __init__(self) -> None:
        super().__init__("minimal_action_server")
        self._server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            execute_callback=self._execute,
            goal_callback=self._on_goal,
            handle_accepted_callback=self._on_accepted,
            cancel_callback=self._on_cancel,
            callback_group=ReentrantCallbackGroup(),
        )

    def _on_goal(self, _: Any) -> GoalResponse:
        self.get_logger().info("Received goal request")
        return GoalResponse.ACCEPT

    def _on_cancel(self, _: Any) -> CancelResponse:
        self.get_logger().info("Received cancel request")
        return CancelResponse.ACCEPT

    def _on_accepted(self, goal: Any) -> None:
        goal.execute()

    def _execute(self, goal: Any) -> Any:
        log = self.get_logger().info
        log("Executing goal...")
        feedback = Fibonacci.Feedback(sequence=[0, 1])
        numbers = [0, 1]
        for _ in range(1, goal.request.order):
            if not goal.is_active:
                log("Goal aborted")
                return Fibonacci.Result()
            if goal.is_cancel_requested:
                goal.canceled()
                log("Goal canceled")
                return Fibonacci.Result()
            numbers.append(numbers[-1] + numbers[-2])
            feedback.sequence = numbers
            log(f"Publishing feedback: {feedback.sequence}")
            goal.publish_feedback(feedback)
            time.sleep(_STEP_S)
        if not goal.is_active:
            log("Goal aborted")
            return Fibonacci.Result()
        goal.succeed()
        result = Fibonacci.Result(sequence=numbers)
        log(f"Returning result: {result.sequence}")
        return result


class DeferringActionServer(MinimalActionServer):
    """Node that begins a goal three seconds after its acceptance."""

    def _on_accepted(self, goal: Any) -> None:
        self.get_logger().info("Deferring execution...")

        def begin() -> None:
            self.destroy_timer(timer)
            goal.execute()

        timer = self.create_timer(_DEFER_S, begin)


class QueueingActionServer(MinimalActionServer):
    """Node that executes goals one after the other."""

    def __init__(self) -> None:
        self._waiting: deque[Any] = deque()
        self._is_busy = False
        self._lock = threading.Lock()
        super().__init__()

    def _on_accepted(self, goal: Any) -> None:
        with self._lock:
            if self._is_busy:
                self._waiting.append(goal)
                self.get_logger().info("Goal put in the queue")
                return
            self._is_busy = True
        goal.execute()

    def _execute(self, goal: Any) -> Any:
        try:
            return super()._execute(goal)
        finally:
            with self._lock:
                following = self._waiting.popleft() if self._waiting else None
                self._is_busy = following is not None
            if following is not None:
                self.get_logger().info("Next goal pulled from the queue")
                following.execute()


class SingleGoalActionServer(MinimalActionServer):
    """Node that aborts a goal when another one comes."""

    def __init__(self) -> None:
        self._goal: Any = None
        self._lock = threading.Lock()
        super().__init__()

    def _on_accepted(self, goal: Any) -> None:
        with self._lock:
            if self._goal is not None and self._goal.is_active:
                self.get_logger().info("Aborting previous goal")
                self._goal.abort()
            self._goal = goal
        goal.execute()


class MinimalActionClient(Node):
    """Node that sends goals and shuts rclpy down after the last one.

    Args:
        name: Name of the node.
        goals: Number of goals that are sent at once.
        cancels: Whether the goal is canceled after two seconds.
    """

    def __init__(
        self, name: str = "minimal_action_client", goals: int = 1, *, cancels: bool = False
    ) -> None:
        super().__init__(name)
        self._client = ActionClient(self, Fibonacci, "fibonacci")
        self._left = goals
        self._cancels = cancels

    def send_goals(self) -> None:
        """Wait for the action server and send the goals; results are logged later."""
        log = self.get_logger().info
        log("Waiting for action server...")
        self._client.wait_for_server()
        for _ in range(self._left):
            log("Sending goal request...")
            sent = self._client.send_goal_async(
                Fibonacci.Goal(order=_ORDER), feedback_callback=self._take_feedback
            )
            sent.add_done_callback(self._take_answer)

    def _take_feedback(self, message: Any) -> None:
        self.get_logger().info(f"Received feedback: {message.feedback.sequence}")

    def _take_answer(self, future: Any) -> None:
        goal = future.result()
        if not goal.accepted:
            self.get_logger().info("Goal rejected :(")
            self._end_one()
            return
        self.get_logger().info("Goal accepted :)")
        if self._cancels:
            timer = self.create_timer(_CANCEL_AFTER_S, lambda: self._cancel(goal, timer))
        else:
            goal.get_result_async().add_done_callback(self._take_result)

    def _cancel(self, goal: Any, timer: Any) -> None:
        timer.cancel()
        self.get_logger().info("Canceling goal")
        goal.cancel_goal_async().add_done_callback(self._take_cancellation)

    def _take_cancellation(self, future: Any) -> None:
        is_canceled = bool(future.result().goals_canceling)
        self.get_logger().info(
            "Goal successfully canceled" if is_canceled else "Goal failed to cancel"
        )
        self._end_one()

    def _take_result(self, future: Any) -> None:
        answer = future.result()
        if answer.status == GoalStatus.STATUS_SUCCEEDED:
            self.get_logger().info(f"Goal succeeded! Result: {answer.result.sequence}")
        else:
            self.get_logger().info(f"Goal failed with status: {answer.status}")
        self._end_one()

    def _end_one(self) -> None:
        self._left -= 1
        if not self._left:
            rclpy.shutdown()


def server(args: list[str] | None = None) -> None:
    """Serve goals, several at the same time, until Ctrl-C."""
    _serve(MinimalActionServer, args)


def server_defer(args: list[str] | None = None) -> None:
    """Serve goals, each three seconds later, until Ctrl-C."""
    _serve(DeferringActionServer, args)


def server_queue_goals(args: list[str] | None = None) -> None:
    """Serve goals one after the other until Ctrl-C."""
    _serve(QueueingActionServer, args)


def server_single_goal(args: list[str] | None = None) -> None:
    """Serve the newest goal until Ctrl-C."""
    _serve(SingleGoalActionServer, args)


def _serve(make: Callable[[], Node], args: list[str] | None) -> None:
    rclpy.init(args=args)
    node = make()
    executor = MultiThreadedExecutor()
    try:
        rclpy.spin(node, executor=executor)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the ordinary end
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def client(args: list[str] | None = None) -> None:
    """Send a goal, log its feedback and result, and end."""
    run(lambda: _sending(MinimalActionClient()), args)


def client_cancel(args: list[str] | None = None) -> None:
    """Send a goal, cancel it after two seconds, and end."""
    run(lambda: _sending(MinimalActionClient(cancels=True)), args)


def client_asyncio(args: list[str] | None = None) -> None:
    """Send two goals at once, log their results, and end."""
    run(lambda: _sending(MinimalActionClient("minimal_action_client_asyncio", 2)), args)


def _sending(node: MinimalActionClient) -> Node:
    node.send_goals()
    return node
