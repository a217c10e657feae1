"""The stop of a simulated robot whose joints are on the way to a step of their command.

Manager and controllers are the real ones in lockstep with the real physics, in one thread. Speeds
are those at the control ticks, as controllers see them.
"""

import itertools
import math

import pytest

from teleopctl.interfaces import AllowableParameterValue, get_message, set_stamp
from teleopctl.sim.building import simulate
from teleopctl.sim.ports import reported_joints
from teleopctl.testing import ControlStack
from tests.samples import sample
from tests.sim.robots import joint, link

FORWARD = "forward_command_controller/ForwardCommandController"
TRAJECTORY = "joint_trajectory_controller/JointTrajectoryController"
Floats = get_message("std_msgs/msg/Float64MultiArray")
JointState = get_message("sensor_msgs/msg/JointState")
Trajectory = get_message("trajectory_msgs/msg/JointTrajectory")
Point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
LIMIT = 'lower="-3" upper="3" effort="40" velocity="1"'
# A velocity limit of 1 rad/s over 0.2 s.
DECELERATION = 5.0
# A drive follows its set-point, whose speed changes in steps, with a lag of a few milliseconds.
TOLERANCE = 1.3
JOINTS = ["turn", "lift"]


def command_tag(name: str) -> str:
    states = '<state_interface name="position"/><state_interface name="velocity"/>'
    return f'<joint name="{name}"><command_interface name="position"/>{states}</joint>'


ARM = f"""<robot name="arm"><link name="world"/>{link("turn_link")}{link("lift_link")}
  {joint("turn", "world", "turn_link", axis="0 0 1", limit=LIMIT)}
  {joint("lift", "turn_link", "lift_link", axis="1 0 0", limit=LIMIT)}
  <ros2_control name="hardware" type="system"><hardware>
    <plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>
    {"".join(map(command_tag, JOINTS))}</ros2_control></robot>"""


class Robot:
    """An arm of two joints in simulation, with a controller, by default a forward controller."""

    def __init__(
        self,
        rate_hz: int,
        urdf: str = ARM,
        kind: str = FORWARD,
        **parameters: AllowableParameterValue,
    ) -> None:
        self.period_s = 1.0 / rate_hz
        self.simulation = simulate(
            urdf, control_period_ns=10**9 // rate_hz, warn=lambda _: None
        ).simulation
        self.stack = ControlStack(urdf, update_rate=rate_hz)
        (component,) = self.stack.resources.components.values()
        component.hardware.set_cycle(self._cycle)
        given = parameters or {"interface_name": "position"}
        self.stack.load_controller("controller", kind, {"joints": JOINTS, **given})
        self.stack.activate("controller")
        self._reported = reported_joints(self.simulation.model)
        self.positions: list[list[float]] = []
        self.speeds: list[list[float]] = []

    def _cycle(self, time_ns: int) -> None:
        self.stack.time_ns = time_ns
        self.stack.cycle.run(time_ns)

    def command(self, *positions: float) -> None:
        self.stack.nodes["controller"].receive("~/commands", Floats(data=list(positions)))

    def stop(self) -> None:
        self.stack.manager.robot_stop.hold("/button")
        self.positions.clear()
        self.speeds.clear()

    def run(self, seconds: float) -> None:
        """Exchange states and commands at each tick, and record positions and speeds."""
        simulation = self.simulation
        answers = self.stack.node.published("/robot_joint_commands")
        for _ in range(round(seconds / self.period_s)):
            simulation.read()
            state = JointState(
                name=[simulation.joint_names[index] for index in self._reported],
                position=simulation.positions[self._reported],
                velocity=simulation.velocities[self._reported],
                effort=simulation.efforts[self._reported],
            )
            self.positions.append(list(state.position))
            self.speeds.append(list(state.velocity))
            set_stamp(state.header.stamp, self.stack.start_ns + simulation.time_ns)
            self.stack.node.receive("/robot_joint_states", state)
            command = answers.pop()
            simulation.apply(list(command.name), list(command.position))
            simulation.step(simulation.steps_per_period)

    def decelerations(self, joint: int) -> list[float]:
        """Return by how much the joint's speed falls in each period since the stop, per second."""
        speeds = [abs(row[joint]) for row in self.speeds]
        return [(before - after) / self.period_s for before, after in itertools.pairwise(speeds)]


def stopped_after(age_s: float, *step: float, rate_hz: int = 100, urdf: str = ARM) -> Robot:
    """Return a robot that was stopped this long after a step, at rest again."""
    robot = Robot(rate_hz, urdf)
    robot.run(0.2)
    robot.command(*step)
    robot.run(age_s)
    robot.stop()
    robot.run(0.8)
    return robot


@pytest.mark.parametrize("age_s", sample([0.01, 0.02, 0.05, 0.1, 0.15, 0.3], 3))
@pytest.mark.parametrize("size", [0.05, 0.2, -2.0], ids=lambda size: f"{size} rad")
def test_joints_that_follow_a_step_decelerate_within_limits(size: float, age_s: float) -> None:
    robot = stopped_after(age_s, size, size / 2)
    # At the end of a step of hundredths of a radian the drive brakes already, and goes on to it.
    brakes = (size, age_s) == (0.05, 0.05)
    tolerance, faster = (1.7, 0.02) if brakes else (TOLERANCE, 0.01)
    for number in range(2):
        assert max(robot.decelerations(number)) <= tolerance * DECELERATION
        assert abs(robot.speeds[-1][number]) < 1e-3
        speeds = [abs(row[number]) for row in robot.speeds]
        assert max(speeds) <= speeds[0] + faster


@pytest.mark.parametrize("rate_hz", [10, 1000])
def test_also_at_other_control_rates(rate_hz: int) -> None:
    robot = stopped_after(0.3, 1.5, -1.0, rate_hz=rate_hz)
    for number in range(2):
        assert max(robot.decelerations(number)) <= TOLERANCE * DECELERATION


@pytest.mark.parametrize("states", sample([["position"], ["position", "velocity"]], 2))
@pytest.mark.parametrize(("size", "age_s"), [(0.1, 0.05), (0.1, 0.1), (0.5, 0.3), (2.0, 0.3)])
def test_also_if_a_trajectory_is_a_jump(states: list[str], size: float, age_s: float) -> None:
    """Its only point is to be reached sooner than the velocity limits allow."""
    urdf = ARM if "velocity" in states else ARM.replace('<state_interface name="velocity"/>', "")
    robot = Robot(100, urdf, TRAJECTORY, command_interfaces=["position"], state_interfaces=states)
    robot.run(0.2)
    point = Point(positions=[size, size / 2])
    point.time_from_start.nanosec = 1_000_000
    trajectory = Trajectory(joint_names=JOINTS, points=[point])
    robot.stack.nodes["controller"].receive("~/joint_trajectory", trajectory)
    robot.run(age_s)
    robot.stop()
    robot.run(0.8)
    for number in range(2):
        assert max(robot.decelerations(number)) <= TOLERANCE * DECELERATION
        assert abs(robot.speeds[-1][number]) < 1e-3


@pytest.mark.parametrize(("rate_hz", "age_s"), [(10, 0.3), (100, 0.02), (100, 0.3)])
def test_also_if_no_speeds_are_measured(rate_hz: int, age_s: float) -> None:
    """They are estimated from the positions, less exactly while the joint accelerates."""
    urdf = ARM.replace('<state_interface name="velocity"/>', "")
    robot = stopped_after(age_s, 1.5, -1.0, rate_hz=rate_hz, urdf=urdf)
    for number in range(2):
        assert max(robot.decelerations(number)) <= 2.0 * DECELERATION
        assert abs(robot.speeds[-1][number]) < 1e-3
        assert abs(robot.positions[-1][number]) < 0.5


def test_a_joint_comes_to_rest_within_its_braking_distance() -> None:
    robot = stopped_after(0.3, 2.0, 0.0)
    began, ended = robot.positions[0][0], robot.positions[-1][0]
    assert robot.speeds[0][0] == pytest.approx(1.0, abs=0.02)
    assert ended - began == pytest.approx(1.0 / (2 * DECELERATION), abs=0.005)


def test_a_joint_that_has_not_begun_to_follow_a_step_stays_where_it_is() -> None:
    robot = Robot(100)
    robot.run(0.2)
    robot.command(2.0, 2.0)
    robot.stop()
    robot.run(0.3)
    assert robot.positions[-1] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_joint_that_has_arrived_keeps_its_command() -> None:
    robot = stopped_after(0.5, 0.2, 0.1)
    assert robot.positions[-1] == pytest.approx([0.2, 0.1], abs=1e-3)
    assert math.isclose(robot.stack.command("turn/position"), 0.2)


@pytest.mark.parametrize("rate_hz", [20, 100])
def test_a_stream_of_positions_decelerates_on_its_way(rate_hz: int) -> None:
    robot = Robot(100)
    robot.run(0.2)
    for number in range(rate_hz // 2):
        robot.command(0.5 * number / rate_hz, 0.0)
        robot.run(1.0 / rate_hz)
    robot.stop()
    robot.run(0.5)
    assert abs(robot.speeds[-1][0]) < 1e-3
    if rate_hz == 100:
        assert max(robot.decelerations(0)) <= TOLERANCE * DECELERATION
