"""Servo's steps: the tool moves as commanded, and whatever comes, all joints can still stop."""

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.kinematics import (
    ClearanceChecker,
    GroupKinematics,
    KinematicModel,
    ServoCore,
    ServoSettings,
    StatusCode,
    find_groups,
)
from teleopctl.robot import RobotDescription, read_world_text
from tests.kinematics.arms import FIVE, SEVEN, SIX, THREE, arm, arm_urdf
from tests.samples import sample

PERIOD_S = 0.01
BENT = {3: [0.2, 0.6, 0.9], 5: [0.2, 0.6, 0.9, 0.4, 0.1], 6: [0.2, 0.4, 1.1, 0.6, 0.9, 1.2]}
BENT[7] = [0.2, 0.6, 0.5, 1.1, 0.6, 1.0, 0.1]


def servo(kinematics, *, positions=None, obstacles=True, **settings):
    count = len(kinematics.names)
    speeds = np.array([limit.velocity for limit in kinematics.limits])
    clearance = ClearanceChecker(kinematics.model) if obstacles else None
    core = ServoCore(
        kinematics, speeds / 0.2, clearance=clearance, settings=ServoSettings(**settings)
    )
    core.reset(np.array(BENT[count] if positions is None else positions))
    return core


def tool(core):
    core.kinematics.set(core.positions)
    return core.kinematics.pose()


def run(core, twist, steps):
    return [core.twist_step(np.array(twist, float), PERIOD_S) for _ in range(steps)]


class TestTwists:
    @pytest.mark.parametrize("links", [THREE, FIVE, SIX, SEVEN])
    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_the_tool_moves_along_an_axis_of_the_root(self, links, axis):
        core = servo(arm(links))
        before = tool(core)[:3, 3]
        twist = np.zeros(6)
        twist[axis] = 0.05
        assert run(core, twist, 100)[-1].code is StatusCode.NO_WARNING
        moved = tool(core)[:3, 3] - before
        # 1 s at 0.05 m/s, less what the acceleration takes.
        assert 0.047 < moved[axis] <= 0.0501
        assert np.abs(np.delete(moved, axis)).max() < 5e-4

    @pytest.mark.parametrize("links", [SIX, SEVEN])
    def test_six_joints_turn_the_tool_in_place(self, links):
        core = servo(arm(links))
        before = tool(core)
        run(core, [0, 0, 0, 0, 0, 0.2], 100)
        after = tool(core)
        turn = after[:3, :3] @ before[:3, :3].T
        assert np.arctan2(turn[1, 0], turn[0, 0]) == pytest.approx(0.2, abs=0.02)
        assert np.abs(after[:3, 3] - before[:3, 3]).max() < 1e-3

    def test_three_joints_say_that_they_cannot_turn_it(self):
        core = servo(arm(THREE))
        (step,) = run(core, [0, 0, 0, 0, 0, 0.2], 1)
        assert not step.velocities.any()
        assert "3 joints cannot turn the tool in place" in step.message

    def test_five_joints_turn_it_about_the_axis_that_they_have(self):
        core = servo(arm(FIVE), positions=[0.0, 0.6, 0.9, 0.4, 0.1])
        before = tool(core)
        run(core, [0, 0, 0, 0, 0.2, 0], 50)
        after = tool(core)
        assert np.abs(after[:3, 3] - before[:3, 3]).max() < 1e-3
        assert after[2, 2] < before[2, 2] - 0.03

    def test_mimic_joints_move_the_tool_too(self):
        # A parallelogram: the third joint keeps the last link upright.
        text = arm_urdf(THREE).replace(
            '<joint name="joint_3" type="revolute">',
            '<joint name="joint_3" type="revolute"><mimic joint="joint_2" multiplier="-1"/>',
        )
        description = RobotDescription.from_urdf(text)
        kinematics = GroupKinematics(KinematicModel(description), find_groups(description).group())
        assert kinematics.names == ("joint_1", "joint_2")
        kinematics.set(np.array([0.0, 0.5]))
        pose = kinematics.pose()
        assert pose[:3, :3] == pytest.approx(np.eye(3), abs=1e-12)
        jacobian = kinematics.world_jacobian()
        kinematics.set(np.array([0.0, 0.5 + 1e-6]))
        moved = (kinematics.pose()[:3, 3] - pose[:3, 3]) / 1e-6
        assert jacobian[:3, 1] == pytest.approx(moved, abs=1e-5)


class TestPosesAndJoints:
    @pytest.mark.parametrize("links", [THREE, SIX, SEVEN])
    def test_a_pose_is_reached_on_a_straight_line_and_held(self, links):
        core = servo(arm(links))
        start = tool(core)
        target = start.copy()
        target[:3, 3] += [0.04, -0.06, 0.03]
        away = 0.0
        direction = (target[:3, 3] - start[:3, 3]) / np.linalg.norm(target[:3, 3] - start[:3, 3])
        for _ in range(150):
            step = core.pose_step(target, PERIOD_S)
            way = tool(core)[:3, 3] - start[:3, 3]
            away = max(away, float(np.linalg.norm(way - (way @ direction) * direction)))
        assert np.linalg.norm(tool(core)[:3, 3] - target[:3, 3]) < 1e-3
        assert away < 2e-3
        assert not step.is_moving

    def test_joints_follow_velocities(self):
        core = servo(arm(SIX))
        before = core.positions
        for _ in range(100):
            core.joint_step(np.array([0, 0, 0.1, 0, 0, -0.2]), PERIOD_S)
        moved = core.positions - before
        assert moved == pytest.approx([0, 0, 0.1, 0, 0, -0.2], abs=0.005)

    def test_displacements_end_at_their_target(self):
        core = servo(arm(SIX))
        target = float(core.positions[1]) + 0.3
        for _ in range(200):
            step = core.target_step({"joint_2": target}, np.full(6, 0.5), PERIOD_S)
        assert core.positions[1] == pytest.approx(target, abs=1e-5)
        assert not step.is_moving


class TestLimits:
    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_a_joint_stops_before_its_limit_and_is_named(self, sign):
        core = servo(arm(SIX), obstacles=False)
        steps = [
            core.joint_step(np.array([sign * 2.0, 0, 0, 0, 0, 0]), PERIOD_S) for _ in range(400)
        ]
        margin = 0.1
        assert abs(core.positions[0]) == pytest.approx(2.6 - margin, abs=1e-3)
        assert abs(core.positions[0]) <= 2.6 - margin + 1e-9
        assert steps[-1].code is StatusCode.JOINT_BOUND
        limit = "upper" if sign > 0 else "lower"
        assert f"joint 'joint_1' is near its {limit} limit" in steps[-1].message

    def test_a_joint_inside_its_margin_may_leave_it(self):
        core = servo(arm(SIX), positions=[2.58, 0.5, 0.9, 0.4, 0.3, 0.7], obstacles=False)
        core.joint_step(np.array([1.0, 0, 0, 0, 0, 0]), PERIOD_S)
        assert core.positions[0] == 2.58
        for _ in range(50):
            core.joint_step(np.array([-1.0, 0, 0, 0, 0, 0]), PERIOD_S)
        assert core.positions[0] < 2.5

    def test_one_joint_at_its_limit_halts_all_or_only_itself(self):
        fast = np.array([2.0, 0, 0, 0, 0, 0.5])
        at_limit = [2.5, 0.5, 0.9, 0.4, 0.3, 0.7]
        moved = {}
        for halts_all in (True, False):
            core = servo(
                arm(SIX),
                positions=at_limit,
                obstacles=False,
                halt_all_joints_in_joint_mode=halts_all,
            )
            for _ in range(50):
                core.joint_step(fast, PERIOD_S)
            moved[halts_all] = core.positions - at_limit
        assert moved[True] == pytest.approx(np.zeros(6), abs=1e-9)
        assert moved[False][0] == pytest.approx(0.0, abs=1e-9)
        assert moved[False][5] > 0.2

    def test_margins_are_one_or_as_many_as_joints(self):
        with pytest.raises(UsageError, match="2 values for 6 joints"):
            servo(arm(SIX), joint_limit_margins=(0.1, 0.2))


class TestSingularities:
    def test_a_stretched_arm_comes_back(self):
        core = servo(arm(THREE), positions=[0.0, 0.7, 0.0], obstacles=False)
        inwards = -tool(core)[:3, 2]
        before = tool(core)[:3, 3]
        run(core, [*(0.1 * inwards), 0, 0, 0], 200)
        assert (tool(core)[:3, 3] - before) @ inwards > 0.1

    def test_on_the_way_to_it_the_tool_slows_down_and_keeps_its_path(self):
        kinematics = arm(THREE)
        core = servo(kinematics, positions=[0.0, 0.7, 0.22], obstacles=False)
        kinematics.set(core.positions)
        jacobian = kinematics.world_jacobian()[:3]
        values = np.linalg.svd(jacobian, compute_uv=False)
        assert 17.0 < values[0] / values[2] < 23.0
        command = 0.01 * tool(core)[:3, 2] + np.array([0.0, 0.02, 0.0])
        (step,) = run(core, [*command, 0, 0, 0], 1)
        assert step.code is StatusCode.DECELERATE_FOR_APPROACHING_SINGULARITY
        moved = jacobian @ step.velocities
        part = moved @ command / (command @ command)
        assert 0.0 < part < 1.0
        assert moved == pytest.approx(part * command, abs=1e-6)

    def test_it_stretches_no_further_but_moves_across(self):
        core = servo(arm(THREE), positions=[0.0, 0.7, 0.02], obstacles=False)
        outwards = tool(core)[:3, 2]
        stuck = run(core, [*(0.1 * outwards), 0, 0, 0], 100)[-1]
        assert stuck.code is StatusCode.HALT_FOR_SINGULARITY
        assert np.abs(stuck.velocities).max() < 0.01
        before = tool(core)[:3, 3]
        run(core, [*(0.1 * outwards + np.array([0.0, 0.05, 0.0])), 0, 0, 0], 100)
        assert (tool(core)[:3, 3] - before)[1] > 0.03


class TestObstacles:
    def test_links_stop_before_they_touch(self):
        core = servo(arm(SIX), positions=[0.0, 0.0, 1.5, 1.2, 0.0, 0.0])
        for _ in range(400):
            step = core.joint_step(np.array([0, 0, 1.0, 1.0, 0, 0]), PERIOD_S)
        core.kinematics.set(core.positions)
        near = ClearanceChecker(core.kinematics.model).near(0.05)
        assert 0.002 <= near[0].distance_m < 0.01
        assert step.code is StatusCode.HALT_FOR_COLLISION
        assert "m from 'link_" in step.message

    @pytest.mark.parametrize("links", sample([THREE, SIX, SEVEN], 3))
    def test_random_commands_pass_no_limit_and_touch_nothing(self, links):
        core = servo(arm(links))
        kinematics = core.kinematics
        clearance = ClearanceChecker(kinematics.model)
        generator = np.random.default_rng(3)
        before = core.velocities
        for number in range(2000):
            if number % 40 == 0:
                twist = generator.normal(size=6) * [0.6, 0.6, 0.6, 1.2, 1.2, 1.2]
            step = core.twist_step(twist, PERIOD_S)
            assert np.abs(step.velocities).max() <= 2.0 + 1e-9
            assert np.abs(step.velocities - before).max() <= 10.0 * PERIOD_S + 1e-9
            before = step.velocities
            if number % 10 == 0:
                kinematics.set(step.positions)
                near = clearance.near(0.01)
                assert not near or near[0].distance_m > 0.0015
        assert np.abs(core.positions).max() <= 2.5 + 1e-9

    def test_random_commands_touch_no_obstacle_with_any_part_of_a_link(self):
        # Beside a wall a link turns about its nearest point, and its far end comes near.
        world = read_world_text(
            "things:\n"
            "  floor: {shape: box, size: [3, 3, 0.02], at: [0, 0, -0.02]}\n"
            "  wall: {shape: box, size: [0.05, 2, 1.2], at: [0.35, 0, 0.6]}\n"
            "  shelf: {shape: box, size: [0.4, 0.6, 0.03], at: [-0.4, 0, 0.45]}\n",
            "world.yaml",
        )
        description = RobotDescription.from_urdf(arm_urdf(SIX))
        kinematics = GroupKinematics(
            KinematicModel(description, world), find_groups(description).group()
        )
        clearance = ClearanceChecker(kinematics.model)
        core = ServoCore(kinematics, np.full(6, 10.0), clearance=clearance)
        core.reset(np.array([0.0, -0.4, 0.3, 0.5, 0.3, 0.2]))
        generator = np.random.default_rng(2)
        nearest = np.inf
        for number in range(3000):
            if number % 30 == 0:
                velocities = generator.normal(size=6) * 1.5
            step = core.joint_step(velocities, PERIOD_S)
            if number % 3 == 0:
                kinematics.set(step.positions)
                near = clearance.near(0.01)
                nearest = min(nearest, near[0].distance_m if near else np.inf)
        assert 0.0 < nearest < 0.01

    def test_without_commands_all_joints_stop_within_their_limits(self):
        core = servo(arm(SIX))
        run(core, [0.0, 0.3, 0.0, 0.0, 0.0, 0.0], 50)
        assert not core.is_still
        before, at = core.velocities, core.positions
        steps = [core.halt_step(PERIOD_S).velocities for _ in range(20)]
        changes = np.diff([before, *steps], axis=0)
        assert np.abs(changes).max() <= 10.0 * PERIOD_S + 1e-9
        # All joints stop from their velocity limits within 0.2 s.
        assert core.is_still
        # The direction stays: all joints stop together.
        moved = core.positions - at
        assert moved @ moved > 0.0
