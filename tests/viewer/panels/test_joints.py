"""The joint sliders, on a graph with those whom they move."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from hypothesis import given, strategies

from teleopctl.interfaces import get_message
from teleopctl.node import Node, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.robot import expand_xacro
from teleopctl.viewer.panels.joint_movers import SLIDERS_TOPIC
from teleopctl.viewer.panels.joints import JointsPanel
from tests.viewer.conftest import FakePage
from tests.viewer.panels.live import ManagerProcess, spinning

JointState = get_message("sensor_msgs/msg/JointState")
String = get_message("std_msgs/msg/String")
MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"

ODD = 'j<b>o</b>/ü "1" `x`'
ROBOT = f"""<robot name="odd">
  <link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/><link name="f"/>
  <joint name="wheel" type="continuous">
    <parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
  <joint name="lift" type="prismatic">
    <parent link="a"/><child link="c"/><limit lower="0.01" upper="0.05" effort="1" velocity="1"/>
  </joint>
  <joint name="m1" type="revolute">
    <parent link="a"/><child link="d"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
    <mimic joint="lift" multiplier="2"/></joint>
  <joint name="m2" type="revolute">
    <parent link="a"/><child link="e"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
    <mimic joint="m1" multiplier="-1" offset="1"/></joint>
  <joint name="{ODD.replace("<", "&lt;").replace('"', "&quot;")}" type="revolute">
    <parent link="a"/><child link="f"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.fixture
def panel(live):
    panel = JointsPanel(live)
    live.show(panel)
    return panel


class Robot:
    """Publishes a description, and listens to the joints."""

    def __init__(self, live: Any, urdf: str) -> None:
        self.node = Node("robot", context=live.context)
        live._executor.add_node(self.node)
        self._description = self.node.create_publisher(
            String, "/robot_description", qos_profile_latched
        )
        self.joints: dict[str, float] = {}
        self.node.create_subscription(JointState, "/joint_states", self._take, 10)
        self.describe(urdf)

    def describe(self, urdf: str) -> None:
        self._description.publish(String(data=urdf))

    def _take(self, state: Any) -> None:
        self.joints.update(zip(state.name, state.position, strict=False))


def put(live, panel, name, value):
    """Move a slider by hand."""
    live.choose(panel._sliders[name], value)


def enabled(panel):
    return {name for name, slider in panel._sliders.items() if not slider.disabled}


def is_at(robot, **joints):
    return all(abs(robot.joints.get(name, 99) - value) < 2e-3 for name, value in joints.items())


def test_where_nobody_publishes_the_joints_the_sliders_do(live, panel):
    robot = Robot(live, ROBOT)
    live.until(lambda: {"wheel", "lift", ODD} == enabled(panel))
    # The middle of a range that has no zero; followers through a chain.
    live.until(lambda: is_at(robot, wheel=0.0, lift=0.03, m1=0.06, m2=0.94))
    put(live, panel, "lift", 0.04)
    put(live, panel, ODD, 0.5)
    live.until(lambda: is_at(robot, lift=0.04, m1=0.08, m2=0.92, **{ODD: 0.5}))
    assert panel._sliders["wheel"].min == pytest.approx(-math.pi)
    assert panel._sliders["lift"].hint == "0.01 to 0.05 m; moves m1, m2 too"


def test_center_and_randomize_put_every_joint(live, panel):
    robot = Robot(live, ROBOT)
    live.until(lambda: robot.joints)
    put(live, panel, "wheel", 3.0)
    live.until(lambda: is_at(robot, wheel=3.0))
    live.choose(panel._all, "Center")
    live.until(lambda: is_at(robot, wheel=0.0, lift=0.03))
    live.choose(panel._all, "Randomize")
    live.until(lambda: robot.joints["wheel"] != 0.0)
    assert 0.01 <= robot.joints["lift"] <= 0.05


def test_a_joint_state_publisher_that_listens_is_given_the_positions(live, panel, ros):
    robot = Robot(live, ROBOT)
    process = ros.spawn(
        "run joint_state_publisher joint_state_publisher "
        f"--ros-args -p source_list:=[{SLIDERS_TOPIC}]"
    )
    live.until(lambda: live.node.count_publishers("/joint_states") and panel._sliders)
    live.until(lambda: live.node.count_subscribers(SLIDERS_TOPIC))
    live.until(lambda: enabled(panel))
    put(live, panel, "wheel", 1.25)
    live.until(lambda: is_at(robot, wheel=1.25))
    assert live.node.count_publishers("/joint_states") == 1
    # One that has ended leaves the joints alone until a person says so.
    process.interrupt()
    live.until(lambda: panel._take_over.visible)
    assert enabled(panel) == set()
    live.click(panel._take_over)
    live.until(lambda: enabled(panel))
    put(live, panel, "wheel", -1.0)
    live.until(lambda: is_at(robot, wheel=-1.0))
    assert not panel._take_over.visible


def test_display_yaml_s_publisher_listens_to_the_sliders(live, panel, ros):
    ros.launch("display.yaml", "viewer:=false")
    live.until(lambda: enabled(panel) == {"joint_1", "joint_2", "joint_3", "joint_4"})
    put(live, panel, "joint_4", -1.0)
    live.until(lambda: panel._measured.get("joint_5") == 1.0)


def test_a_driver_is_shown_and_not_contradicted(live, panel):
    robot = Robot(live, ROBOT)
    driver = robot.node.create_publisher(JointState, "/joint_states", 10)
    live.until(lambda: panel._sliders)
    live.until(lambda: enabled(panel) == set())
    assert "robot" in panel._note.content
    driver.publish(JointState(name=["wheel", "lift", "?"], position=[7.0, float("nan"), 1.0]))
    live.until(lambda: panel._sliders["wheel"].value == pytest.approx(7.0 - 2 * math.pi))
    # A driver that hangs is in the graph, and sends nothing.
    panel._received_s = 0.0
    live.until(lambda: "No joint states are received" in panel._note.content)
    driver.publish(JointState(name=["wheel"], position=[7.0]))
    live.until(lambda: "No joint states are received" not in panel._note.content)
    # A value typed beside a slider that is switched off: viser lets it through.
    put(live, panel, "wheel", -1.0)
    live.until(lambda: panel._sliders["wheel"].value == pytest.approx(7.0 - 2 * math.pi))
    assert robot.joints["wheel"] == 7.0


def test_a_new_description_of_the_same_robot_keeps_the_pose_and_a_broken_one_is_told(live, panel):
    robot = Robot(live, ROBOT)
    live.until(lambda: robot.joints)
    put(live, panel, "wheel", 2.0)
    live.until(lambda: is_at(robot, wheel=2.0))
    robot.describe("<robot")
    live.until(lambda: panel._refusal.visible)
    robot.describe(ROBOT.replace('lower="0.01" upper="0.05"', 'lower="-1" upper="1"'))
    live.until(lambda: panel._sliders["lift"].min == -1)
    assert not panel._refusal.visible
    put(live, panel, "lift", 0.5)
    live.until(lambda: is_at(robot, lift=0.5, wheel=2.0))


# --- controllers --------------------------------------------------------------------------------

FORWARD = """
controller_manager:
  ros__parameters:
    update_rate: 100
    forward: {type: forward_command_controller/ForwardCommandController}
    joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
forward:
  ros__parameters:
    joints: [joint_1, joint_2, joint_3]
    interface_name: position
"""


def controlled(urdf, file):
    """Make a manager with mock hardware."""
    arguments = ["--ros-args", "--params-file", str(file)]
    return lambda context, executor: ManagerProcess(context, executor, urdf, arguments)


@pytest.fixture(scope="module")
def mock_urdf():
    return expand_xacro(MODEL, {"hardware": "mock"})


def switch(ros, words):
    done = ros.run(f"control {words}")
    assert done.returncode == 0, done.stderr


def test_sliders_move_the_robot_through_its_active_controllers(live, panel, mock_urdf, ros):
    file = package_share("teleop_controller") / "teleop_controllers.yaml"
    names = ["joint_state_broadcaster", "arm_controller", "gripper_controller"]
    robot = Robot(live, mock_urdf)
    live.until(lambda: panel._sliders)
    for _ in range(2):
        with spinning(controlled(mock_urdf, file)):
            live.until(lambda: "Controllers" in panel._note.content)
            assert enabled(panel) == set()
            for name in names:
                switch(ros, f"load_controller --set-state active {name}")
            live.until(lambda: enabled(panel) == {"joint_1", "joint_2", "joint_3", "joint_4"})
            put(live, panel, "joint_1", 1.0)
            # Sent off while the first one moves: that one goes on.
            live.until(lambda: robot.joints.get("joint_1", 0.0) > 0.1)
            put(live, panel, "joint_2", -0.5)
            assert panel._sliders["joint_1"].value == 1.0
            live.until(lambda: is_at(robot, joint_1=1.0, joint_2=-0.5, joint_3=0.0))
            put(live, panel, "joint_4", -1.0)
            live.until(lambda: is_at(robot, joint_4=-1.0, joint_5=1.0, joint_1=1.0))
            live.until(lambda: not panel._goals)
            switch(ros, "switch_controllers --deactivate arm_controller")
            live.until(lambda: enabled(panel) == {"joint_4"})
            put(live, panel, "joint_1", 0.0)
            live.until(lambda: abs(panel._sliders["joint_1"].value - 1.0) < 2e-3)
            switch(ros, "switch_controllers --activate arm_controller")
            live.until(lambda: "joint_1" in enabled(panel))
            live.choose(panel._all, "Center")
            live.until(lambda: is_at(robot, joint_1=0.0, joint_2=0.0))
        live.until(lambda: panel._take_over.visible)
        robot.joints.clear()


def test_a_controller_that_takes_positions_at_once_is_not_given_jumps(
    live, panel, mock_urdf, ros, tmp_path
):
    file = tmp_path / "forward.yaml"
    file.write_text(FORWARD)
    names = ["joint_state_broadcaster", "forward"]
    robot = Robot(live, mock_urdf)
    commands: list[float] = []
    robot.node.create_subscription(
        get_message("std_msgs/msg/Float64MultiArray"),
        "/forward/commands",
        lambda message: commands.append(message.data[0]),
        100,
    )
    with spinning(controlled(mock_urdf, file)):
        live.until(lambda: panel._sliders)
        for name in names:
            switch(ros, f"load_controller --set-state active {name}")
        # Before that the sliders are those of a robot that nobody moves.
        live.until(lambda: "<b>forward</b>" in panel._note.content)
        live.until(lambda: "joint_1" in enabled(panel))
        live.until(lambda: is_at(robot, joint_1=0.0))
        put(live, panel, "joint_1", 0.5)
        live.until(lambda: is_at(robot, joint_1=0.5, joint_2=0.0))
        steps = [after - before for before, after in itertools.pairwise(commands)]
        assert max(steps) <= 0.0201
        assert commands[-1] == 0.5
        # Nobody says any more where the joints are: nothing is sent on a guess.
        switch(ros, "switch_controllers --deactivate joint_state_broadcaster")
        live.until(lambda: "No joint states" in panel._note.content)
        assert enabled(panel) == set()
        switch(ros, "switch_controllers --activate joint_state_broadcaster")
        live.until(lambda: "joint_1" in enabled(panel))
        assert "No joint states" not in panel._note.content


# --- absurd states ------------------------------------------------------------------------------


@given(
    strategies.lists(strategies.sampled_from(["wheel", "lift", "m1", "", "x"])),
    strategies.lists(strategies.floats()),
    strategies.integers(-(2**31), 2**31 - 1),
)
def test_no_joint_state_is_too_strange(page_server, names, positions, sec):
    page = FakePage(page_server)
    panel = JointsPanel(page)
    state = JointState(name=names, position=positions)
    state.header.stamp.sec = sec
    panel.build()
    panel._specs = []
    panel._take_state(state)
    panel.tick()
    assert all(math.isfinite(value) for value in panel._measured.values())
    page_server.gui.reset()
