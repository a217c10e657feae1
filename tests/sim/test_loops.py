"""Joints that close loops: four-bar linkages, of SDF and in the ``<gazebo>`` of a URDF."""

import math
import re
from pathlib import Path

import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.robot import (
    RobotDescription,
    SceneJoint,
    read_model,
    read_world,
    simulated,
    tree_and_loops,
)
from teleopctl.sim.simulation import Simulation
from teleopctl.tf import Transform
from tests.sim.robots import joint as urdf_joint, link as urdf_link, robot

G = 9.81
INERTIAL = (
    '<inertial><origin xyz="0 0 -0.2"/><mass value="1"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
LENGTH, WIDTH, TILT = 0.5, 0.4, 0.1
STILL = robot(urdf_link("world", ""))
# Two cranks of next to no mass hang side by side, tilted, and carry a beam that is hard to turn.
END = (LENGTH * math.sin(TILT), 2.0 - LENGTH * math.cos(TILT))


def link(name: str, x: float, z: float, mass: float, moment: float) -> str:
    moments = "".join(f"<i{axes}>{moment}</i{axes}>" for axes in ("xx", "yy", "zz"))
    return (
        f"<link name='{name}'><pose>{x} 0 {z} 0 0 0</pose><inertial><mass>{mass}</mass>"
        f"<inertia>{moments}</inertia></inertial></link>"
    )


def hinge(name: str, parent: str, child: str, pose: str = "0 0 0 0 0 0") -> str:
    return (
        f"<joint name='{name}' type='revolute'><pose>{pose}</pose><parent>{parent}</parent>"
        f"<child>{child}</child><axis><xyz>0 1 0</xyz></axis></joint>"
    )


LINKAGE = (
    link("crank", 0.0, 2.0, 1e-3, 1e-5),
    link("rocker", WIDTH, 2.0, 1e-3, 1e-5),
    link("beam", *END, 2.0, 0.5),
    hinge("lead", "world", "crank"),
    hinge("carry", "crank", "beam"),
    hinge("follow", "world", "rocker"),
    # Whose child has another parent already.
    hinge("close", "rocker", "beam", f"{WIDTH} 0 0 0 0 0"),
)


def sdf(tmp_path: Path, content: str) -> Path:
    file = tmp_path / "file.sdf"
    file.write_text(f"<sdf version='1.9'>{content}</sdf>")
    return file


def build(file: Path) -> RobotModel:
    return build_model(RobotDescription.from_urdf(simulated(read_model(file).text).urdf))


def test_a_beam_on_two_cranks_swings_as_a_pendulum_that_does_not_turn(tmp_path: Path) -> None:
    world = f"<world name='w'><model name='m'>{''.join(LINKAGE)}</model></world>"
    built = build_model(STILL, world=read_world(sdf(tmp_path, world)))
    assert built.warnings == ()
    simulation = Simulation(built, control_period_ns=1_000_000)
    beam = next(
        name
        for name in simulation.present_model.mj_model.names.split(b"\0")
        if name.endswith(b"beam")
    ).decode()

    def seen() -> tuple[float, float]:
        _, data = simulation.observe()
        return float(data.body(beam).xpos[0]), float(data.body(beam).xquat[2])

    period_s = math.tau * math.sqrt(LENGTH / G) * (1.0 + TILT**2 / 16.0)
    start, _ = seen()
    simulation.step(round(period_s / 2.0 * 1000))
    halfway, turned = seen()
    simulation.step(round(period_s / 2.0 * 1000))
    end, _ = seen()
    assert halfway == pytest.approx(-start, rel=0.01)
    assert end == pytest.approx(start, rel=0.01)
    assert turned == pytest.approx(0.0, abs=1e-4)


def test_one_crank_of_a_robot_is_driven_and_the_loop_moves_the_others(tmp_path: Path) -> None:
    limited = LINKAGE[3].replace(
        "</xyz>", "</xyz><limit><lower>-1</lower><upper>1</upper><effort>100</effort></limit>"
    )
    built = build(
        sdf(tmp_path, f"<model name='m'>{''.join((*LINKAGE[:3], limited, *LINKAGE[4:]))}</model>")
    )
    commanded = {joint.name: joint.command_interfaces for joint in built.joints}
    assert commanded == {"lead": ("position",), "carry": (), "follow": ()}
    assert any("'close' closes a loop" in warning for warning in built.warnings)
    simulation = Simulation(built, control_period_ns=10_000_000)
    simulation.apply(["lead"], [0.4])
    simulation.step(2_000)
    pose = simulation.link_pose("beam")
    at = TILT - 0.4
    assert pose.position[0] == pytest.approx(LENGTH * math.sin(at), abs=2e-3)
    assert pose.position[2] == pytest.approx(2.0 - LENGTH * math.cos(at), abs=2e-3)
    assert pose.quaternion[2] == pytest.approx(0.0, abs=2e-3), "it stays level"


def test_a_joint_in_the_gazebo_of_a_urdf_holds_two_arms_together() -> None:
    arms = [
        part
        for name, y in (("left", 0.1), ("right", -0.1))
        for part in (
            urdf_link(name, INERTIAL),
            urdf_joint(f"{name}_hinge", "world", name, xyz=f"0 {y} 1"),
        )
    ]
    tie = (
        '<gazebo><joint name="tie" type="fixed"><parent>left</parent><child>right</child>'
        "</joint></gazebo>"
    )
    built = build_model(robot(urdf_link("world", ""), *arms, tie))
    assert any("Joint 'tie' closes a loop" in warning for warning in built.warnings)
    simulation = Simulation(built, control_period_ns=10_000_000)
    simulation.reset_state({"left_hinge": 0.1})
    simulation.step(1_000)
    simulation.read()
    left, right = simulation.positions
    assert left == pytest.approx(right, abs=1e-3)


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        ('<joint name="j" type="prismatic"/>', "of the type 'prismatic' in <gazebo> closes no"),
        ('<joint name="j" type="fixed"><parent>a</parent></joint>', "a <parent> and a <child>"),
        (
            '<joint name="j" type="ball"><parent>a</parent><child>b</child>'
            "<pose>1 2</pose></joint>",
            "its <pose> should be 6 numbers, got '1 2'",
        ),
        (
            '<joint name="j" type="revolute"><parent>a</parent><child>b</child>'
            "<axis><xyz>0 0 0</xyz></axis></joint>",
            "its axis has no direction",
        ),
    ],
)
def test_what_closes_no_loop_is_refused_in_words(joint: str, said: str) -> None:
    with pytest.raises(InvalidDescriptionError, match=re.escape(said)):
        _ = robot(urdf_link("a", ""), f"<gazebo>{joint}</gazebo>").gazebo


def tied(*joints: tuple[str, str, str, str]) -> tuple[SceneJoint, ...]:
    return tuple(
        SceneJoint(name, kind, parent, child, Transform())  # type: ignore[arg-type]
        for name, kind, parent, child in joints
    )


def test_balls_are_in_loops_rather_than_in_the_tree_and_joints_are_turned_around_for_it() -> None:
    joints = tied(
        ("rod", "ball", "hip", "rod"),
        ("leg", "revolute", "hip", "leg"),
        # The leg has a parent already, and the rod no other one but by a ball.
        ("heel", "revolute", "rod", "leg"),
    )
    tree, closing = tree_and_loops(joints, ["hip", "leg", "rod"])
    assert [(joint.name, joint.parent, joint.child) for joint in tree] == [
        ("leg", "hip", "leg"),
        ("heel", "leg", "rod"),
    ]
    assert tree[1].axis == (0.0, 0.0, -1.0)
    assert [joint.name for joint in closing] == ["rod"]


def test_a_ring_that_hangs_on_nothing_is_opened_at_its_first_link() -> None:
    ring = tied(
        ("ab", "revolute", "a", "b"), ("bc", "revolute", "b", "c"), ("ca", "fixed", "c", "a")
    )
    tree, closing = tree_and_loops(ring, ["a", "b", "c"])
    assert [joint.name for joint in tree] == ["ab", "bc"]
    assert [joint.name for joint in closing] == ["ca"]


def test_a_slide_that_closes_a_loop_is_left_out_and_told(tmp_path: Path) -> None:
    slide = LINKAGE[-1].replace("revolute", "prismatic")
    file = sdf(tmp_path, f"<model name='m'>{''.join((*LINKAGE[:-1], slide))}</model>")
    text = read_model(file).text
    assert "joint 'close' is left out: it slides and closes a loop" in text
