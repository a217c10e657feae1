"""Trajectories sent as MoveIt's FollowJointTrajectoryControllerHandle sends them.

A program for rclpy alone: one action client per controller, `send` blocks until the goal is
accepted, `wait` asks for the result (also of a goal that has ended long ago), `cancel` waits for
the answer only. Prints one JSON object for each step: what MoveIt would see, and where the arm is.
"""

import json
import math
import threading
import time
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["joint_1", "joint_2", "joint_3"]
LONGEST_WAIT_S = 30.0
EXECUTION_STATUS = {
    GoalStatus.STATUS_SUCCEEDED: "SUCCEEDED",
    GoalStatus.STATUS_ABORTED: "ABORTED",
    GoalStatus.STATUS_CANCELED: "PREEMPTED",
}


class ControllerHandle:
    """Client of one controller, with the methods of MoveIt's handle.

    Attributes:
        goal: Handle of the last goal.
        status: MoveIt's execution status of the last goal.
    """

    def __init__(self, node):
        self._client = ActionClient(
            node, FollowJointTrajectory, "arm_controller/follow_joint_trajectory"
        )
        self.goal: Any = None
        self._done = True
        self.status = "SUCCEEDED"

    def wait_for_server(self):
        """Wait for the server, as MoveIt's manager does at its start."""
        return self._client.wait_for_server(LONGEST_WAIT_S)

    def send_trajectory(self, goal):
        """Send a goal; return whether it was accepted."""
        if not self._client.server_is_ready():
            return False
        self._done, self.status = False, "RUNNING"
        self.goal = outcome(self._client.send_goal_async(goal))
        return self.goal.accepted

    def wait_for_execution(self, timeout_s=LONGEST_WAIT_S):
        """Wait for the end of the last goal; return its result, None after the timeout."""
        response = outcome(self.goal.get_result_async(), timeout_s)
        if response is None:
            return None
        if not self._done:
            self.status, self._done = EXECUTION_STATUS.get(response.status, "FAILED"), True
        return response.result

    def cancel_execution(self):
        """Cancel the last goal unless it has ended; return the number of goals being canceled."""
        if self._done:
            return 0
        answer = outcome(self.goal.cancel_goal_async())
        self.status, self._done = "PREEMPTED", True
        return len(answer.goals_canceling)


class StateMonitor:
    """The joints' last measured positions, as of MoveIt's current state monitor."""

    def __init__(self, node):
        self._changed = threading.Condition()
        self._positions = {}
        node.create_subscription(JointState, "joint_states", self._received, 10)

    def _received(self, message):
        with self._changed:
            self._positions.update(zip(message.name, message.position, strict=True))
            self._changed.notify_all()

    def positions(self):
        """Return the positions of the next message."""
        with self._changed:
            self._positions.clear()
            assert self._changed.wait_for(
                lambda: self._positions.keys() >= set(JOINTS), LONGEST_WAIT_S
            )
            return [self._positions[name] for name in JOINTS]

    def is_at_rest(self):
        """Return whether the joints stand still from one message to the next."""
        before = self.positions()
        return max(abs(a - b) for a, b in zip(before, self.positions(), strict=True)) < 1e-3


def outcome(future, timeout_s=LONGEST_WAIT_S):
    """Wait for a future; return its result, None after the timeout."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    return future.result() if done.wait(timeout_s) else None


def planned(start, end, seconds, points=20):
    """Return a goal with a smooth motion: positions, velocities and accelerations, first point now.

    The header's stamp is 0, and there are no tolerances, as MoveIt's goals have them.
    """
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.header.frame_id = "world"
    goal.trajectory.joint_names = JOINTS
    for number in range(points + 1):
        s = number / points
        ways = [b - a for a, b in zip(start, end, strict=True)]
        place = (1 - math.cos(math.pi * s)) / 2
        speed = math.pi / 2 / seconds * math.sin(math.pi * s)
        acceleration = (math.pi / seconds) ** 2 / 2 * math.cos(math.pi * s)
        point = JointTrajectoryPoint(
            positions=[a + place * way for a, way in zip(start, ways, strict=True)],
            velocities=[speed * way for way in ways],
            accelerations=[acceleration * way for way in ways],
            time_from_start=Duration(seconds=s * seconds).to_msg(),
        )
        goal.trajectory.points.append(point)
    return goal


def main():
    """Move the arm there and back in MoveIt's ways."""
    rclpy.init()
    node = rclpy.create_node("moveit_simple_controller_manager")
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    handle, monitor = ControllerHandle(node), StateMonitor(node)
    assert handle.wait_for_server()

    def tell(step, wanted=None, result=None, **more):
        if wanted is not None:
            now = monitor.positions()
            more["error"] = max(abs(a - b) for a, b in zip(now, wanted, strict=True))
        if result is not None:
            more["code"], more["text"] = result.error_code, result.error_string
        print(json.dumps({"step": step, "status": handle.status, **more}), flush=True)

    home = monitor.positions()
    away = [0.5, 0.3, -0.4]
    accepted = handle.send_trajectory(planned(home, away, 1.0))
    tell("sent", accepted=accepted)
    tell("executed", away, handle.wait_for_execution())
    # The result of a goal that has ended is still there.
    tell("executed before", away, handle.wait_for_execution())

    tolerant = planned(away, home, 1.0)
    tolerant.path_tolerance = [JointTolerance(name=name, position=0.5) for name in sorted(JOINTS)]
    tolerant.goal_tolerance = [JointTolerance(name=name, position=0.01) for name in sorted(JOINTS)]
    tolerant.goal_time_tolerance = Duration(seconds=5.0).to_msg()
    handle.send_trajectory(tolerant)
    tell("within tolerances", home, handle.wait_for_execution())

    handle.send_trajectory(planned(home, away, 20.0))
    tell("too slow", timed_out=handle.wait_for_execution(0.3) is None)
    canceled = handle.cancel_execution()
    tell("canceled", result=handle.wait_for_execution(), canceling=canceled)
    tell("canceled again", canceling=handle.cancel_execution())
    deadline = time.monotonic() + LONGEST_WAIT_S
    while not (rests := monitor.is_at_rest()) and time.monotonic() < deadline:
        pass
    tell("stopped", rests=rests)

    here = monitor.positions()
    handle.send_trajectory(planned(here, away, 20.0))
    first = handle.goal
    handle.send_trajectory(planned(monitor.positions(), home, 1.0))
    replaced = outcome(first.get_result_async())
    tell("continued", home, handle.wait_for_execution(), replaced=EXECUTION_STATUS[replaced.status])

    unknown = planned(home, away, 1.0)
    unknown.trajectory.joint_names = ["joint_1", "joint_2", "elbow"]
    tell("unknown joint", accepted=handle.send_trajectory(unknown))

    executor.shutdown()
    rclpy.shutdown()


main()
