"""``control reload`` with real processes: a controller's code changes while it follows a goal."""

import threading
from itertools import pairwise
from typing import Any

import pytest

from teleopctl.interfaces import get_action, get_message, to_nanoseconds
from teleopctl.node import ActionClient, GoalState
from teleopctl.testing import LONGEST_WAIT_S, eventually

FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")
JointTrajectoryPoint = get_message("trajectory_msgs/msg/JointTrajectoryPoint")

CODE = """\
from control_msgs.action import FollowJointTrajectory

from teleopctl.control import (
    ControllerInterface,
    InterfaceConfiguration,
    InterfaceConfigurationType,
    RealtimePublisher,
    RealtimeServerGoalHandle,
)
from teleopctl.interfaces import set_stamp
from teleopctl.node import CancelResponse, GoalResponse

SPEED, CODE = 0.05, "old"


class Follow(ControllerInterface):
    def on_configure(self):
        self.server = self.create_action_server(
            FollowJointTrajectory,
            "~/follow_joint_trajectory",
            goal_callback=lambda goal: GoalResponse.ACCEPT,
            handle_accepted_callback=self.begin,
            cancel_callback=lambda handle: CancelResponse.ACCEPT,
        )
        self.feedback = RealtimePublisher(self.params.publish_queue, self.publish)
        self.goal = None

    def on_cleanup(self):
        self.server.destroy()

    def on_activate(self):
        self.reference = self.state_interfaces[0].value

    def export_state(self):
        return {"goal": self.goal, "reference": self.reference}

    def import_state(self, state):
        self.goal, self.reference = state["goal"], state["reference"]

    def begin(self, handle):
        goal = RealtimeServerGoalHandle(handle, FollowJointTrajectory, self.params.publish_queue)
        goal.start()
        self.goal = goal

    def publish(self, value):
        goal, time_ns, reference = value
        message = FollowJointTrajectory.Feedback()
        set_stamp(message.header.stamp, time_ns)
        message.desired.positions = [reference]
        if goal.handle.is_active:
            goal.handle.publish_feedback(message)

    def command_interface_configuration(self):
        names = ["joint_1/position"]
        return InterfaceConfiguration(InterfaceConfigurationType.INDIVIDUAL, names)

    state_interface_configuration = command_interface_configuration

    def update(self, time_ns, period):
        goal = self.goal
        if goal is None:
            return
        wanted = goal.handle.request.trajectory.points[-1].positions[0]
        step = SPEED * period
        self.reference += max(-step, min(step, wanted - self.reference))
        self.command_interfaces[0].value = self.reference
        self.feedback.try_publish((goal, time_ns, self.reference))
        if abs(self.reference - wanted) < 1e-9:
            goal.try_succeed(error_string=CODE)
            self.goal = None
"""
BEGIN = "    def on_configure(self):\n"
CONTROLLERS = """\
controller_manager:
  ros__parameters:
    update_rate: 100
    follow: {type: "my_follow:Follow"}
"""
WANTED, NEW_SPEED = 0.5, 1.0


def outcome(future: Any) -> Any:
    assert future.wait(LONGEST_WAIT_S)
    return future.result()


@pytest.mark.nightly
def test_a_goal_goes_on_in_changed_code_and_no_cycle_is_missed(ros):
    code = ros.folder / "my_follow.py"
    code.write_text(CODE)
    (ros.folder / "follow.yaml").write_text(CONTROLLERS)
    ros.env["PYTHONPATH"] = f"{ros.folder}:{ros.env.get('PYTHONPATH', '')}"
    ros.launch("sim.yaml", "camera:=false", "controllers_file:=follow.yaml", "controllers:=follow")
    client = ActionClient(ros.node, FollowJointTrajectory, "/follow/follow_joint_trajectory")
    assert client.wait_for_server(LONGEST_WAIT_S)
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = ["joint_1"]
    goal.trajectory.points = [JointTrajectoryPoint(positions=[WANTED])]
    received = []
    moves = threading.Event()

    def on_feedback(message):
        stamp_ns = to_nanoseconds(message.feedback.header.stamp)
        received.append((stamp_ns, message.feedback.desired.positions[0]))
        moves.set()

    accepted = outcome(client.send_goal_async(goal, feedback_callback=on_feedback))
    result = accepted.get_result_async()
    assert moves.wait(LONGEST_WAIT_S)

    code.write_text(CODE.replace("goal = self.goal\n", "goal = self.gaol\n"))
    refused = ros.run("control reload follow")
    assert refused.returncode == 1
    line = 1 + CODE[: CODE.index("goal = self.goal\n")].count("\n")
    assert (
        "Could not reload controller 'follow', its running code goes on: its first update raised "
        "AttributeError: 'Follow' object has no attribute 'gaol'"
    ) in refused.stderr
    assert f"({code}:{line})" in refused.stderr
    assert not result.ended()

    hanging = CODE.replace(BEGIN, f"{BEGIN}        __import__('threading').Event().wait()\n")
    code.write_text(hanging)
    refused = ros.run("control reload follow --timeout 0.2")
    assert refused.returncode == 1
    line = 2 + CODE[: CODE.index(BEGIN)].count("\n")
    assert f"after 0.2 s, on_configure has not returned ({code}:{line})" in refused.stderr

    code.write_text(CODE)
    watch = ros.spawn("control reload follow --watch")
    watch.wait_for_line("Successfully reloaded controller follow: my_follow", stream="stdout")
    eventually(lambda: "Watching " in watch.stderr)
    code.write_text(CODE.replace('0.05, "old"', '1.0, "new"'))
    watch.wait_for_line("Successfully reloaded controller follow: my_follow")
    watch.interrupt()
    assert watch.wait() == 130
    assert outcome(result).status == GoalState.SUCCEEDED
    assert outcome(result).result.error_string == "new"
    eventually(lambda: abs(received[-1][1] - WANTED) < 1e-9)
    for (before_ns, before), (after_ns, after) in pairwise(received):
        seconds = (after_ns - before_ns) * 1e-9
        assert 0.0 < after - before < NEW_SPEED * seconds + 1e-9
