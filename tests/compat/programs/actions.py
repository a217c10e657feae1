"""Actions as programs of ROS 2 use them, in one process and with asyncio."""

import asyncio
import threading

import rclpy
import rclpy.action
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class FibonacciServer(Node):
    def __init__(self):
        super().__init__("fibonacci_server")
        self.held = None
        self.server = ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            execute_callback=self.execute,
            goal_callback=self.judge,
            handle_accepted_callback=self.begin,
            cancel_callback=lambda goal_handle: CancelResponse.ACCEPT,
        )

    def judge(self, goal_request):
        return GoalResponse.ACCEPT if goal_request.order > 0 else GoalResponse.REJECT

    def begin(self, goal_handle: rclpy.action.server.ServerGoalHandle):
        # A new goal replaces the held goal.
        if self.held is not None and self.held.is_active:
            self.held.abort(Fibonacci.Result())
        self.held = goal_handle
        if goal_handle.request.order != 99:
            goal_handle.execute()
        else:
            goal_handle.executing()

    async def execute(self, goal_handle):
        feedback = Fibonacci.Feedback(sequence=[0, 1])
        for _ in range(1, goal_handle.request.order):
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                return Fibonacci.Result()
            feedback.sequence.append(feedback.sequence[-2] + feedback.sequence[-1])
            goal_handle.publish_feedback(feedback)
        goal_handle.succeed()
        return Fibonacci.Result(sequence=feedback.sequence)


async def ask(client):
    held = await client.send_goal_async(Fibonacci.Goal(order=99))
    told = threading.Event()
    goal = await client.send_goal_async(
        Fibonacci.Goal(order=5), feedback_callback=lambda message: told.set()
    )
    answer = await goal.get_result_async()
    assert answer.status == GoalStatus.STATUS_SUCCEEDED
    assert list(answer.result.sequence) == [0, 1, 1, 2, 3, 5]
    # Feedback callbacks run on other threads, possibly after the result has been received.
    assert await asyncio.to_thread(told.wait, 10)
    assert (await held.get_result_async()).status == GoalStatus.STATUS_ABORTED
    assert not (await client.send_goal_async(Fibonacci.Goal())).accepted
    third = await client.send_goal_async(Fibonacci.Goal(order=99))
    assert len((await third.cancel_goal_async()).goals_canceling) == 1


def main():
    rclpy.init()
    server = FibonacciServer()
    node = rclpy.create_node("asking")
    client = ActionClient(node, Fibonacci, "fibonacci")
    executor = MultiThreadedExecutor()
    executor.add_node(server)
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    assert client.wait_for_server(timeout_sec=10.0)
    asyncio.run(asyncio.wait_for(ask(client), 30))
    assert server.held.is_cancel_requested
    rclpy.shutdown()
    spinning.join()
    print("done")


if __name__ == "__main__":
    main()
