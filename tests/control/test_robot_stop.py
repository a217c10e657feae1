"""The robot's stop: controllers decelerate within limits, refuse commands, and resume at rest.

Joints have velocity limits of 1 rad/s, so that without acceleration limits they decelerate by
5 rad/s²; cycles come at 100 Hz.
"""

import itertools
import math
from typing import Any

import pytest

from teleopctl.control.robot_stop import common_decelerations, stopping_state
from teleopctl.errors import InvalidFileError
from teleopctl.interfaces import get_action, get_message
from teleopctl.node import GoalState
from teleopctl.robot import JointLimits, read_acceleration_limits, stop_decelerations
from teleopctl.testing import ControlStack, serial_robot

FORWARD = "forward_command_controller/ForwardCommandController"
TRAJECTORY = "joint_trajectory_controller/JointTrajectoryController"
GRIPPER = "position_controllers/GripperActionController"
PID = "pid_controller/PidController"
DIFF_DRIVE = "diff_drive_controller/DiffDriveController"
FollowJointTrajectory = get_action("control_msgs/action/FollowJointTrajectory")
GripperCommand = get_action("control_msgs/action/GripperCommand")
MultiDof = get_message("control_msgs/msg/MultiDOFCommand")
TwistStamped = get_message("geometry_msgs/msg/TwistStamped")
Floats = get_message("std_msgs/msg/Float64MultiArray")
Trajectory = get_message("trajectory_msgs/msg/JointTrajectory")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
DECELERATION = 5.0
PERIOD = 0.01
NAN = math.nan


class Robot:
    """Joints at 0 with mock hardware, and controllers that a test loads."""

    def __init__(
        self, joints=1, commands=("position", "velocity"), limits='velocity="1"', extra_joints=""
    ):
        urdf = serial_robot(
            joints,
            initial=(0.0,),
            commands=commands,
            states=("position", "velocity"),
            limits=f'lower="-10" upper="10" effort="10" {limits}',
            extra_joints=extra_joints,
            # Mock hardware has no dynamics for efforts.
            parameters=""
            if "effort" in commands
            else '<param name="calculate_dynamics">true</param>',
        )
        self.stack = ControlStack(urdf, enforce_limits=False)
        self.joints = [f"joint{number + 1}" for number in range(joints)]
        self.stop_state = self.stack.manager.robot_stop

    def load(self, name, kind, **parameters):
        controller = self.stack.load_controller(name, kind, parameters)
        self.stack.activate(name)
        return controller

    def load_trajectory_controller(self, **parameters):
        return self.load(
            "arm",
            TRAJECTORY,
            joints=self.joints,
            command_interfaces=["position"],
            state_interfaces=["position", "velocity"],
            **parameters,
        )

    def send_goal(self, *positions, seconds=1.0):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory = trajectory(self.joints, positions, seconds)
        return self.send("arm/follow_joint_trajectory", goal)

    def send(self, action, goal):
        handle: Any = self.stack.action_servers[action].send_goal(goal)
        return handle

    def command(self, joint=1, interface="position"):
        return self.stack.command(f"joint{joint}/{interface}")

    def measure(self, position, velocity):
        """Let the first joint measure something, whatever is commanded, from now on."""
        hardware: Any = self.stack.resources.components["Hardware"].hardware
        hardware.read = lambda *_: None
        self.stack.resources.state_interfaces["joint1/position"].value = position
        self.stack.resources.state_interfaces["joint1/velocity"].value = velocity

    def commands_until_rest(self, cycles=60, joint=1, interface="position"):
        values = []
        for _ in range(cycles):
            self.stack.step()
            values.append(self.command(joint, interface))
        return values

    def stop(self, by="/button"):
        self.stop_state.hold(by)

    def release(self):
        self.stop_state.hold("")

    def refusals(self, name):
        return [line for line in self.stack.nodes[name].log.texts() if "is refused" in line]


def trajectory(joints, positions, seconds):
    point = Point(positions=list(positions))
    point.time_from_start.sec = int(seconds)
    point.time_from_start.nanosec = round(seconds % 1 * 1e9)
    return Trajectory(joint_names=list(joints), points=[point])


def differences(values):
    return [later - earlier for earlier, later in itertools.pairwise(values)]


def assert_decelerates(values, speed, deceleration=DECELERATION):
    """Check positions per cycle: from a speed to rest, within a deceleration, without a step."""
    speeds = [step / PERIOD for step in differences(values)]
    assert all(0.0 <= abs(now) <= abs(speed) + 1e-6 for now in speeds)
    assert all(abs(s) <= deceleration * PERIOD + 1e-6 for s in differences([speed, *speeds]))
    assert speeds[-1] == 0.0


# -- a trajectory ---------------------------------------------------------------------------------


def test_a_trajectory_decelerates_to_rest_and_its_goal_is_aborted_with_who_stopped():
    robot = Robot()
    robot.load_trajectory_controller()
    goal = robot.send_goal(1.0, seconds=2.0)
    robot.stack.step(50)
    before = robot.command()
    robot.stop("/button")
    values = robot.commands_until_rest()
    assert_decelerates([before, *values], 0.5)
    # v²/2a, from the position that was commanded last.
    assert values[-1] == pytest.approx(before + 0.5**2 / (2 * DECELERATION), abs=1e-4)
    server = robot.stack.action_servers["arm/follow_joint_trajectory"]
    assert GoalState(goal.status) is GoalState.ABORTED
    assert server.result(goal).error_string == "The robot is stopped by /button"


def test_joints_that_stop_stay_on_the_line_on_which_they_move():
    robot = Robot(2)
    robot.load_trajectory_controller()
    robot.send_goal(1.0, -0.5, seconds=2.0)
    robot.stack.step(50)
    robot.stop()
    first, second = [], []
    for _ in range(30):
        robot.stack.step()
        first.append(robot.command(1))
        second.append(robot.command(2))
    assert second == pytest.approx([-value / 2 for value in first], abs=1e-6)


def test_after_the_release_a_trajectory_controller_stays_where_it_stopped_and_takes_goals():
    robot = Robot()
    robot.load_trajectory_controller()
    robot.send_goal(1.0)
    robot.stack.step(50)
    robot.stop()
    stopped = robot.commands_until_rest()[-1]
    robot.release()
    assert robot.commands_until_rest(20) == pytest.approx([stopped] * 20)
    goal = robot.send_goal(0.0)
    robot.stack.step(150)
    assert robot.command() == pytest.approx(0.0)
    assert GoalState(goal.status) is GoalState.SUCCEEDED


def test_while_stopped_goals_trajectories_and_commands_are_refused_each_kind_with_one_line():
    robot = Robot()
    robot.load_trajectory_controller()
    robot.stack.step()
    robot.stop("/button")
    node = robot.stack.nodes["arm"]
    for _ in range(3):
        assert robot.send_goal(1.0) is None
        node.receive("~/joint_trajectory", trajectory(["joint1"], [1.0], 1.0))
        node.receive("~/commands", Floats(data=[1.0]))
    robot.stack.step(200)
    assert robot.command() == 0.0
    assert robot.refusals("arm") == [
        f"{what} is refused: the robot is stopped by /button. 'teleopctl stop --robot --release' "
        "releases it."
        for what in ("The action goal", "The trajectory", "The command on ~/commands")
    ]


def test_an_arm_that_is_blocked_stops_where_it_is_commanded():
    """It pushes on as it does, and does not jump when the obstacle is taken away."""
    robot = Robot()
    robot.load_trajectory_controller()
    robot.send_goal(1.0, seconds=2.0)
    robot.stack.step(50)
    robot.measure(-1.0, 0.0)
    before = robot.command()
    robot.stop()
    assert robot.commands_until_rest(5) == pytest.approx([before] * 5)


def test_a_speed_scaling_of_half_stops_from_half_the_speed():
    robot = Robot()
    controller = robot.load_trajectory_controller()
    controller.speed_scaling = 0.5
    robot.send_goal(1.0, seconds=2.0)
    robot.stack.step(50)
    before = robot.command()
    robot.stop()
    values = robot.commands_until_rest()
    assert values[-1] == pytest.approx(before + 0.25**2 / (2 * DECELERATION), abs=1e-4)


def test_a_trajectory_on_velocity_commands_ends_at_rest():
    robot = Robot(commands=("velocity",))
    robot.load(
        "arm",
        TRAJECTORY,
        joints=["joint1"],
        command_interfaces=["velocity"],
        state_interfaces=["position", "velocity"],
        **{"gains.joint1.p": 5.0, "gains.joint1.ff_velocity_scale": 1.0},
    )
    robot.send_goal(1.0, seconds=2.0)
    robot.stack.step(50)
    robot.stop()
    speeds = robot.commands_until_rest(200, interface="velocity")
    assert abs(speeds[-1]) < 1e-3
    assert max(map(abs, differences(speeds))) <= 1.5 * DECELERATION * PERIOD


# -- controllers that write what they receive -----------------------------------------------------


def test_a_position_that_a_forward_controller_streams_decelerates():
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    node, position = robot.stack.nodes["forward"], 0.0
    for _ in range(50):
        position += 0.5 * PERIOD
        node.receive("~/commands", Floats(data=[position]))
        robot.stack.step()
    robot.stop()
    values = []
    for _ in range(60):
        position += 0.5 * PERIOD
        node.receive("~/commands", Floats(data=[position]))
        values += robot.commands_until_rest(1)
    assert_decelerates([0.25, *values], 0.5)
    assert len(robot.refusals("forward")) == 1
    robot.release()
    robot.stack.step(5)
    assert robot.command() == values[-1]
    node.receive("~/commands", Floats(data=[0.0]))
    robot.stack.step()
    assert robot.command() == 0.0


def test_a_velocity_command_goes_to_zero_within_the_limit_and_stays():
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="velocity")
    robot.stack.nodes["forward"].receive("~/commands", Floats(data=[-1.0]))
    robot.stack.step(2)
    robot.stop()
    speeds = robot.commands_until_rest(30, interface="velocity")
    assert speeds == pytest.approx([min(0.0, -1.0 + 0.05 * n) for n in range(1, 31)])


# Half a metre from the axis: 0.5 kg m².
MASS = (
    '<joint name="fixed" type="fixed"><parent link="link1"/><child link="mass"/></joint>'
    '<link name="mass"><inertial><origin xyz="0 0.5 0"/><mass value="2"/>'
    '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>'
)


class EffortRobot(Robot):
    """Robot with a joint of an inertia, which moves by its effort against a load."""

    def __init__(self, speed, load, inertia=0.5):
        super().__init__(commands=("position", "velocity", "effort"), extra_joints=MASS)
        self.load("forward", FORWARD, joints=["joint1"], interface_name="effort")
        self.stack.nodes["forward"].receive("~/commands", Floats(data=[3.0]))
        self.stack.step()
        self.stop()
        hardware: Any = self.stack.resources.components["Hardware"].hardware
        states = self.stack.resources.state_interfaces
        self.position, self.speed = states["joint1/position"], states["joint1/velocity"]
        self.speed.value = speed

        def move(*_):
            self.speed.value += (self.command(interface="effort") - load) / inertia * PERIOD
            self.position.value += self.speed.value * PERIOD

        hardware.read = move


def test_an_effort_that_carries_a_joint_goes_on_while_stopped():
    robot = EffortRobot(speed=0.0, load=3.0)
    assert robot.commands_until_rest(100, interface="effort") == [3.0] * 100
    assert robot.position.value == 0.0


@pytest.mark.parametrize("inertia", [0.5, 5.0], ids=["as described", "with a heavy rotor"])
@pytest.mark.parametrize("load", [3.0, 0.0])
def test_a_joint_with_effort_commands_comes_to_rest_and_is_held(load, inertia):
    robot = EffortRobot(speed=1.0, load=load, inertia=inertia)
    efforts = robot.commands_until_rest(3000, interface="effort")
    assert max(map(abs, efforts)) <= 10.0
    assert efforts[-1] == pytest.approx(load, abs=1e-3)
    assert robot.speed.value == pytest.approx(0.0, abs=1e-3)
    # 1 rad/s ends after 0.1 rad; at 100 Hz the spring has 10 rad/s.
    assert robot.position.value == pytest.approx(0.1 + (3.0 - load) / (0.5 * 10.0**2), abs=0.05)


def test_an_effort_command_without_an_inertia_is_zero_while_stopped():
    robot = Robot(commands=("position", "velocity", "effort"))
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="effort")
    robot.stack.nodes["forward"].receive("~/commands", Floats(data=[3.0]))
    robot.stack.step()
    robot.stop()
    assert robot.commands_until_rest(2, interface="effort") == [0.0, 0.0]


def test_a_joint_far_behind_a_step_of_its_command_decelerates_from_where_it_is():
    """A drive is on its way to a far position: it must not go on to it."""
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    robot.stack.nodes["forward"].receive("~/commands", Floats(data=[2.0]))
    robot.measure(0.5, 1.0)
    robot.stack.step()
    assert robot.command() == 2.0
    robot.stop()
    values = robot.commands_until_rest()
    assert values[0] < 0.52
    assert values[-1] == pytest.approx(0.5 + 1.0 / (2 * DECELERATION))


def test_a_joint_near_a_command_that_stands_still_decelerates_from_where_it_is():
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    robot.stack.nodes["forward"].receive("~/commands", Floats(data=[0.6]))
    for _ in range(15):
        robot.measure(0.5, 0.5)
        robot.stack.step()
    robot.stop()
    assert robot.commands_until_rest()[-1] == pytest.approx(0.5 + 0.5**2 / (2 * DECELERATION))


def streamed(robot, *values):
    """Command positions to the first joint, one in each cycle."""
    for value in values:
        robot.stack.nodes["forward"].receive("~/commands", Floats(data=[value]))
        robot.stack.step()


@pytest.mark.parametrize(
    "commands",
    [
        pytest.param([0.6], id="of one cycle ago"),
        pytest.param([0.6] * 15, id="that is repeated in each cycle"),
        pytest.param([0.48, 0.485, 0.49, 0.6], id="within a stream of positions"),
    ],
)
def test_a_joint_near_a_step_decelerates_from_where_it_is(commands):
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    robot.measure(0.5, 0.5)
    streamed(robot, *commands)
    robot.stop()
    assert robot.commands_until_rest()[-1] == pytest.approx(0.5 + 0.5**2 / (2 * DECELERATION))


def test_a_joint_behind_a_stream_of_positions_decelerates_from_its_command():
    """A servo lags behind: from its place the command would jump back."""
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    robot.measure(0.5, 0.5)
    streamed(robot, *(0.5 + 0.005 * number for number in range(20)))
    robot.stop()
    assert_decelerates([0.595, *robot.commands_until_rest()], 0.5)


def test_a_step_that_is_young_is_given_up_by_a_joint_at_rest_and_an_older_one_is_kept():
    """A joint that still rests after a tenth of a second is held back, as fingers are."""
    for cycles, held in ((1, 0.5), (15, 0.6)):
        robot = Robot()
        robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
        robot.measure(0.5, 0.0)
        streamed(robot, 0.6)
        robot.stack.step(cycles)
        robot.stop()
        assert robot.commands_until_rest(5) == [held] * 5


def test_a_joint_that_begins_to_follow_a_step_only_after_the_stop_is_held_back():
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    robot.measure(0.0, 0.0)
    robot.stack.nodes["forward"].receive("~/commands", Floats(data=[2.0]))
    robot.stack.step()
    robot.stop()
    robot.stack.step()
    robot.measure(0.01, 0.3)
    assert robot.commands_until_rest()[-1] == pytest.approx(0.01 + 0.3**2 / (2 * DECELERATION))


# -- grippers, PIDs, mobile bases -----------------------------------------------------------------


@pytest.mark.parametrize("wanted", [2.0, 0.6])
def test_fingers_on_their_way_stop_and_their_goal_is_aborted(wanted):
    """Also fast fingers near their goal, which would be there in a tenth of a second."""
    robot = Robot()
    robot.load("gripper", GRIPPER, joint="joint1")
    robot.stack.step()
    goal = GripperCommand.Goal()
    goal.command.position = wanted
    handle = robot.send("gripper/gripper_cmd", goal)
    robot.measure(0.5, 0.5)
    robot.stack.step()
    robot.stop()
    held = robot.commands_until_rest()[-1]
    assert held == pytest.approx(0.5 + 0.5**2 / (2 * DECELERATION))
    assert GoalState(handle.status) is GoalState.ABORTED
    assert robot.send("gripper/gripper_cmd", goal) is None
    robot.release()
    robot.stack.step()
    assert robot.command() == held


def test_fingers_around_an_object_keep_their_grip():
    robot = Robot()
    robot.load("gripper", GRIPPER, joint="joint1", stall_timeout=0.05, allow_stalling=True)
    robot.stack.step()
    goal = GripperCommand.Goal()
    goal.command.position = 2.0
    handle = robot.send("gripper/gripper_cmd", goal)
    robot.measure(0.5, 0.0)
    robot.stack.step(20)
    assert GoalState(handle.status) is GoalState.SUCCEEDED
    robot.stop()
    assert robot.commands_until_rest(5) == [2.0] * 5


def test_a_pid_holds_the_position_it_controls_by_effort():
    robot = Robot(commands=("position", "velocity", "effort"))
    robot.load(
        "pid",
        PID,
        dof_names=["joint1"],
        command_interface="effort",
        reference_and_state_interfaces=["position"],
        **{"gains.joint1.p": 10.0},
    )
    robot.stack.nodes["pid"].receive("~/reference", MultiDof(dof_names=["joint1"], values=[0.1]))
    robot.stack.step()
    robot.stop()
    robot.stack.nodes["pid"].receive("~/reference", MultiDof(dof_names=["joint1"], values=[5.0]))
    assert robot.commands_until_rest(5, interface="effort") == pytest.approx([1.0] * 5)
    assert len(robot.refusals("pid")) == 1


def test_wheels_of_a_mobile_base_stop_together_so_that_the_base_stays_on_its_arc():
    robot = Robot(2)
    robot.load(
        "base",
        DIFF_DRIVE,
        left_wheel_names=["joint1"],
        right_wheel_names=["joint2"],
        wheel_separation=1.0,
        wheel_radius=1.0,
        cmd_vel_timeout=0.0,
    )
    command = TwistStamped()
    command.twist.linear.x, command.twist.angular.z = 0.6, 0.4
    node = robot.stack.nodes["base"]
    node.receive("~/cmd_vel", command)
    robot.stack.step(2)
    left, right = robot.command(1, "velocity"), robot.command(2, "velocity")
    robot.stop()
    for _ in range(40):
        node.receive("~/cmd_vel", command)
        robot.stack.step()
        now = robot.command(1, "velocity"), robot.command(2, "velocity")
        assert now[0] * right == pytest.approx(now[1] * left, abs=1e-9)
    assert now == (0.0, 0.0)
    robot.release()
    robot.stack.step(2)
    assert robot.command(1, "velocity") == 0.0


# -- controllers of others, switches --------------------------------------------------------------


def test_a_controller_that_knows_nothing_of_stops_is_stopped_and_restarted_at_the_release():
    robot = Robot()
    recorder = robot.load("own", "tests.control.fakes:Recorder", commands=["joint1/position"])
    update = recorder.update
    plan = itertools.count(1)

    def advance(time_ns, period):
        recorder.command_interfaces[0].value = 0.5 * PERIOD * next(plan)
        return update(time_ns, period)

    recorder.update = advance
    robot.stack.step(50)
    before = robot.command()
    robot.stop()
    assert_decelerates([before, *robot.commands_until_rest()], 0.5)
    recorder.calls.clear()
    robot.release()
    robot.stack.step()
    assert recorder.calls == ["deactivate", "activate", "update"]


def test_a_controller_that_is_activated_while_stopped_is_stopped_too():
    robot = Robot()
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="position")
    robot.stop()
    robot.stack.step()
    robot.stack.deactivate("forward")
    robot.load_trajectory_controller()
    robot.stack.step()
    assert robot.send_goal(1.0) is None


def test_a_controller_whose_stop_raises_does_not_keep_the_robot_from_stopping():
    robot = Robot(2)
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="velocity")
    other = robot.load("other", FORWARD, joints=["joint2"], interface_name="velocity")
    for name in ("forward", "other"):
        robot.stack.nodes[name].receive("~/commands", Floats(data=[0.5]))
    robot.stack.step(2)

    def on_stop():
        raise RuntimeError("on purpose")

    other.on_stop = on_stop
    robot.stop()
    robot.stack.step(30)
    assert (robot.command(1, "velocity"), robot.command(2, "velocity")) == (0.0, 0.0)
    assert any("raised in on_stop" in line for line in robot.stack.log.texts())


def test_a_reset_of_the_simulation_leaves_the_robot_stopped_where_it_is():
    robot = Robot()
    robot.load_trajectory_controller()
    robot.send_goal(1.0, seconds=2.0)
    robot.stack.step(50)
    robot.stop()
    robot.stack.step(2)
    robot.measure(-0.5, 0.0)
    robot.stack.step(period_ns=-1_000_000_000)
    assert robot.commands_until_rest(5) == pytest.approx([-0.5] * 5)
    assert robot.send_goal(1.0) is None


def test_a_stop_while_nothing_is_measured_ends_the_motion_all_the_same():
    robot = Robot()
    robot.load_trajectory_controller()
    robot.send_goal(1.0, seconds=2.0)
    robot.stack.step(50)
    robot.measure(NAN, NAN)
    robot.stack.step()
    before = robot.command()
    robot.stop()
    values = robot.commands_until_rest()
    assert_decelerates([before, *values], 0.5)


def test_a_stop_in_the_cycle_in_which_a_controller_fails_stops_the_others():
    robot = Robot(2)
    recorder = robot.load("own", "tests.control.fakes:Recorder", commands=["joint2/position"])
    robot.load("forward", FORWARD, joints=["joint1"], interface_name="velocity")
    robot.stack.nodes["forward"].receive("~/commands", Floats(data=[0.5]))
    robot.stack.step(2)
    recorder.failing = ("update", "raise")
    robot.stop()
    robot.stack.step(30)
    assert robot.command(1, "velocity") == 0.0


# -- limits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "command_speed", "position", "speed", "start"),
    [
        pytest.param(1.0, 0.5, 0.9, 0.5, (1.0, 0.5), id="follows its command"),
        pytest.param(1.0, NAN, 0.9, 0.5, (1.0, 0.5), id="follows a command of unknown speed"),
        pytest.param(2.0, 0.0, 0.5, 1.0, (0.5, 1.0), id="on its way to a step"),
        pytest.param(2.0, 0.0, 0.5, 0.0, (2.0, 0.0), id="stands away from its command"),
        pytest.param(NAN, NAN, 0.5, 1.0, (0.5, 1.0), id="no command yet"),
        pytest.param(1.0, 0.5, NAN, NAN, (1.0, 0.5), id="nothing is measured"),
    ],
)
def test_a_joint_decelerates_from_its_command_or_from_where_it_is(
    command, command_speed, position, speed, start
):
    assert stopping_state(command, command_speed, position, speed) == start


def test_joints_stop_at_the_same_time():
    assert common_decelerations([1.0, -0.5, 0.0], [5.0, 5.0, 5.0]) == [5.0, 2.5, 5.0]
    assert common_decelerations([1.0], [math.inf]) == [math.inf]


def test_decelerations_come_from_the_acceleration_limits_else_from_the_velocity_limit():
    limits = {
        "of_file": JointLimits(velocity=1.0, acceleration=9.0),
        "of_tag": JointLimits(velocity=1.0, acceleration=4.0, deceleration=3.0),
        "of_velocity": JointLimits(velocity=1.0),
        "unlimited": JointLimits(),
    }
    assert stop_decelerations(limits, {"of_file": 2.0}) == (
        {"of_file": 2.0, "of_tag": 3.0, "of_velocity": 5.0, "unlimited": math.inf},
        ["of_velocity"],
    )


def test_the_joint_limits_file_of_moveit_is_read(tmp_path):
    file = tmp_path / "joint_limits.yaml"
    file.write_text(
        """
        default_velocity_scaling_factor: 0.1
        joint_limits:
          joint1: {has_velocity_limits: true, max_velocity: 2.6, has_acceleration_limits: true,
                   max_acceleration: 3.5}
          joint2: {has_acceleration_limits: false, max_acceleration: 9.0}
          joint3: {has_acceleration_limits: true, max_acceleration: 3,
                   has_deceleration_limits: true, max_deceleration: 4}
        """
    )
    assert read_acceleration_limits(file) == {"joint1": 3.5, "joint3": 4.0}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("a: 1", "has no 'joint_limits'"),
        ("a: [", "is not YAML"),
        (
            "joint_limits: {j: {has_acceleration_limits: true}}",
            "max_acceleration of joint 'j' must be a number above 0, got None",
        ),
    ],
)
def test_a_bad_joint_limits_file_is_refused(tmp_path, text, problem):
    file = tmp_path / "joint_limits.yaml"
    file.write_text(text)
    with pytest.raises(InvalidFileError, match=problem):
        read_acceleration_limits(file)
