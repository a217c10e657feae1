"""The root link of a robot: free unless it is the world, and resting on the ground."""

import numpy as np
import pytest
import trimesh

from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.robot import Pose
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import INERTIAL, box, control, joint, link, robot

CRATE = INERTIAL.replace("0 0 0.25", "0 0 0") + box("collision", "0.4 0.2 0.6", "0 0 0.1")


def solid(shape: str) -> str:
    return f"<collision><geometry>{shape}</geometry></collision>"


def height(model: RobotModel) -> float:
    """Of the root link at the start."""
    return float(Simulation(model, control_period_ns=100_000_000).free_bodies.pose(0)[2])


def test_a_root_link_is_free_and_rests_on_the_ground() -> None:
    model = build_model(robot(link("base_link", CRATE)))
    simulation = Simulation(model, control_period_ns=100_000_000)
    assert [(body.link, body.parent) for body in model.free_bodies] == [("base_link", "world")]
    assert simulation.free_bodies.pose(0) == pytest.approx([0, 0, 0.2, 1, 0, 0, 0])

    simulation.step(2000)
    assert simulation.free_bodies.pose(0) == pytest.approx([0, 0, 0.2, 1, 0, 0, 0], abs=1e-3)
    simulation.free_bodies.put(0, np.array([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]))
    simulation.reset_state()
    assert simulation.free_bodies.pose(0) == pytest.approx([0, 0, 0.2, 1, 0, 0, 0])


@pytest.mark.parametrize("root", ["world", "base_link"])
def test_a_root_link_named_world_stands_and_so_does_one_that_is_told_to(root: str) -> None:
    arm = robot(link(root, ""), joint("hinge", root, "rod"), link("rod"))
    model = build_model(arm, fixed_base=root != "world")
    assert (model.free_bodies, model.base, model.world_frame) == ((), None, root)


@pytest.mark.parametrize(
    ("shape", "turn", "lowest"),
    [
        ('<box size="0.2 0.4 0.6"/>', 0.0, -0.3),
        ('<box size="0.2 0.4 0.6"/>', 0.5, -(0.3 * np.cos(0.5) + 0.2 * np.sin(0.5))),
        ('<sphere radius="0.25"/>', 0.5, -0.25),
        ('<cylinder radius="0.1" length="0.6"/>', 0.5, -(0.3 * np.cos(0.5) + 0.1 * np.sin(0.5))),
        ('<cylinder radius="0.1" length="0.6"/>', np.pi / 2, -0.1),
        ('<capsule radius="0.1" length="0.6"/>', 0.5, -(0.3 * np.cos(0.5) + 0.1)),
        (
            '<mesh filename="cube.stl" scale="2 4 6"/>',
            0.5,
            -(0.3 * np.cos(0.5) + 0.2 * np.sin(0.5)),
        ),
    ],
)
def test_the_lowest_point_of_what_touches_is_at_zero(
    shape: str, turn: float, lowest: float, tmp_path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box((0.1, 0.1, 0.1)).export("cube.stl")
    body = robot(link("body", INERTIAL + solid(shape) + box("visual", "5 5 5")))
    model = build_model(body, spawn_pose=Pose((1.0, 2.0, 0.0), (turn, 0.0, 0.0)))
    assert height(model) == pytest.approx(-lowest, abs=1e-6)


def test_the_joints_start_where_they_are_told_to_before_the_lowest_point_is_sought() -> None:
    leg = INERTIAL + box("collision", "0.1 0.1 0.1", "0 0 -0.95")
    hinge = joint("knee", "base", "leg", xyz="0 0 0", axis="1 0 0")
    start = '<state_interface name="position"><param name="initial_value">1</param>'
    bent = control(knee="position").replace(
        '<state_interface name="position"/>', f"{start}</state_interface>"
    )
    model = build_model(robot(link("base", CRATE), link("leg", leg), hinge, bent), fixed_base=False)
    # The foot's lowest corner, against the crate's underside at 0.2 m.
    foot = 0.95 * np.cos(1.0) + 0.05 * (np.cos(1.0) + np.sin(1.0))
    assert height(model) == pytest.approx(foot, abs=1e-6)


def test_a_robot_is_put_where_its_spawn_pose_says() -> None:
    pose = Pose((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    model = build_model(robot(link("base_link", CRATE)), spawn_pose=pose)
    found = Simulation(model, control_period_ns=100_000_000).free_bodies.pose(0)
    # Yaw after pitch after roll, multiplied out.
    turn = [0.98334744, 0.03427080, 0.10602051, 0.14357218]
    assert found == pytest.approx([1.0, 2.0, 3.0, *turn], abs=1e-7)
    assert model.base is not None
    assert not model.base.rests


def test_a_robot_that_touches_nothing_falls_freely() -> None:
    model = build_model(robot(link("base_link", INERTIAL)))
    simulation = Simulation(model, control_period_ns=100_000_000)
    simulation.step(1000)
    assert simulation.free_bodies.pose(0)[2] == pytest.approx(-9.81 / 2, rel=2e-3)
    assert model.base is not None
    assert not model.base.can_touch


def test_a_free_robot_weighs_what_it_weighs() -> None:
    """Drives of a fixed arm carry its weight; those of a free one cannot lift the robot."""
    arm = INERTIAL + box("collision", "0.05 0.05 0.5", "0 0 0.25")
    hinge = joint("hinge", "base_link", "arm", axis="0 1 0")
    model = build_model(
        robot(link("base_link", CRATE), link("arm", arm), hinge, control(hinge="position")),
        fixed_base=False,
        spawn_pose=Pose((0.0, 0.0, 5.0)),
    )
    simulation = Simulation(model, control_period_ns=100_000_000)
    simulation.step(500)
    assert simulation.free_bodies.pose(0)[2] == pytest.approx(5.0 - 9.81 / 8, rel=2e-3)
    assert simulation.positions == pytest.approx([0.0], abs=1e-6)


def test_a_cylinder_on_its_side_rolls_without_slip() -> None:
    inertia = 'ixx="0.0125" iyy="0.01" izz="0.0125" ixy="0" ixz="0" iyz="0"'
    mass = f'<inertial><mass value="2"/><inertia {inertia}/></inertial>'
    side = '<origin rpy="1.5707963267948966 0 0"/>'
    shape = '<geometry><cylinder radius="0.1" length="0.3"/></geometry>'
    wheel = robot(link("wheel", f"{mass}<collision>{side}{shape}</collision>"))
    simulation = Simulation(build_model(wheel), control_period_ns=100_000_000)
    pose = simulation.free_bodies.pose(0)
    simulation.free_bodies.put(0, pose, np.array([0.5, 0.0, 0.0, 0.0, 5.0, 0.0]))
    simulation.refresh()
    simulation.step(2000)
    assert simulation.free_bodies.pose(0)[0] == pytest.approx(1.0, rel=0.01)
    twist = simulation.free_bodies.twist(0)
    assert twist[0] == pytest.approx(0.1 * twist[4], rel=2e-3)


def test_wheels_take_up_their_speed_with_the_robot_on_them() -> None:
    rest = 'ixy="0" ixz="0" iyz="0"'
    shape = (
        '<origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.02"/>'
    )
    wheel = f"""<inertial><mass value="0.1"/>
      <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" {rest}/></inertial>
      <collision>{shape}</geometry></collision>"""
    body = f"""<inertial><mass value="10"/>
      <inertia ixx="0.04" iyy="0.14" izz="0.17" {rest}/></inertial>
      {box("collision", "0.4 0.2 0.1")}"""
    names = ("front_left", "front_right", "rear_left", "rear_right")
    places = ("0.15 0.12 -0.05", "0.15 -0.12 -0.05", "-0.15 0.12 -0.05", "-0.15 -0.12 -0.05")
    wheels = [
        link(name, wheel)
        + joint(f"{name}_joint", "body", name, kind="continuous", xyz=xyz, axis="0 1 0", limit="")
        for name, xyz in zip(names, places, strict=True)
    ]
    joints = [f"{name}_joint" for name in names]
    parts = (link("body", body), *wheels, control(**dict.fromkeys(joints, "velocity")))
    simulation = Simulation(build_model(robot(*parts)), control_period_ns=10_000_000)
    simulation.apply(joints, velocity=[2.0] * 4)
    simulation.step(50)
    simulation.read()
    assert simulation.velocities == pytest.approx([2.0] * 4, rel=0.02)
    simulation.step(150)
    simulation.read()
    assert simulation.velocities == pytest.approx([2.0] * 4, rel=0.01)
    start = float(simulation.free_bodies.pose(0)[0])
    simulation.step(2000)
    assert simulation.free_bodies.pose(0)[0] - start == pytest.approx(0.2, rel=0.01)
