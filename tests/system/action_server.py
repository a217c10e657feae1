"""Action server of ``/fib`` in the style of ROS 2's examples.

Negative goals are rejected, goal 0 is aborted, and goals above 90 run until they are canceled,
which goal 99 rejects. Goal 98 blocks the only thread until the server reads a line.
"""

import contextlib
import sys

import rclpy
from action_msgs.msg import GoalStatusArray
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException


def judge(goal):
    return GoalResponse.REJECT if goal.order < 0 else GoalResponse.ACCEPT


def judge_cancel(goal_handle):
    return CancelResponse.REJECT if goal_handle.request.order == 99 else CancelResponse.ACCEPT


def begin(goal_handle):
    if goal_handle.request.order > 90 and goal_handle.request.order != 98:
        goal_handle.executing()
        held.append(goal_handle)
    else:
        goal_handle.execute()


def execute(goal_handle):
    order = goal_handle.request.order
    if order == 0:
        goal_handle.abort()
        return Fibonacci.Result()
    if order == 98:
        goal_handle.publish_feedback(Fibonacci.Feedback())
        sys.stdin.readline()
        goal_handle.succeed()
        return Fibonacci.Result()
    feedback = Fibonacci.Feedback(sequence=[0, 1])
    for _ in range(1, order):
        feedback.sequence.append(feedback.sequence[-1] + feedback.sequence[-2])
        goal_handle.publish_feedback(feedback)
    goal_handle.succeed()
    return Fibonacci.Result(sequence=feedback.sequence)


def end_what_is_cancelled(_):
    for goal_handle in [each for each in held if each.is_cancel_requested]:
        held.remove(goal_handle)
        goal_handle.canceled(Fibonacci.Result())


held: list[ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]] = []
rclpy.init()
node = rclpy.create_node("fibonacci")
server = ActionServer(
    node,
    Fibonacci,
    "fib",
    execute,
    goal_callback=judge,
    handle_accepted_callback=begin,
    cancel_callback=judge_cancel,
)
node.create_subscription(GoalStatusArray, "fib/_action/status", end_what_is_cancelled, 10)
with contextlib.suppress(ExternalShutdownException):
    rclpy.spin(node)
