"""Servo moves the arm of a running simulation: by twists, poses, joint velocities, and by keys."""

import os
import re
import sys
import threading
from functools import partial
from typing import Any

import numpy as np
import pytest

import teleopctl
from teleopctl.control import ControllerManagerClient
from teleopctl.interfaces import get_message, get_service
from teleopctl.kinematics import GroupKinematics, KinematicModel, StatusCode, find_groups
from teleopctl.robot import RobotDescription
from teleopctl.testing import eventually
from tests.emulated_gamepad import EmulatedGamepad

TwistStamped = get_message("geometry_msgs/msg/TwistStamped")
PoseStamped = get_message("geometry_msgs/msg/PoseStamped")
JointJog = get_message("control_msgs/msg/JointJog")
JointState = get_message("sensor_msgs/msg/JointState")
ServoStatus = get_message("moveit_msgs/msg/ServoStatus")
CollisionObject = get_message("moveit_msgs/msg/CollisionObject")
SolidPrimitive = get_message("shape_msgs/msg/SolidPrimitive")
Marker = get_message("visualization_msgs/msg/Marker")
MarkerArray = get_message("visualization_msgs/msg/MarkerArray")
Bool = get_message("std_msgs/msg/Bool")
PERIOD_S = 0.02


class Hand:
    """A person's hand: publishes commands at 50 Hz, and sees where the gripper is."""

    def __init__(self, node):
        self._node = node
        description = RobotDescription.from_urdf(
            teleopctl.load_robot("package://teleop_description/urdf/teleop.urdf.xacro").urdf
        )
        self.kinematics = GroupKinematics(
            KinematicModel(description), find_groups(description).group()
        )
        self.positions: dict[str, float] = {}
        self.step = 1.0
        self.statuses: list[Any] = []
        self.twists = node.create_publisher(TwistStamped, "/servo_node/delta_twist_cmds", 10)
        self.poses = node.create_publisher(PoseStamped, "/servo_node/pose_target_cmds", 10)
        self.jogs = node.create_publisher(JointJog, "/servo_node/delta_joint_cmds", 10)
        node.create_subscription(JointState, "/joint_states", self._seen, 10)
        node.create_subscription(ServoStatus, "/servo_node/status", self.statuses.append, 100)
        eventually(lambda: self.positions and self.twists.get_subscription_count())

    def _seen(self, message):
        new = dict(zip(message.name, message.position, strict=True))
        self.step = max(abs(new[name] - self.positions.get(name, 0.0)) for name in new)
        self.positions = new

    def tool(self):
        """Position of the gripper in the world, m."""
        self.kinematics.set(self.kinematics.vector(self.positions))
        return self.kinematics.pose()[:3, 3]

    def is_near(self, joint, position):
        return abs(self.positions[joint] - position) < 0.05

    def is_still(self):
        return self.step < 1e-4

    def hold(self, publisher, message, until):
        """Publish a message at 50 Hz until a condition is met, then no more."""
        done = threading.Event()

        def publish():
            while not done.is_set():
                publisher.publish(message)
                done.wait(PERIOD_S)

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            return eventually(until)
        finally:
            done.set()
            thread.join()

    def stop(self):
        eventually(self.is_still)
        self.statuses.clear()

    def reason(self):
        """The last status that was no motion, or an empty text."""
        return next(
            (s.message for s in reversed(self.statuses) if s.code == StatusCode.INVALID), ""
        )


def twist(frame="world", *, linear=(0.0, 0.0, 0.0), angular=(0.0, 0.0, 0.0)):
    message = TwistStamped()
    message.header.frame_id = frame
    for part, values in ((message.twist.linear, linear), (message.twist.angular, angular)):
        part.x, part.y, part.z = values
    return message


@pytest.fixture(scope="module")
def arm(shared_ros):
    """The arm in simulation, bent, with servo."""
    shared_ros.launch("sim.yaml", "camera:=false")
    shared_ros.launch("servo.yaml")
    hand = Hand(shared_ros.node)
    _command(shared_ros, "arm_controller", "0.2, 0.4, -0.5")
    eventually(lambda: abs(hand.positions["joint_3"] + 0.5) < 0.01)
    hand.stop()
    return hand


def _command(ros, controller, positions):
    done = ros.run(
        f"topic pub --once /{controller}/commands std_msgs/msg/Float64MultiArray "
        f"'{{data: [{positions}]}}'"
    )
    assert done.returncode == 0, done.stderr


def test_a_twist_moves_the_gripper_along_it_and_it_stops_with_the_stream(arm):
    before = arm.tool()
    arm.hold(
        arm.twists,
        twist(linear=(0.0, 0.0, 0.3)),
        lambda: arm.tool()[2] - before[2] > 0.03,
    )
    arm.stop()
    moved = arm.tool() - before
    assert moved[2] < 0.2
    assert np.abs(moved[:2]).max() < 0.01


def test_a_twist_in_the_gripper_s_frame_moves_it_along_its_own_axes(arm):
    before = arm.tool()
    axis = arm.kinematics.pose()[:3, 1]
    arm.hold(
        arm.twists,
        twist("claw_support", linear=(0.0, -0.3, 0.0)),
        lambda: (arm.tool() - before) @ axis < -0.02,
    )
    arm.stop()


def test_joints_are_jogged_by_velocity_and_by_displacement(arm):
    before = arm.positions["joint_1"]
    jog = JointJog(joint_names=["joint_1"], velocities=np.array([-0.5]))
    arm.hold(arm.jogs, jog, lambda: arm.positions["joint_1"] < before - 0.05)
    arm.stop()
    before = arm.positions["joint_1"]
    arm.jogs.publish(JointJog(joint_names=["joint_1"], displacements=np.array([0.1])))
    eventually(lambda: abs(arm.positions["joint_1"] - before - 0.1) < 0.005)
    arm.stop()


def test_a_pose_is_approached(arm):
    target = arm.tool() + np.array([0.01, 0.01, -0.02])
    message = PoseStamped()
    message.header.frame_id = "world"
    at = message.pose.position
    at.x, at.y, at.z = map(float, target)
    message.pose.orientation.w = 1.0
    arm.hold(arm.poses, message, lambda: np.linalg.norm(arm.tool() - target) < 0.004)
    arm.stop()


@pytest.mark.parametrize(
    ("publisher", "message", "reason"),
    [
        ("twists", twist("nowhere", linear=(1.0, 0.0, 0.0)), "frame 'nowhere' .* unknown"),
        ("twists", twist(linear=(float("nan"), 0.0, 0.0)), "twist has a value that is not a fin"),
        ("poses", PoseStamped(), "quaternion of zeros"),
        (
            "jogs",
            JointJog(joint_names=["elbow"], velocities=np.array([1.0])),
            "names elbow; the group has joint_1, joint_2, joint_3",
        ),
        (
            "jogs",
            JointJog(joint_names=["joint_1"], velocities=np.array([1.0, 2.0])),
            "1 joint names have 2 velocities",
        ),
    ],
)
def test_a_command_that_cannot_be_obeyed_moves_nothing_and_says_why(
    arm, publisher, message, reason
):
    before = arm.tool()
    if publisher == "poses":
        message.pose.orientation.w = 0.0
    arm.hold(getattr(arm, publisher), message, lambda: re.search(reason, arm.reason()))
    assert arm.tool() == pytest.approx(before, abs=2e-3)
    arm.stop()


@pytest.mark.nightly
def test_a_trajectory_that_runs_wins(arm, shared_ros):
    goal = shared_ros.spawn(
        "action send_goal /arm_controller/follow_joint_trajectory "
        "control_msgs/action/FollowJointTrajectory '{trajectory: {joint_names: "
        "[joint_1, joint_2, joint_3], points: [{positions: [0.1, 0.3, -0.4], "
        "time_from_start: {sec: 3}}]}}'"
    )
    goal.wait_for_line("Goal accepted")
    # Servo may not know of the goal yet: the controller ignores what it sends.
    arm.hold(
        arm.twists,
        twist(linear=(0.0, 0.0, 1.0)),
        lambda: "/arm_controller executes a trajectory" in arm.reason(),
    )
    goal.wait_for_line("Goal finished with status: SUCCEEDED")
    eventually(lambda: abs(arm.positions["joint_2"] - 0.3) < 0.02)
    arm.stop()


def test_the_stop_of_the_robot_holds_servo(arm, shared_ros):
    button = shared_ros.run("stop --robot")
    assert button.returncode == 0
    before = arm.tool()
    arm.hold(
        arm.twists,
        twist(linear=(0.0, 0.0, 1.0)),
        lambda: "the robot is stopped by" in arm.reason(),
    )
    assert arm.tool() == pytest.approx(before, abs=2e-3)
    assert shared_ros.run("stop --robot --release").returncode == 0
    arm.stop()


def test_the_command_type_may_be_chosen_and_servo_paused(arm, shared_ros):
    def call(name, type_name, **fields):
        kind = get_service(type_name)
        client = shared_ros.node.create_client(kind, f"/servo_node/{name}")
        assert client.wait_for_service(10.0)
        return client.call(kind.Request(**fields))

    kinds = "moveit_msgs/srv/ServoCommandType"
    assert call("switch_command_type", kinds, command_type=0).success
    assert not call("switch_command_type", kinds, command_type=7).success
    paused = call("pause_servo", "std_srvs/srv/SetBool", data=True)
    assert (paused.success, paused.message) == (True, "Servoing disabled")
    again = call("pause_servo", "std_srvs/srv/SetBool", data=True)
    assert again.message == "Requested pause state is already active."
    assert call("pause_servo", "std_srvs/srv/SetBool", data=False).message == "Servoing enabled"
    before = arm.tool()
    arm.twists.publish(twist(linear=(0.0, 0.0, 1.0)))
    assert call("switch_command_type", kinds, command_type=1).success
    assert arm.tool() == pytest.approx(before, abs=1e-3)


def test_a_forward_controller_that_is_active_instead_takes_the_commands(arm, shared_ros):
    file = shared_ros.folder / "forward.yaml"
    file.write_text(
        "forward: {ros__parameters: {type: forward_command_controller/ForwardCommandController, "
        "joints: [joint_3, joint_1, joint_2], interface_name: position}}"
    )
    spawned = shared_ros.run(f"run controller_manager spawner forward --inactive -p {file}")
    assert spawned.returncode == 0, spawned.stderr
    client = ControllerManagerClient(shared_ros.node, "/controller_manager")
    assert client.switch_controllers(["forward"], ["arm_controller"])[0]
    before = arm.tool()
    # Servo chooses the controller when the manager publishes the switch.
    arm.hold(
        arm.twists,
        twist(linear=(0.0, 0.0, 0.3)),
        lambda: arm.tool()[2] - before[2] > 0.03,
    )
    arm.stop()
    assert np.abs((arm.tool() - before)[:2]).max() < 0.01
    assert client.switch_controllers(["arm_controller"], ["forward"])[0]


@pytest.mark.nightly
def test_an_obstacle_of_the_planning_scene_stops_the_gripper(arm, shared_ros):
    moving = shared_ros.launch("move.yaml", "servo:=false")
    objects = shared_ros.node.create_publisher(CollisionObject, "/collision_object", 10)
    eventually(objects.get_subscription_count)
    shown = []
    shared_ros.node.create_subscription(
        MarkerArray, "/servo_node/status_markers", lambda array: shown.extend(array.markers), 10
    )
    before = arm.tool()
    shelf = CollisionObject(id="shelf", operation=b"\x00")
    shelf.header.frame_id = "world"
    shelf.primitives = [SolidPrimitive(type=1, dimensions=np.array([0.3, 0.3, 0.1]))]
    shelf.pose.orientation.w = 1.0
    at = shelf.pose.position
    at.x, at.y, at.z = float(before[0]), float(before[1]), float(before[2]) - 0.45
    objects.publish(shelf)
    arm.hold(
        arm.twists,
        twist(linear=(0.0, 0.0, -0.3)),
        lambda: any(
            status.code == StatusCode.HALT_FOR_COLLISION and "'shelf'" in status.message
            for status in arm.statuses
        ),
    )
    arm.stop()
    assert 0.02 < before[2] - arm.tool()[2] < 0.4
    # The markers say the same, where it is: above the shelf.
    texts = [
        marker.text for marker in shown if marker.type == Marker.TEXT_VIEW_FACING and marker.text
    ]
    assert any("'shelf'" in text for text in texts)
    ball = next(each for each in shown if each.type == Marker.SPHERE and not each.action)
    assert ball.pose.position.z == pytest.approx(at.z + 0.05, abs=0.06)
    eventually(lambda: shown[-1].action == Marker.DELETE)
    # Other tests may come after this one in any place.
    shelf.operation = b"\x01"
    objects.publish(shelf)
    arm.hold(arm.twists, twist(linear=(0.0, 0.0, 0.3)), lambda: arm.tool()[2] > before[2])
    moving.stop()


@pytest.fixture
def device(shared_ros):
    """Function that runs teleop_device, and a dict that has its state."""
    state: dict[str, str] = {}
    kind = get_message("diagnostic_msgs/msg/DiagnosticStatus")
    seen = shared_ros.node.create_subscription(
        kind,
        "/teleop_device/state",
        lambda message: state.update({value.key: value.value for value in message.values}),
        10,
    )
    running = []

    def run(words: str) -> tuple[Any, dict[str, str]]:
        running.append(shared_ros.spawn(f"run teleop_device teleop_device {words}"))
        eventually(lambda: state.get("robot") and not state["problem"])
        return running[-1], state

    yield run
    for process in running:
        process.interrupt()
        assert process.wait() == 0
    shared_ros.node.destroy_subscription(seen)


@pytest.mark.skipif(os.name == "nt", reason="a named pipe")
def test_a_gamepad_moves_the_gripper_while_its_enable_button_is_held(arm, shared_ros, device):
    pad = EmulatedGamepad(shared_ros.folder / "js0")
    process, state = device(f"gamepad --ros-args -p dev:={pad.path}")
    before = arm.tool()
    pad.axis(4, -1.0)
    pad.button(4, is_down=True)
    eventually(lambda: arm.tool()[2] > before[2] + 0.02)
    eventually(lambda: state["holder"] == "/teleop_device (gamepad)")
    pad.button(4, is_down=False)
    arm.stop()
    pad.button(4, is_down=True)
    pad.button(5, is_down=True)
    eventually(lambda: arm.positions["joint_4"] < -0.2)
    # Unplugged: as if all were let go.
    pad.unplug()
    process.wait_for_line("js0 is gone; waiting for it")
    arm.stop()


class Leader:
    """An arm that a person moves: its states at 60 Hz, until it is silent."""

    def __init__(self, node, positions):
        self.positions = dict(positions)
        self._states = node.create_publisher(JointState, "/leader/joint_states", 1)
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._publish)
        self._thread.start()

    def _publish(self):
        while not self._done.wait(1.0 / 60.0):
            at = self.positions
            self._states.publish(JointState(name=list(at), position=list(at.values())))

    def fall_silent(self):
        self._done.set()
        self._thread.join()


def test_an_arm_follows_another_one_once_it_is_engaged(arm, shared_ros, device, tmp_path):
    mapping = tmp_path / "mine.yaml"
    mapping.write_text(
        "device: leader\njoints: {lead_1: joint_1}\nsigns: {lead_1: -1}\n"
        "gripper: {joint: jaw, closed: 0.0, open: 1.0}\n"
    )
    # A slow machine's leader is no silent one.
    _, state = device(f"leader --mapping {mapping} --ros-args -p leader_timeout:=20.0")
    kind = get_service("std_srvs/srv/SetBool")
    client = shared_ros.node.create_client(kind, "/teleop_device/engage")
    assert client.wait_for_service(30.0)

    def call(*, engages):
        return client.call(kind.Request(data=engages))

    assert "The leader is silent on /leader/joint_states" in call(engages=True).message
    at = arm.positions["joint_1"]
    start = {name: arm.positions[name] for name in ("joint_2", "joint_3")}
    leader = Leader(shared_ros.node, {**start, "lead_1": -at, "jaw": 0.5})
    try:
        leader.positions["lead_1"] -= 0.3
        eventually(lambda: call(engages=True).success)
        eventually(lambda: arm.is_near("joint_1", at + 0.3) and state["doing"] == "follows")
        eventually(lambda: state["holder"] == "/teleop_device (leader)")
        eventually(lambda: arm.is_near("joint_4", -0.785))
        leader.positions["lead_1"] += 0.2
        eventually(lambda: arm.is_near("joint_1", at + 0.1))
        # What no hand does.
        leader.positions["joint_2"] -= 0.5
        eventually(lambda: "The leader has jumped at joint_2" in state["problem"])
        arm.stop()
        assert arm.is_near("joint_2", start["joint_2"])
        del leader.positions["joint_3"]
        eventually(lambda: "no joint for joint_3" in call(engages=True).message)
    finally:
        leader.fall_silent()


def test_a_leader_that_is_the_follower_is_refused(shared_ros):
    done = shared_ros.run("run teleop_device teleop_device --leader /")
    assert done.returncode == 1
    assert "The leader of /joint_states is the follower itself" in done.stderr


@pytest.mark.skipif(os.name == "nt", reason="a pseudo-terminal")
def test_keys_move_the_gripper_and_close_it(arm, shared_ros):
    from tests.system.terminal import Terminal

    # Closed, at its upper limit, so that the first press opens it: other tests leave it half open.
    _command(shared_ros, "gripper_controller", "0.0")
    eventually(partial(arm.is_near, "joint_4", 0.0))
    argv = [sys.executable, "-m", "teleopctl", "run", "teleop_keyboard"]
    terminal = Terminal(argv, shared_ros.env, shared_ros.folder, is_controlling=True)
    try:
        terminal.until(r"gripper, axes of the base \| stopped .* 1 subscriber")
        before = arm.tool()

        def lift():
            terminal.press("\x1b[5~")
            return arm.tool()[2] > before[2] + 0.02

        eventually(lift)
        terminal.press(" ")
        arm.stop()
        terminal.press("1")
        terminal.until(r"joint_1 \| stopped")
        at = arm.positions["joint_1"]

        def turn():
            terminal.press("+")
            return arm.positions["joint_1"] > at + 0.05

        eventually(turn)
        arm.stop()
        for end in (-1.5708, 0.0, -1.5708):
            terminal.press("g")
            eventually(partial(arm.is_near, "joint_4", end))
        terminal.press("q")
        assert terminal.wait() == 0
        assert "Stopped." in terminal.text
    except BaseException:
        terminal.kill()
        raise


def test_the_keyboard_refuses_to_run_without_a_terminal(shared_ros):
    done = shared_ros.run("run teleop_keyboard", input="")
    assert done.returncode == 2
    assert "standard input is no terminal" in done.stderr
    assert "/servo_node/delta_twist_cmds" in done.stderr
