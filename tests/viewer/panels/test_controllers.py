"""The panel of the controllers, against a real controller manager."""

from __future__ import annotations

import re
from typing import Any

import pytest

from teleopctl.interfaces import get_message
from teleopctl.packages import package_share
from teleopctl.robot import expand_xacro
from teleopctl.viewer.panels.controllers import ControllersPanel
from tests.viewer.panels.live import ManagerProcess, spinning

CONTROLLERS = package_share("teleop_controller") / "teleop_controllers.yaml"
ARGUMENTS = ["--ros-args", "--params-file", str(CONTROLLERS)]
NAMES = ["arm_controller", "gripper_controller", "joint_state_broadcaster"]


@pytest.fixture(scope="module")
def mock_urdf():
    model = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    return expand_xacro(model, {"hardware": "mock"})


def manager(urdf):
    return lambda context, executor: ManagerProcess(context, executor, urdf, ARGUMENTS)


@pytest.fixture
def panel(live):
    panel = ControllersPanel(live)
    live.show(panel)
    return panel


def texts(handle):
    return re.sub("<[^>]*>", " ", handle.content)


def states(panel):
    return {name: row.state for name, row in panel._controllers.items()}


def actions(row: Any) -> tuple[str, ...]:
    return tuple(row._buttons.options) if row._buttons.visible else ()


def load(live, panel, name):
    live.until(lambda: name in panel._name.options)
    live.choose(panel._name, name)
    (button,) = (child for child in panel._load._children.values() if child is not panel._name)
    live.click(button)
    live.until(lambda: name in panel._controllers)


def do(live, panel, name, action, state):
    row = panel._controllers.get(name) or panel._components[name]
    assert action in actions(row)
    live.choose(row._buttons, action)
    live.until(lambda: row.state == state and not row.is_busy)


def test_without_a_manager_one_sentence_says_how_to_start_one(live, panel):
    live.until(lambda: panel._note.visible)
    assert "teleopctl launch" in texts(panel._note)
    assert not panel._load.visible
    assert not panel._hardware.visible


def test_a_controller_goes_through_its_states_by_clicks(live, panel, mock_urdf):
    with spinning(manager(mock_urdf)):
        live.until(lambda: "RobotSystem" in panel._components)
        assert panel._components["RobotSystem"].state == "active"
        live.until(lambda: set(panel._name.options) == set(NAMES))
        load(live, panel, "arm_controller")
        row = panel._controllers["arm_controller"]
        assert row.state == "unconfigured"
        do(live, panel, "arm_controller", "Configure", "inactive")
        do(live, panel, "arm_controller", "Clean up", "unconfigured")
        do(live, panel, "arm_controller", "Activate", "active")
        assert "joint_1/position" in texts(row._text)
        assert actions(row) == ("Deactivate",)
        do(live, panel, "arm_controller", "Deactivate", "inactive")
        live.choose(row._buttons, "Unload")
        live.until(lambda: "arm_controller" not in panel._controllers)
        assert live.told == []


def test_what_others_switch_is_shown_by_event(live, panel, mock_urdf):
    with spinning(manager(mock_urdf)) as (other,):
        live.until(lambda: panel._components)
        manager_ = other.manager.manager
        manager_.load_controller("arm_controller")
        other.manager.publish_activity()
        live.until(lambda: states(panel) == {"arm_controller": "unconfigured"})


def test_a_refusal_is_told_with_its_cause(live, panel, mock_urdf):
    with spinning(manager(mock_urdf)):
        live.until(lambda: panel._components)
        load(live, panel, "joint_state_broadcaster")
        # Activated while the hardware is off: the reply has the reason.
        do(live, panel, "joint_state_broadcaster", "Configure", "inactive")
        do(live, panel, "RobotSystem", "Deactivate", "inactive")
        do(live, panel, "RobotSystem", "Clean up", "unconfigured")
        row = panel._controllers["joint_state_broadcaster"]
        live.choose(row._buttons, "Activate")
        live.until(lambda: live.told)
        title, reason = live.told[0]
        assert title == "Activate joint_state_broadcaster: failed"
        assert reason
        live.until(lambda: not row.is_busy)
        assert row.state == "inactive"


def test_a_service_that_answers_with_a_bare_no_is_told_with_the_log_s_cause(
    live, panel, mock_urdf, tmp_path
):
    file = tmp_path / "broken.yaml"
    file.write_text(
        "controller_manager:\n  ros__parameters:\n"
        "    nowhere: {type: joint_trajectory_controller/JointTrajectoryController}\n"
    )
    arguments = ["--ros-args", "--params-file", str(file)]
    with spinning(lambda c, e: ManagerProcess(c, e, mock_urdf, arguments)):
        live.until(lambda: panel._components)
        load(live, panel, "nowhere")
        row = panel._controllers["nowhere"]
        live.choose(row._buttons, "Configure")
        live.until(lambda: live.told)
        title, reason = live.told[0]
        assert title == "Configure nowhere: failed"
        assert "joints" in reason
        live.until(lambda: not row.is_busy)


def test_of_several_managers_one_is_chosen(live, panel, mock_urdf, tmp_path):
    file = tmp_path / "any_namespace.yaml"
    file.write_text(
        "/**/controller_manager:\n  ros__parameters:\n"
        "    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}\n"
    )
    arguments = ["--ros-args", "--params-file", str(file)]
    with spinning(
        lambda c, e: ManagerProcess(c, e, mock_urdf, arguments, "/left"),
        lambda c, e: ManagerProcess(c, e, mock_urdf, arguments, "/right"),
    ):
        live.until(lambda: len(panel._choice.options) == 2)
        assert panel._choice.visible
        live.choose(panel._choice, "/right/controller_manager")
        live.until(lambda: panel._components)
        load(live, panel, "arm_controller")
        live.choose(panel._choice, "/left/controller_manager")
        live.until(lambda: panel._components)
        assert states(panel) == {}
        live.choose(panel._choice, "/right/controller_manager")
        live.until(lambda: states(panel) == {"arm_controller": "unconfigured"})


def test_a_manager_that_ends_takes_its_controllers_along_and_one_that_returns_is_found(
    live, panel, mock_urdf
):
    for _ in range(2):
        with spinning(manager(mock_urdf)):
            live.until(lambda: panel._components)
            load(live, panel, "arm_controller")
        live.until(lambda: not panel._components)
        assert states(panel) == {}
        live.until(lambda: "teleopctl launch" in texts(panel._note))


def test_nobody_looks_and_nothing_is_listened_to(live, panel, mock_urdf):
    with spinning(manager(mock_urdf)):
        live.until(lambda: panel._components)
        panel.ended()
        live.until(lambda: live.node.count_subscribers("/controller_manager/activity") == 0)
        panel.began()
        live.until(lambda: panel._components)


def test_names_from_the_graph_are_not_html(live, panel):
    state = get_message("controller_manager_msgs/msg/ControllerState")(
        name="<img src=x onerror=alert(1)>",
        state="<b>odd</b>",
        type='a/"><script>alert(1)</script>',
        claimed_interfaces=["<i>/position"],
    )
    panel._show([state], [])
    (row,) = panel._controllers.values()
    assert "<script" not in row._text.content
    assert "<i>" not in row._text.content
    assert "&lt;b&gt;odd" in row._text.content
    assert actions(row) == ()
