"""Friction by direction: what slides stops by that of its way, mecanum wheels go sideways."""

import math
from pathlib import Path

import numpy as np
import pytest

from teleopctl.mujoco_model import build_model
from teleopctl.robot import RobotDescription, read_model, read_world
from teleopctl.robot.urdf import Pose
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import box, control, joint, link, robot

G = 9.81
ALONG, ACROSS = 0.6, 0.2
SOLID = (
    '<inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>'
    f"</inertial>{box('collision', '0.4 0.4 0.1')}"
)
TAGS = f"<mu1>{ALONG}</mu1><mu2>{ACROSS}</mu2><fdir1>1 1 0</fdir1>"
IN_SHAPE = (
    f"<collision><surface><friction><ode><mu>{ALONG}</mu><mu2>{ACROSS}</mu2>"
    "<fdir1>1 1 0</fdir1></ode></friction></surface></collision>"
)


def slid(simulation: Simulation, angle: float) -> np.ndarray:
    """How far something at 1 m/s comes, along a direction of the world."""
    simulation.step(300)
    start = simulation.free_bodies.pose(0)
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    simulation.free_bodies.put(0, start, np.array([*way, 0.0, 0.0, 0.0]))
    simulation.step(1_500)
    moved = simulation.free_bodies.pose(0)[:3] - start[:3]
    return np.array([moved @ way, np.linalg.norm(moved[:2])])


@pytest.mark.parametrize("tags", [TAGS, IN_SHAPE], ids=["of the link", "of its shape"])
@pytest.mark.parametrize(("turn", "friction"), [(0.0, ALONG), (math.pi / 2, ACROSS)])
@pytest.mark.parametrize("yaw", [0.0, 1.0])
def test_what_slides_stops_by_the_friction_of_its_way(
    tags: str, turn: float, friction: float, yaw: float
) -> None:
    brick = robot(link("brick", SOLID), f'<gazebo reference="brick">{tags}</gazebo>')
    built = build_model(brick, spawn_pose=Pose((0.0, 0.0, 0.0), (0.0, 0.0, yaw)))
    assert built.warnings == ()
    found = slid(Simulation(built, control_period_ns=1_000_000), math.pi / 4 + yaw + turn)
    assert found == pytest.approx(1.0 / (2.0 * friction * G), rel=0.02)


def wheel(name: str, x: float, y: float, along: str) -> str:
    solid = (
        '<inertial><mass value="0.5"/><inertia ixx="0.002" iyy="0.002" izz="0.002" ixy="0" '
        'ixz="0" iyz="0"/></inertial><collision><geometry><sphere radius="0.1"/></geometry>'
        "</collision>"
    )
    hinge = joint(
        name, "base", f"{name}_wheel", kind="continuous", xyz=f"{x} {y} 0", axis="0 1 0", limit=""
    )
    tags = f'<mu1>1</mu1><mu2>0</mu2><fdir1 gz:expressed_in="base">{along}</fdir1>'
    gazebo = f'<gazebo reference="{name}_wheel">{tags}</gazebo>'
    return link(f"{name}_wheel", solid) + hinge + gazebo


@pytest.mark.parametrize(
    "speed", [(0.4, 0.0, 0.0), (0.0, 0.4, 0.0), (0.2, -0.3, 0.0), (0.0, 0.0, 0.5)]
)
def test_a_base_on_wheels_with_rollers_goes_where_their_speeds_send_it(
    speed: tuple[float, float, float],
) -> None:
    half, side, radius = 0.3, 0.2, 0.1
    base = (
        '<inertial><mass value="5"/><inertia ixx="0.1" iyy="0.1" izz="0.2" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )
    places = {
        "fl": (half, side, "1 -1 0"),
        "fr": (half, -side, "1 1 0"),
        "rl": (-half, side, "1 1 0"),
        "rr": (-half, -side, "1 -1 0"),
    }
    wheels = "".join(wheel(name, *place) for name, place in places.items())
    text = (
        f'<robot name="r" xmlns:gz="http://gazebosim.org/schema">{link("base", base)}{wheels}'
        f"{control(**dict.fromkeys(places, 'velocity'))}</robot>"
    )
    built = build_model(RobotDescription.from_urdf(text))
    assert not [warning for warning in built.warnings if "mu2" in warning]
    simulation = Simulation(built, control_period_ns=10_000_000)
    simulation.step(300)
    x, y, turn = speed
    turns = [
        (x + (-1.0 if name in ("fl", "rr") else 1.0) * y
         + (-1.0 if name in ("fl", "rl") else 1.0) * (half + side) * turn) / radius
        for name in places
    ]  # fmt: skip
    for _ in range(200):
        simulation.apply(list(places), velocity=turns)
        simulation.step(10)
    twist = simulation.free_bodies.twist(0)
    pose = simulation.free_bodies.pose(0)
    yaw = 2.0 * math.atan2(pose[6], pose[3])
    ahead, left = (
        twist[0] * math.cos(yaw) + twist[1] * math.sin(yaw),
        twist[1] * math.cos(yaw) - twist[0] * math.sin(yaw),
    )
    assert (ahead, left, twist[5]) == pytest.approx(speed, abs=0.01)


def test_a_robot_of_sdf_keeps_its_directions_in_the_frames_of_its_links(tmp_path: Path) -> None:
    file = tmp_path / "robot.sdf"
    surface = (
        f"<surface><friction><ode><mu>{ALONG}</mu><mu2>{ACROSS}</mu2><fdir1{{}}>1 1 0</fdir1>"
        "</ode></friction></surface>"
    )
    shape = "<geometry><box><size>0.4 0.4 0.1</size></box></geometry>"
    own = f"<collision name='c'><pose>0 0 0 0 0 0.5</pose>{shape}{surface.format('')}</collision>"
    other = (
        f"<collision name='c'>{shape}{surface.format(' gz:expressed_in=' + repr('a'))}</collision>"
    )
    file.write_text(
        f"<sdf version='1.9'><model name='m'><link name='a'>{own}</link>"
        f"<link name='b'><pose>1 0 0 0 0 1</pose>{other}</link><joint name='j' type='fixed'>"
        "<pose>0 0 0 0 0 0.3</pose><parent>a</parent><child>b</child></joint></model></sdf>"
    )
    description = RobotDescription.from_urdf(read_model(file).text)
    found = {name: physics.across for name, physics in description.gazebo.links.items()}
    assert found["a"] is not None
    assert found["b"] is not None
    turned = math.pi / 4 + 0.5
    length = math.sqrt(2.0)
    assert found["a"].along == pytest.approx(
        (length * math.cos(turned), length * math.sin(turned), 0.0)
    )
    assert found["b"].link == "a"
    assert found["b"].along == pytest.approx((1.0, 1.0, 0.0))
    assert found["b"].coefficient == ACROSS


def test_in_a_world_a_direction_is_told(tmp_path: Path) -> None:
    file = tmp_path / "world.sdf"
    surface = (
        "<surface><friction><ode><mu>1</mu><mu2>0.5</mu2><fdir1>1 0 0</fdir1></ode></friction>"
        "</surface>"
    )
    shape = f"<geometry><box><size>1 1 1</size></box></geometry>{surface}"
    file.write_text(
        "<sdf version='1.9'><world name='w'><model name='m'><static>true</static><link name='l'>"
        f"<collision name='c'>{shape}</collision></link></model></world></sdf>"
    )
    built = build_model(robot(link("world", "")), world=read_world(file))
    assert built.warnings == (
        "world.sdf: <mu2> of 'm' has no effect: in a world friction is the same in all directions",
    )
