"""A base with two wheels on the ground, driven by its controller: rolling without slip, squares.

The controllers are the real ones in lockstep with the real physics, in one thread and without ROS.
"""

import math
import re

import mujoco
import numpy as np
import pytest

from teleopctl.interfaces import AllowableParameterValue, get_action, get_message, set_stamp
from teleopctl.node import GoalState
from teleopctl.robot import motion_plugins, simulated
from teleopctl.sim.building import simulate
from teleopctl.sim.ports import reported_joints
from teleopctl.sim.state import slip_correction
from teleopctl.testing import ControlStack

RADIUS, SEPARATION, RATE_HZ = 0.05, 0.3, 100
JointState = get_message("sensor_msgs/msg/JointState")
TwistStamped = get_message("geometry_msgs/msg/TwistStamped")

BASE: dict[str, AllowableParameterValue] = {
    "left_wheel_names": ["left"],
    "right_wheel_names": ["right"],
    "wheel_radius": RADIUS,
    "wheel_separation": SEPARATION,
    "linear.x.max_acceleration": 1.0,
    "angular.z.max_acceleration": 3.0,
    "publish_rate": float(RATE_HZ),
}


def solid(name: str, shape: str, mass: float, inertia: float, rpy: str = "0 0 0") -> str:
    return f"""<link name="{name}">
      <inertial><mass value="{mass}"/><inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}"
        ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><origin rpy="{rpy}"/><geometry>{shape}</geometry></collision></link>"""


def wheel(name: str, y: float, x: float = 0.0) -> str:
    cylinder = f'<cylinder radius="{RADIUS}" length="0.02"/>'
    return (
        solid(name + "_wheel", cylinder, 0.3, 4e-4, f"{math.pi / 2} 0 0")
        + f'<joint name="{name}" type="continuous"><parent link="base"/>'
        f'<child link="{name}_wheel"/><origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/>'
        '<limit effort="5" velocity="50"/></joint>'
    )


def control(*joints: str, command: str, extra: str = "") -> str:
    tags = "".join(
        f'<joint name="{joint}"><command_interface name="{command}"/>'
        '<state_interface name="position"/><state_interface name="velocity"/></joint>'
        for joint in joints
    )
    return (
        '<ros2_control name="hardware" type="system"><hardware>'
        f"<plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>{tags}{extra}</ros2_control>"
    )


CART = f"""<robot name="cart"><link name="world"/>
  <joint name="free" type="floating"><parent link="world"/><child link="base"/>
    <origin xyz="0 0 {RADIUS}"/></joint>
  {solid("base", '<box size="0.3 0.2 0.04"/>', 2.0, 0.02)}
  {wheel("left", SEPARATION / 2)}{wheel("right", -SEPARATION / 2)}
  {solid("caster", '<sphere radius="0.02"/>', 0.05, 1e-5)}
  <joint name="front" type="fixed"><parent link="base"/><child link="caster"/>
    <origin xyz="0.12 0 {0.02 - RADIUS}"/></joint>
  {solid("skid", '<sphere radius="0.02"/>', 0.05, 1e-5)}
  <joint name="back" type="fixed"><parent link="base"/><child link="skid"/>
    <origin xyz="-0.12 0 {0.02 - RADIUS}"/></joint>
  <gazebo reference="caster"><mu1>0</mu1></gazebo><gazebo reference="skid"><mu1>0</mu1></gazebo>
  {control("left", "right", command="velocity")}</robot>"""


class ControllerReport:
    """A robot in simulation with its controllers."""

    def __init__(self, urdf: str) -> None:
        self.warnings: list[str] = []
        self.robot = simulate(
            urdf,
            control_period_ns=10**9 // RATE_HZ,
            timestep_ns=1_000_000,
            warn=self.warnings.append,
        )
        self.simulation = self.robot.simulation
        self.stack = ControlStack(urdf, update_rate=RATE_HZ)
        (component,) = self.stack.resources.components.values()
        component.hardware.set_cycle(self._cycle)
        self._joints = reported_joints(self.simulation.model)

    def _cycle(self, time_ns: int) -> None:
        self.stack.time_ns = time_ns
        self.stack.cycle.run(time_ns)

    def run(self, seconds: float) -> None:
        """Exchange state and commands at each tick, as the simulator and the manager do."""
        simulation = self.simulation
        names = [simulation.joint_names[index] for index in self._joints]
        answers = self.stack.node.published("/robot_joint_commands")
        for _ in range(round(seconds * RATE_HZ)):
            simulation.read()
            state = JointState(
                name=names,
                position=simulation.positions[self._joints],
                velocity=simulation.velocities[self._joints],
                effort=simulation.efforts[self._joints],
            )
            set_stamp(state.header.stamp, self.stack.start_ns + simulation.time_ns)
            self.stack.node.receive("/robot_joint_states", state)
            command = answers.pop()
            simulation.apply(
                list(command.name),
                list(command.position),
                list(command.velocity),
                list(command.effort),
            )
            simulation.step(simulation.steps_per_period)
        simulation.read()

    def position(self, joint: str) -> float:
        return float(self.simulation.positions[self.simulation.joint_names.index(joint)])

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where physics has the base: x, y, heading."""
        pose = self.simulation.link_pose("base")
        heading = math.atan2(pose.rotation[1, 0], pose.rotation[0, 0])
        return float(pose.position[0]), float(pose.position[1]), heading


# The same cart as Gazebo's users write it.
PLUGIN = f"""<gazebo><plugin name="base" filename="libgazebo_ros_diff_drive.so">
  <left_joint>left</left_joint><right_joint>right</right_joint>
  <wheel_separation>{SEPARATION}</wheel_separation><wheel_diameter>{2 * RADIUS}</wheel_diameter>
  <max_wheel_acceleration>1</max_wheel_acceleration><update_rate>{RATE_HZ}</update_rate>
  <publish_odom>true</publish_odom></plugin></gazebo>"""


class Cart(ControllerReport):
    def __init__(
        self,
        urdf: str = CART,
        topic: str = "~/cmd_vel",
        parameters: dict[str, AllowableParameterValue] = BASE,
    ) -> None:
        super().__init__(urdf)
        kind = "diff_drive_controller/DiffDriveController"
        for controller in motion_plugins(self.robot.description).controllers:
            kind, parameters = controller.type, dict(controller.parameters)
        self.topic = topic
        self.stack.load_controller("base", kind, parameters)
        self.stack.activate("base")
        self.run(0.3)

    def drive(self, x: float, angular: float, seconds: float, *, stop: bool = True) -> None:
        """Drive for so long, and stop."""
        message = TwistStamped()
        for speed, turn, duration in ((x, angular, seconds), (0.0, 0.0, 0.7))[: 1 + stop]:
            message.twist.linear.x, message.twist.angular.z = speed, turn
            for _ in range(round(duration * 10)):
                set_stamp(message.header.stamp, self.stack.time_ns)
                stamped = self.topic == "~/cmd_vel"
                self.stack.nodes["base"].receive(self.topic, message if stamped else message.twist)
                self.run(0.1)

    @property
    def odometry(self) -> tuple[float, float, float]:
        pose = self.stack.nodes["base"].published("~/odom")[-1].pose.pose
        heading = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        return pose.position.x, pose.position.y, heading


@pytest.fixture
def cart() -> Cart:
    return Cart()


def test_a_wheel_rolls_without_slip(cart: Cart) -> None:
    start = cart.position("left")
    cart.drive(0.5, 0.0, 2.0)
    x, y, heading = cart.pose
    # Braking takes as long as speeding up: the way is speed by time.
    assert x == pytest.approx(1.0, rel=0.01)
    assert x == pytest.approx(RADIUS * (cart.position("left") - start), rel=0.003)
    assert (y, heading) == pytest.approx((0.0, 0.0), abs=0.002)
    assert cart.odometry == pytest.approx(cart.pose, abs=0.003)


@pytest.mark.nightly
def test_a_square_is_driven_within_one_percent(cart: Cart) -> None:
    corners = []
    for _ in range(4):
        cart.drive(0.5, 0.0, 2.0)
        corners.append(cart.pose[:2])
        cart.drive(0.0, math.pi / 4.0, 2.0)
    expected = [(1, 0), (1, 1), (0, 1), (0, 0)]
    for corner, wanted in zip(corners, expected, strict=True):
        assert math.dist(corner, wanted) < 0.01 * 4.0  # one percent of the way round
    assert math.dist(cart.odometry[:2], cart.pose[:2]) < 0.01 * 4.0
    assert abs(cart.pose[2]) < 0.01 * 2.0 * math.pi


@pytest.mark.parametrize(
    ("friction", "drags"), [("", True), ("<mu1>0</mu1>", False)], ids=["dry", "smooth"]
)
def test_a_base_with_fixed_casters_comes_as_far_as_its_wheels_turn(
    friction: str, drags: bool
) -> None:
    # By Coulomb's law wheels of two thirds of the weight move what casters of the rest brake.
    # A robot without a link `world`: its root link is free.
    robot = re.sub('<link name="world"/>.*?</joint>', "", CART, count=1, flags=re.DOTALL)
    cart = Cart(robot.replace("<mu1>0</mu1>", friction))
    assert cart.simulation.model.base is not None
    assert cart.simulation.model.base.drags == drags
    cart.drive(0.5, 0.0, 2.0)
    turned = (cart.position("left") + cart.position("right")) / 2 * RADIUS
    assert turned > 0.7
    assert cart.pose[0] == pytest.approx(turned, rel=0.02)


BASE_M, TRACK_M = 0.5, 0.4


def sliding_base() -> Cart:
    """A base on four wheels that do not steer: where it turns, each slides."""
    corners = {f"{end}_{side}": (x * BASE_M / 2, y * TRACK_M / 2)
               for end, x in (("front", 1), ("rear", -1))
               for side, y in (("left", 1), ("right", -1))}  # fmt: skip
    wheels = "".join(wheel(name, y, x) for name, (x, y) in corners.items())
    body = solid("base", '<box size="0.4 0.2 0.04"/>', 10.0, 0.3)
    lists: dict[str, list[str]] = {
        f"{side}_wheel_names": [name for name in corners if side in name]
        for side in ("left", "right")
    }
    # The moment of four equal forces of friction is nothing where the base turns by this much less
    # than wheels that roll would have it.
    slower = 1.0 + (BASE_M / TRACK_M) ** 2
    track = {"wheel_separation": TRACK_M, "wheel_separation_multiplier": slower}
    text = f'<robot name="base">{body}{wheels}{control(*corners, command="velocity")}</robot>'
    return Cart(text, parameters={**BASE, **lists, **track})


@pytest.mark.nightly
def test_a_base_that_turns_by_sliding_its_wheels_drives_a_square_within_one_percent() -> None:
    cart = sliding_base()
    weight = 9.81 * (10.0 + 4 * 0.3)
    for _ in range(4):
        cart.drive(0.5, 0.0, 2.0)
        cart.drive(0.0, math.pi / 4.0, 1.0, stop=False)
        m, data = cart.simulation.observe()
        # The wheels slide sideways by 0.2 m/s, and lie on the ground as steadily as at rest.
        assert abs(data.cvel[1][:3]).max() > 0.7
        force, carried = np.zeros(6), 0.0
        for number in range(data.ncon):
            mujoco.mj_contactForce(m, data, number, force)
            carried += force[0]
        assert carried == pytest.approx(weight, rel=1e-3)
        cart.drive(0.0, math.pi / 4.0, 1.0)
    x, y, heading = cart.pose
    assert math.hypot(x, y) < 0.01 * 4.0  # one percent of the way round
    assert abs(heading) < 0.01 * 2.0 * math.pi


def test_what_slides_is_looked_for_at_each_step_only_while_it_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks = 0

    def looked(contacts: slip_correction._Contacts, data: object) -> float:
        nonlocal looks
        looks += 1
        return correct_slip(contacts, data)

    correct_slip = slip_correction._Contacts.correct_slip
    monkeypatch.setattr(slip_correction._Contacts, "correct_slip", looked)
    cart = sliding_base()
    seen = []
    for x, angular in ((0.5, 0.0), (0.0, math.pi / 4.0)):
        cart.drive(x, angular, 1.0, stop=False)
        looks = 0
        cart.drive(x, angular, 0.3, stop=False)
        seen.append(looks)
    straight, turning = seen
    # Of the 300 steps in which the wheels roll, one in 16.
    assert straight == pytest.approx(300 / 16, abs=1.0)
    assert turning == 300


def test_a_base_with_gazebos_plugin_drives_as_with_the_controller() -> None:
    bare = re.sub("<ros2_control.*</ros2_control>", PLUGIN, CART, flags=re.DOTALL)
    cart = Cart(simulated(bare).urdf, "~/cmd_vel_unstamped")
    cart.drive(0.5, 0.0, 1.0)
    cart.drive(0.0, math.pi / 4.0, 2.0)
    assert cart.pose == pytest.approx((0.5, 0.0, math.pi / 2.0), abs=0.01)
    assert cart.odometry == pytest.approx(cart.pose, abs=0.005)


ARM = f"""<robot name="arm"><link name="world"/>
  {solid("upper", '<box size="0.05 0.05 0.3"/>', 1.0, 0.01)}
  <joint name="shoulder" type="revolute"><parent link="world"/><child link="upper"/>
    <origin xyz="0 0 1"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
  {control("shoulder", command="position")}</robot>"""


def test_a_trajectory_ends_within_its_tolerance_and_a_blocked_one_is_aborted() -> None:
    arm = ControllerReport(ARM)
    arm.stack.load_controller(
        "arm",
        "joint_trajectory_controller/JointTrajectoryController",
        {
            "joints": ["shoulder"],
            "command_interfaces": ["position"],
            "state_interfaces": ["position", "velocity"],
            "constraints.shoulder.goal": 0.005,
            "constraints.shoulder.trajectory": 0.05,
            "constraints.goal_time": 0.5,
        },
    )
    arm.stack.activate("arm")
    server = arm.stack.action_servers["arm/follow_joint_trajectory"]
    goal = get_action("control_msgs/action/FollowJointTrajectory").Goal()
    goal.trajectory.joint_names = ["shoulder"]
    point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    goal.trajectory.points = [
        point(positions=[1.0], velocities=[0.0]),
        point(positions=[-0.5], velocities=[0.0]),
    ]
    for seconds, one in zip((1, 2), goal.trajectory.points, strict=True):
        one.time_from_start.sec = seconds
    handle = server.send_goal(goal)
    assert handle is not None
    arm.run(2.6)
    assert handle.status == GoalState.SUCCEEDED, server.result(handle)
    assert arm.position("shoulder") == pytest.approx(-0.5, abs=0.005)
    # Faster than the joint can move: the path is left.
    goal.trajectory.points = goal.trajectory.points[:1]
    goal.trajectory.points[0].time_from_start.sec = 0
    goal.trajectory.points[0].time_from_start.nanosec = 200_000_000
    handle = server.send_goal(goal)
    assert handle is not None
    arm.run(0.6)
    assert handle.status == GoalState.ABORTED
    assert server.result(handle).error_string.startswith(
        "Aborted due to path tolerance violation: joint shoulder: Position Error:"
    )


@pytest.mark.parametrize(("mu1", "friction"), [(0.2, 0.2), (1e15, 1.0)])
def test_of_two_that_touch_the_smoother_one_decides(mu1: float, friction: float) -> None:
    block = solid("block", '<box size="0.4 0.4 0.1"/>', 1.0, 0.01)
    robot = simulate(
        f"""<robot name="block"><link name="world"/>{block}
        <joint name="free" type="floating"><parent link="world"/><child link="block"/>
        <origin xyz="0 0 0.05"/></joint>
        <gazebo reference="block"><mu1>{mu1}</mu1></gazebo></robot>""",
        control_period_ns=10_000_000,
        timestep_ns=1_000_000,
    )
    simulation = robot.simulation
    bodies = simulation.free_bodies
    bodies.put(0, bodies.pose(0), np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    simulation.step(1000)
    slid = simulation.link_pose("block").position[0]
    assert slid == pytest.approx(1.0 / (2.0 * friction * 9.81), rel=0.02)
