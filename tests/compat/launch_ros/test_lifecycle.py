"""Lifecycle nodes in Python launch files."""

import sys
from pathlib import Path
from typing import Any

import pytest

from tests.compat.activated import output

PROGRAM = Path(__file__).parents[1] / "programs/lifecycle.py"
LAUNCH = f"""
from launch import LaunchDescription
from launch.actions import EmitEvent, LogInfo, RegisterEventHandler
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events import matches_node_name
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition

def generate_launch_description():
    arm = LifecycleNode(
        executable={sys.executable!r}, arguments=["-m", "teleopctl.nodes", {str(PROGRAM)!r}],
        name="arm", namespace="left", autostart=True,
    )

    def ask(transition):
        return EmitEvent(event=ChangeState(
            lifecycle_node_matcher=matches_node_name("left/arm"), transition_id=transition,
        ))

    def on(goal_state, start_state, *entities):
        return RegisterEventHandler(OnStateTransition(
            target_lifecycle_node=arm, goal_state=goal_state, start_state=start_state,
            entities=[LogInfo(msg=goal_state + " from " + start_state), *entities],
        ))

    return LaunchDescription([
        on("inactive", "configuring"),
        on("active", "activating", ask(Transition.TRANSITION_CLEANUP),
           ask(Transition.TRANSITION_DEACTIVATE)),
        on("inactive", "deactivating"),
        arm,
    ])
"""


def test_transitions_are_made_one_by_one_and_answered_until_the_launch_ends(ros):
    (ros.folder / "life.launch.py").write_text(LAUNCH, encoding="utf-8")
    launch = ros.spawn("launch life.launch.py")
    launch.wait_for_line("Failed to make transition 'TRANSITION_CLEANUP' for .* '/left/arm'")
    launch.wait_for_line("inactive from deactivating")
    launch.interrupt()
    assert launch.wait() == 0
    assert [line for line in launch.stdout.splitlines() if " from " in line] == [
        "[INFO] [launch.user]: inactive from configuring",
        "[INFO] [launch.user]: active from activating",
        "[INFO] [launch.user]: inactive from deactivating",
    ]
    assert "Traceback" not in launch.stdout + launch.stderr


def test_a_launch_is_printed_without_a_node_of_its_own(ros):
    (ros.folder / "life.launch.py").write_text(LAUNCH, encoding="utf-8")
    printed = ros.run("launch --print life.launch.py")
    assert printed.returncode == 0
    assert "__node:=arm" in printed.stdout


def test_only_a_lifecycle_node_has_transitions():
    from launch_ros.actions import LifecycleTransition, Node
    from launch_ros.event_handlers import OnStateTransition

    camera: Any = Node(executable="camera")
    with pytest.raises(RuntimeError, match="no LifecycleNode"):
        OnStateTransition(entities=[], target_lifecycle_node=camera)
    with pytest.raises(ValueError, match="No transition_ids"):
        LifecycleTransition(lifecycle_node_names=["arm"], transition_ids=[])


def test_a_launch_without_them_imports_no_messages_and_no_nodes():
    code = "import sys, launch_ros.actions; print({'rclpy', 'lifecycle_msgs'} & {*sys.modules})"
    assert output(code).strip() == "set()"
