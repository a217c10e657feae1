"""Motions whose course can be written down: fall, pendulum, friction, coupled joints, a car."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from teleopctl.interfaces import set_stamp
from teleopctl.mujoco_model.model import build_model
from teleopctl.robot import read_model
from teleopctl.robot.urdf import Pose
from teleopctl.sim import simulate
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import box, control, joint, link, model, robot
from tests.sim.test_driving import ControllerReport, TwistStamped, solid

G = 9.81
TICK_NS = 10_000_000


def simulation(built) -> Simulation:
    return Simulation(built, control_period_ns=TICK_NS, timestep_ns=1_000_000)


def brick(friction: float) -> str:
    return (
        '<link name="brick"><inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.02"'
        f' ixy="0" ixz="0" iyz="0"/></inertial>{box("collision", "0.4 0.4 0.1")}</link>'
        f'<gazebo reference="brick"><mu1>{friction}</mu1><mu2>{friction}</mu2></gazebo>'
    )


def test_what_falls_falls_by_half_g_t_squared():
    sim = simulation(build_model(robot(brick(0.5)), spawn_pose=Pose((0.0, 0.0, 20.0))))
    sim.step_to(1_500_000_000)
    # The integrator is off by g t dt / 2, as semi-implicit Euler is.
    fallen = 20.0 - sim.link_pose("brick").position[2]
    assert fallen == pytest.approx(G * 1.5**2 / 2.0, rel=0.001)
    assert sim.free_bodies.twist(0)[2] == pytest.approx(-G * 1.5, rel=1e-6)


def test_a_pendulum_swings_with_the_period_of_its_inertia():
    rod = joint("hinge", "base", "rod", kind="continuous", limit="")
    sim = simulation(model(link("base", ""), link("rod"), rod))
    amplitude = 0.1
    sim.reset_state(positions={"hinge": math.pi + amplitude})
    crossings: list[float] = []
    before = amplitude
    for step in range(4, 6_000, 4):
        sim.step(4)
        sim.read()
        now = float(sim.positions[0]) - math.pi
        if before < 0.0 <= now:
            crossings.append((step - 4.0 * now / (now - before)) * 1e-3)
        before = now
    # 0.5 kg at 0.25 m, with 0.01 kg m^2 about its centre of mass.
    inertia = 0.01 + 0.5 * 0.25**2
    small = 2.0 * math.pi * math.sqrt(inertia / (0.5 * G * 0.25))
    periods = len(crossings) - 1
    assert periods >= 4
    period = (crossings[-1] - crossings[0]) / periods
    assert period == pytest.approx(small * (1.0 + amplitude**2 / 16.0), rel=0.001)


@pytest.mark.parametrize("friction", [0.2, 0.6])
def test_what_slides_stops_after_v_squared_by_two_mu_g(friction):
    sim = simulation(build_model(robot(brick(friction))))
    sim.step_to(200_000_000)
    speed = 2.0
    start = sim.free_bodies.pose(0)
    sim.free_bodies.put(0, start, np.array([speed, 0.0, 0.0, 0.0, 0.0, 0.0]))
    sim.step(2_000)
    way = sim.free_bodies.pose(0)[0] - start[0]
    assert way == pytest.approx(speed**2 / (2.0 * friction * G), rel=0.02)
    assert abs(sim.free_bodies.twist(0)[0]) < 1e-4


def test_a_joint_that_follows_another_has_its_ratio_and_offset_while_it_moves():
    follow = '<mimic joint="first" multiplier="-0.5" offset="0.1"/>'
    built = model(
        link("base", ""),
        link("one"),
        link("two"),
        joint("first", "base", "one", xyz="0 0.3 0"),
        joint("second", "base", "two", xyz="0 -0.3 0", content=follow),
        control(first="position"),
    )
    sim = simulation(built)
    worst = 0.0
    for tick in range(100):
        sim.apply(["first"], [0.8 * math.sin(0.06 * tick)])
        sim.step(sim.steps_to_tick)
        sim.read()
        first, second = (sim.positions[sim.joint_names.index(name)] for name in ("first", "second"))
        worst = max(worst, abs(second - (0.1 - 0.5 * first)))
    assert worst < 1e-3


def test_a_gear_multiplies_the_torque_of_its_motor_and_divides_its_speed(tmp_path: Path):
    ratio, inertia, rotor = 20.0, 0.1, 0.4  # kg m^2; the rotor's as the joint feels it
    wheels = "".join(
        f'<body pos="0 {y} 0"><joint name="{name}" axis="0 0 1" armature="{rotor}"/>'
        f'<inertial pos="0 0 0" mass="1" diaginertia="{inertia} {inertia} {inertia}"/></body>'
        for y, name in enumerate(("pushed", "turned"))
    )
    file = tmp_path / "geared.xml"
    file.write_text(
        f"""<mujoco><option gravity="0 0 0" timestep="0.001"/><worldbody>{wheels}</worldbody>
        <actuator><motor joint="pushed" gear="{ratio}"/>
        <velocity joint="turned" gear="{ratio}" kv="2"/></actuator></mujoco>"""
    )
    sim = simulate(read_model(file).text, control_period_ns=TICK_NS).simulation
    for _ in range(50):
        sim.apply(["pushed", "turned"], velocity=[math.nan, 3.0], effort=[5.0, math.nan])
        sim.step(sim.steps_per_period)
    sim.read()
    _, data = sim.observe()
    pushed, turned = (sim.joint_names.index(name) for name in ("pushed", "turned"))
    # Both commands are the joint's; what the motor gives and how fast it turns follow.
    assert sim.velocities[pushed] == pytest.approx(5.0 * 0.5 / (inertia + rotor), rel=1e-6)
    assert data.actuator_force[0] == pytest.approx(5.0 / ratio)
    assert sim.velocities[turned] == pytest.approx(3.0, rel=1e-3)
    assert data.actuator_velocity[1] == pytest.approx(3.0 * ratio, rel=1e-3)


RADIUS, WHEELBASE, TRACK = 0.1, 0.6, 0.4


def _wheel(name: str, x: float, y: float, *, steered: bool) -> str:
    cylinder = f'<cylinder radius="{RADIUS}" length="0.02"/>'
    tyre = solid(f"{name}_tyre", cylinder, 0.5, 2e-3, f"{math.pi / 2} 0 0")
    if not steered:
        return tyre + joint(
            name, "base", f"{name}_tyre", kind="continuous", xyz=f"{x} {y} 0", axis="0 1 0",
            limit='effort="20" velocity="50"',
        )  # fmt: skip
    return (
        solid(f"{name}_knuckle", '<sphere radius="0.01"/>', 0.2, 1e-3)
        + tyre
        + joint(
            f"{name}_steering", "base", f"{name}_knuckle", xyz=f"{x} {y} 0", axis="0 0 1",
            limit='lower="-1" upper="1" effort="50" velocity="10"',
        )
        + joint(
            name, f"{name}_knuckle", f"{name}_tyre", kind="continuous", xyz="0 0 0", axis="0 1 0",
            limit="",
        )
    )  # fmt: skip


def car() -> ControllerReport:
    """A base that drives its two rear wheels and steers its two front ones."""
    states = '<state_interface name="position"/><state_interface name="velocity"/>'
    joints = "".join(
        f'<joint name="{name}"><command_interface name="{command}"/>{states}</joint>'
        for name, command in (
            ("rear_right", "velocity"),
            ("rear_left", "velocity"),
            ("front_right_steering", "position"),
            ("front_left_steering", "position"),
        )
    )
    wheels = "".join(
        _wheel(f"{end}_{side}", x, sign * TRACK / 2.0, steered=end == "front")
        for end, x in (("front", WHEELBASE), ("rear", 0.0))
        for side, sign in (("left", 1.0), ("right", -1.0))
    )
    body = solid("base", '<box size="0.5 0.2 0.05"/>', 8.0, 0.2)
    body = re.sub("<inertial>", f'<inertial><origin xyz="{WHEELBASE / 2} 0 0"/>', body)
    driven = ControllerReport(
        f'<robot name="car">{body}{wheels}<ros2_control name="hardware" type="system"><hardware>'
        f"<plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>{joints}</ros2_control></robot>"
    )
    driven.stack.load_controller(
        "base",
        "ackermann_steering_controller/AckermannSteeringController",
        {
            "traction_joints_names": ["rear_right", "rear_left"],
            "steering_joints_names": ["front_right_steering", "front_left_steering"],
            "wheelbase": WHEELBASE,
            "traction_track_width": TRACK,
            "traction_wheels_radius": RADIUS,
        },
    )
    driven.stack.activate("base")
    driven.run(0.3)
    return driven


@pytest.mark.nightly
def test_a_base_on_four_wheels_drives_a_square_with_round_corners_within_one_percent():
    base = car()
    message = TwistStamped()
    speed, turn = 0.6, 0.6  # corners of 1 m radius
    length = 0.0
    for seconds, angular in ((1.0, 0.0), (math.pi / 2.0 / turn, turn)) * 4:
        message.twist.linear.x, message.twist.angular.z = speed, angular
        ticks = round(seconds * 100)
        for first in range(0, ticks, 10):
            set_stamp(message.header.stamp, base.stack.time_ns)
            base.stack.nodes["base"].receive("~/reference", message)
            base.run(min(10, ticks - first) / 100)
        length += speed * ticks / 100
    x, y, heading = base.pose
    assert math.hypot(x, y) < 0.01 * length
    assert abs(heading) < 0.01 * 2.0 * math.pi
