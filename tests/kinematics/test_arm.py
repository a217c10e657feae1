"""Class `Arm`: kinematics of three, five, six and seven joints, beside yourdfpy."""

from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import yourdfpy

from teleopctl.errors import NotFoundError, UsageError
from teleopctl.kinematics import (
    Arm,
    CollisionBody,
    CollisionScene,
    CollisionShape,
    GroupKinematics,
    IkSolver,
    KinematicModel,
    ShapeKind,
    find_groups,
    gripper_ranges,
)
from teleopctl.robot import RobotDescription
from tests.kinematics.arms import FIVE, SEVEN, SIX, THREE, Y, arm_urdf

ARMS = {3: THREE, 5: FIVE, 6: SIX, 7: SEVEN}


@pytest.fixture(scope="module")
def arms() -> dict[int, Arm]:
    return {count: Arm(arm_urdf(links)) for count, links in ARMS.items()}


def random_positions(arm: Arm, count: int) -> np.ndarray:
    return np.random.default_rng(1).uniform(arm.lower, arm.upper, (count, len(arm.names)))


@pytest.mark.parametrize("count", [3, 6, 7])
def test_the_pose_of_the_tool_is_that_of_yourdfpy(arms, count):
    arm = arms[count]
    other = yourdfpy.URDF.load(StringIO(arm_urdf(ARMS[count])), load_meshes=False)
    for positions in random_positions(arm, 100):
        other.update_cfg(dict(zip(arm.names, positions, strict=True)))
        expected = other.get_transform("tool0", "base")
        np.testing.assert_allclose(arm.fk(positions), expected, atol=1e-9)


@pytest.mark.parametrize("count", [3, 7])
def test_the_jacobian_is_the_derivative_of_the_pose(arms, count):
    arm = arms[count]
    positions = random_positions(arm, 1)[0]
    jacobian, pose = arm.jacobian(positions), arm.fk(positions)
    step = 1e-6
    for place in range(count):
        moved = positions.copy()
        moved[place] += step
        change = (arm.fk(moved) - pose) / step
        turn = change[:3, :3] @ pose[:3, :3].T
        twist = [*change[:3, 3], turn[2, 1], turn[0, 2], turn[1, 0]]
        np.testing.assert_allclose(jacobian[:, place], twist, atol=1e-5)


@pytest.mark.parametrize("count", [3, 5, 6, 7])
def test_inverse_kinematics_reaches_what_the_joints_serve(arms, count):
    """Position with three joints, position and the tool's axis with five, the pose with six."""
    arm = arms[count]
    for positions in random_positions(arm, 12):
        target = arm.fk(positions)
        found = arm.ik(target, collisions=True)
        assert found.is_reached, positions
        assert np.all((found.positions >= arm.lower) & (found.positions <= arm.upper))
        reached = arm.fk(found.positions)
        assert np.linalg.norm(reached[:3, 3] - target[:3, 3]) < 1e-3
        if count == 5:
            assert reached[:3, 2] @ target[:3, 2] > np.cos(0.01)
        if count > 5:
            np.testing.assert_allclose(reached[:3, :3], target[:3, :3], atol=0.01)


def test_a_position_is_reached_with_any_rotation(arms):
    found = arms[6].ik([0.4, 0.1, 0.5])
    assert found.is_reached
    np.testing.assert_allclose(arms[6].fk(found.positions)[:3, 3], [0.4, 0.1, 0.5], atol=1e-3)


def test_a_wish_for_the_rotation_costs_no_position(arms):
    """With the elbow hardly bent, a wish of a fraction of a degree moves the tool by 0.15 mm."""
    arm = arms[3]
    target = arm.fk([0.0, 0.9, 0.2])
    for pose in (target[:3, 3], target @ np.diag([1.0, -1.0, -1.0, 1.0])):
        found = arm.ik(pose)
        assert found.is_reached
        assert found.position_error_m <= 1e-4


def test_what_is_out_of_reach_is_answered_with_the_nearest_position(arms):
    found = arms[3].ik([0.0, 0.0, 2.0])
    assert not found.is_reached
    assert found.binding == ("the arm is too short",)
    # Stretched upwards, the links add up to 0.65 m.
    assert found.position_error_m == pytest.approx(1.35, abs=1e-3)


def test_what_is_beside_the_plane_of_an_arm_is_said_to_be_in_no_joint_s_direction():
    planar = Arm(arm_urdf(((Y, 0.3), (Y, 0.3))))
    found = planar.ik([0.2, 0.1, 0.3])
    assert found.binding == ("the joints do not move the tool in that direction",)
    assert found.position_error_m == pytest.approx(0.1, abs=1e-3)
    assert planar.workspace(200, collisions=True).manipulability.max() > 0.05


def test_links_do_not_touch_in_a_solution():
    # Thick links, so that most of the ways to fold the arm touch.
    arm = Arm(arm_urdf(SEVEN, radius=0.06))
    found = arm.ik(arm.fk([0.2, 0.6, 0.1, 1.2, 0.0, 0.8, 0.0]), start=np.zeros(7))
    assert found.is_reached
    assert arm.collisions(found.positions) == []


def test_a_world_is_in_the_way(tmp_path: Path):
    file = tmp_path / "wall.sdf"
    file.write_text(
        """<sdf version="1.9"><world name="w"><model name="wall"><static>true</static>
        <pose>0.2 0 0.5 0 0 0</pose><link name="l"><collision name="c"><geometry><box>
        <size>0.1 1 1</size></box></geometry></collision></link></model></world></sdf>"""
    )
    free, walled = (Arm(arm_urdf(THREE), world=world) for world in (None, file))
    target = free.fk([0.0, 0.9, 0.2])
    assert free.ik(target[:3, 3]).is_reached
    blocked = walled.ik(target[:3, 3])
    assert not blocked.is_reached
    assert any("would collide" in each for each in blocked.binding)


def test_joints_are_set_by_name_by_place_and_by_state(arms):
    arm = arms[3]
    arm.positions = {"joint_2": 0.5}
    assert arm.positions.tolist() == [0.0, 0.5, 0.0]
    np.testing.assert_array_equal(arm.fk({"joint_1": 0.1}), arm.fk([0.1, 0.5, 0.0]))
    np.testing.assert_array_equal(arm.fk("zero"), arm.fk([0.0, 0.0, 0.0]))
    arm.positions = [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("positions", "error", "words"),
    [
        ([0.1, 0.2], UsageError, "has 3 joints, got 2 positions"),
        ([0.1, 0.2, float("nan")], UsageError, "no finite number"),
        ({"elbow": 0.1}, NotFoundError, "no joint 'elbow'"),
        ("rest", NotFoundError, "no state 'rest'"),
        ("nothing", NotFoundError, "Its states are: home, zero"),
    ],
)
def test_bad_positions_are_refused_with_what_would_be_right(arms, positions, error, words):
    with pytest.raises(error) as raised:
        arms[3].fk(positions)
    assert words in f"{raised.value.message} {raised.value.hint}"


@pytest.mark.parametrize(
    "pose", [np.zeros((4, 4)), np.full((4, 4), np.nan), [1.0, 2.0], [np.inf, 0, 0], "here"]
)
def test_bad_poses_are_refused(arms, pose):
    with pytest.raises(UsageError):
        arms[3].ik(pose)


def test_a_tool_is_a_link_or_an_offset_from_the_tip(arms):
    text = arm_urdf(THREE)
    elbow = Arm(text, tool="link_2")
    offset = Arm(text, tool=[0.0, 0.0, 0.1, np.pi, 0.0, 0.0])
    positions = [0.3, 0.4, -0.5]
    tip = arms[3].fk(positions)
    expected = tip.copy()
    expected[:3, 3] += 0.1 * tip[:3, 2]
    expected[:3, 1:3] *= -1.0
    np.testing.assert_allclose(offset.fk(positions), expected, atol=1e-12)
    assert np.linalg.norm(elbow.fk(positions)[:3, 3]) == pytest.approx(0.1)
    for tool, error in (("base", NotFoundError), ("claw", NotFoundError), ([1.0], UsageError)):
        with pytest.raises(error):
            Arm(text, tool=tool)


def test_the_workspace_of_a_chain_is_a_ball_without_what_touches(arms):
    space = arms[3].workspace(2_000)
    assert space.reach_m <= 0.65 + 1e-9
    assert space.reach_m > 0.6
    assert np.all(space.lower >= -0.56)
    assert space.samples == len(space.points) + space.colliding
    assert np.all(space.manipulability >= 0.0)


def test_plans_end_at_a_state_at_joints_at_a_pose_and_at_a_position(arms):
    arm = arms[6]
    arm.positions = [0.1, 0.5, -0.9, 0.4, 0.3, 0.5]
    goal = np.array([0.4, 0.6, -1.0, 0.3, 0.2, 0.1])
    pose = arm.fk(goal)
    np.testing.assert_allclose(arm.plan(goal).positions[-1], goal, atol=1e-9)
    named = arm.plan({"joint_1": 0.4})
    np.testing.assert_allclose(named.positions[-1], [0.4, *arm.positions[1:]], atol=1e-9)
    np.testing.assert_allclose(arm.fk(arm.plan(pose).positions[-1]), pose, atol=2e-3)
    reached = arm.fk(arm.plan(pose[:3, 3], is_position=True).positions[-1])
    np.testing.assert_allclose(reached[:3, 3], pose[:3, 3], atol=1e-3)
    np.testing.assert_allclose(named.positions[0], arm.positions, atol=1e-9)


def test_a_line_is_straight_and_keeps_the_rotation(arms):
    arm = arms[6]
    arm.positions = [0.1, 0.5, -0.9, 0.4, 0.3, 0.5]
    begin = arm.fk()
    plan = arm.line(begin[:3, 3] + [0.05, 0.0, -0.05])
    way = np.array([1.0, 0.0, -1.0]) / np.sqrt(2.0)
    for positions in plan.positions[:: max(1, len(plan.positions) // 20)]:
        pose = arm.fk(positions)
        off = pose[:3, 3] - begin[:3, 3]
        assert np.linalg.norm(off - (off @ way) * way) < 1e-3
        np.testing.assert_allclose(pose[:3, :3], begin[:3, :3], atol=2e-3)


def test_servo_follows_a_twist_from_the_present_positions(arms):
    arm = arms[6]
    arm.positions = [0.1, 0.5, -0.9, 0.4, 0.3, 0.5]
    begin = arm.fk()
    for _ in range(50):
        arm.servo_step([0.05, 0.0, 0.0, 0.0, 0.0, 0.0], 0.01)
    way = arm.fk()[:3, 3] - begin[:3, 3]
    assert way[0] == pytest.approx(0.025, abs=0.005)
    assert np.abs(way[1:]).max() < 1e-3
    for twist, period_s in (([0.1], 0.01), ([np.nan] * 6, 0.01), ([0.0] * 6, 0.0)):
        with pytest.raises(UsageError):
            arm.servo_step(twist, period_s)


def test_a_robot_is_a_file_a_text_or_what_has_the_text(tmp_path: Path):
    class HasText:
        urdf = arm_urdf(THREE)

    file = tmp_path / "arm.urdf"
    file.write_text(HasText.urdf)
    for robot in (file, str(file), HasText.urdf, HasText()):
        assert Arm(robot).names == ("joint_1", "joint_2", "joint_3")
    with pytest.raises(NotFoundError, match="There is no file"):
        Arm(tmp_path / "other.urdf")


FINGERS = """<link name="left"><collision><origin xyz="0 {side} 0.05"/><geometry>
  <box size="0.02 0.01 0.08"/></geometry></collision></link>
<joint name="left_finger" type="prismatic"><parent link="tool0"/><child link="left"/>
  <axis xyz="0 1 0"/><limit lower="-0.03" upper="0.04" velocity="0.1" effort="9"/></joint>
<link name="right"><collision><origin xyz="0 -{side} 0.05"/><geometry>
  <box size="0.02 0.01 0.08"/></geometry></collision></link>
<joint name="right_finger" type="prismatic"><parent link="tool0"/><child link="right"/>
  <axis xyz="0 -1 0"/><limit lower="-0.03" upper="0.04" velocity="0.1" effort="9"/>
  <mimic joint="left_finger"/></joint>"""
JAW = """<link name="jaw"><collision><origin xyz="0.02 0 0.05"/><geometry>
  <box size="0.01 0.02 0.08"/></geometry></collision></link>
<joint name="jaw" type="revolute"><parent link="link_3"/><child link="jaw"/>
  <origin xyz="0.02 0 0.25"/><axis xyz="0 1 0"/>
  <limit lower="{lower}" upper="{upper}" velocity="1" effort="9"/></joint>"""


@pytest.mark.parametrize(
    ("parts", "joint", "closed", "opened"),
    [
        (FINGERS.format(side=0.04), "left_finger", -0.03, 0.04),
        # The fingers have passed each other: the other end is the open one.
        (FINGERS.format(side=-0.05), "left_finger", 0.04, -0.03),
        (JAW.format(lower=0.0, upper=1.2), "jaw", 0.0, 1.2),
    ],
)
def test_the_open_side_of_a_gripper_is_that_at_which_its_fingers_are_apart(
    parts, joint, closed, opened
):
    description = RobotDescription.from_urdf(arm_urdf(THREE, extra=parts))
    groups = find_groups(description)
    model = KinematicModel(description)
    gripper = groups.gripper_of("arm")
    assert gripper is not None
    (found,) = gripper_ranges(model, gripper)
    assert (found.joint, found.closed, found.open) == (joint, closed, opened)
    assert found.position(0.5) == pytest.approx(0.5 * (closed + opened))


def test_a_pose_within_an_obstacle_needs_no_further_starts():
    scene = CollisionScene(KinematicModel(RobotDescription.from_urdf(arm_urdf(SIX))))
    own = GroupKinematics(scene.model, find_groups(scene.model.description).group())
    own.set(np.array([0.3, -0.4, 0.6, 0.2, 0.5, 0.1]))
    target = own.pose()
    box = CollisionShape.primitive(ShapeKind.BOX, (0.05, 0.05, 0.05))
    scene.add(CollisionBody("box", target, (box,), (np.eye(4),)))
    compiled = scene.compile()
    kinematics = GroupKinematics(compiled.model, own.group)
    found = IkSolver(kinematics, clearance=compiled.clearance).solve(target, kinematics.present())
    assert (found.is_reached, found.starts) == (False, 42)
