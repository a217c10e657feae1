"""Plans: to joints, to poses, along straight lines of the tool; timed, free and within limits."""

import math

import numpy as np
import pytest

from teleopctl.errors import UsageError
from teleopctl.kinematics import (
    ClearanceChecker,
    MotionLimits,
    MotionSettings,
    MoveItErrorCode,
    PlanningError,
    plan_line,
    plan_to_joints,
    plan_to_pose,
)
from teleopctl.kinematics.motion.edges import EdgeChecker
from teleopctl.kinematics.motion.line import JointJump, compute_cartesian_path
from teleopctl.kinematics.poses import rotation_matrix
from tests.kinematics.arms import FIVE, SEVEN, SIX, THREE, arm
from tests.kinematics.motion.scenes import SHELF, TABLE, deepest, queries, scene

# The six-joint arm, bent, with its tool in front of it.
BENT = np.array([0.3, 0.6, 1.0, 0.5, 0.2, -0.4])
UP = np.zeros(7)
INTO_TABLE = np.array([0.0, 1.65, 0.0, 0.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def table():
    return scene(TABLE)


@pytest.fixture
def six():
    kinematics = arm(SIX)
    kinematics.set(BENT)
    return kinematics


def moved(kinematics, *offset, turn=(0.0, 0.0, 0.0)):
    """Return the tool's present pose, moved in the root's axes and turned in its own."""
    pose = kinematics.pose()
    pose[:3, 3] += offset
    pose[:3, :3] = pose[:3, :3] @ rotation_matrix(np.array(turn))
    return pose


def assert_within_limits(plan, limits):
    assert (np.diff(plan.times) > 0.0).all()
    assert (np.abs(plan.velocities) <= 1.002 * limits.velocities).all()
    assert (np.abs(plan.accelerations) <= 1.002 * limits.accelerations).all()
    jerks = np.diff(plan.accelerations, axis=0) / np.diff(plan.times)[:, None]
    assert (np.abs(jerks) <= 1.002 * limits.jerks).all()
    assert not plan.velocities[[0, -1]].any()


def off_line(kinematics, plan, start, end):
    """Return the largest distance (m) of the tool from the line between two poses."""
    way = (end - start)[:3, 3]
    away = []
    for positions in plan.positions:
        kinematics.set(positions)
        offset = kinematics.pose()[:3, 3] - start[:3, 3]
        part = np.clip(offset @ way / (way @ way), 0.0, 1.0)
        away.append(float(np.linalg.norm(offset - part * way)))
    return max(away)


# --- to joints and poses ------------------------------------------------------------------------


def test_plans_in_a_shelf_are_free_between_their_points_and_within_limits():
    kinematics, clearance = scene(SHELF)
    limits = MotionLimits.of(kinematics)
    for start, goal in list(queries(kinematics, clearance, SHELF, 6))[2:]:
        plan = plan_to_joints(kinematics, start, goal, clearance=clearance)
        assert plan.positions[[0, -1]] == pytest.approx(np.array([start, goal]), abs=1e-9)
        assert deepest(kinematics, clearance, plan.positions) == math.inf
        assert_within_limits(plan, limits)
        assert plan.duration_before_jerk_s < plan.duration_s
        assert plan.computing_s > 0.0


def test_the_model_is_where_it_was_after_planning(table):
    kinematics, clearance = table
    start = np.full(7, 0.1)
    plan_to_joints(kinematics, start, np.full(7, 0.5), clearance=clearance)
    assert kinematics.present() == pytest.approx(start)
    with pytest.raises(PlanningError):
        plan_to_joints(kinematics, start, INTO_TABLE, clearance=clearance)
    assert kinematics.present() == pytest.approx(start)


def test_a_plan_to_the_start_is_one_point():
    plan = plan_to_joints(arm(THREE), np.full(3, 0.2), np.full(3, 0.2))
    assert plan.times.tolist() == [0.0]
    assert plan.positions == pytest.approx(np.full((1, 3), 0.2))
    assert plan.duration_s == plan.duration_before_jerk_s == 0.0


def test_half_the_speed_takes_twice_as_long():
    kinematics, goal = arm(THREE, velocity=0.2), np.full(3, 1.0)
    whole = plan_to_joints(kinematics, np.zeros(3), goal)
    half = plan_to_joints(
        kinematics, np.zeros(3), goal, settings=MotionSettings(velocity_scaling=0.5)
    )
    assert half.duration_s == pytest.approx(2.0 * whole.duration_s, rel=0.05)


def test_points_come_at_equal_times_at_most_a_period_apart():
    plan = plan_to_joints(
        arm(THREE), np.zeros(3), np.full(3, 1.0), settings=MotionSettings(period_s=0.05)
    )
    steps = np.diff(plan.times)
    assert steps == pytest.approx(steps[0])
    assert 0.045 < steps[0] <= 0.05 + 1e-9


def test_a_pose_is_reached_past_obstacles(table):
    kinematics, clearance = table
    goal = np.array([0.9, 0.8, 0.2, 0.9, -0.3, 0.5, 0.1])
    kinematics.set(goal)
    target = kinematics.pose()
    plan = plan_to_pose(kinematics, UP, target, clearance=clearance)
    kinematics.set(plan.positions[-1])
    assert kinematics.pose() == pytest.approx(target, abs=2e-3)
    assert deepest(kinematics, clearance, plan.positions) == math.inf


def test_a_pose_out_of_reach_says_how_far_and_why():
    kinematics = arm(SIX)
    kinematics.set(BENT)
    with pytest.raises(PlanningError, match=r"cannot be reached, .* mm away: .*short") as caught:
        plan_to_pose(kinematics, BENT, moved(kinematics, 3.0, 0.0, 0.0))
    assert caught.value.code is MoveItErrorCode.NO_IK_SOLUTION


def test_of_an_arm_that_turns_more_than_once_the_nearer_turn_is_taken():
    kinematics = arm(SIX, limit=6.2)
    far = BENT + np.array([2.0 * math.pi, 0.0, 0.0, 0.0, 0.0, 0.0]) * -1.0
    kinematics.set(far)
    target = kinematics.pose()
    plan = plan_to_pose(kinematics, BENT + 0.1, target)
    assert np.abs(plan.positions[-1] - BENT - 0.1).max() <= math.pi


def test_a_start_in_collision_moves_apart_first_and_rests_there(table):
    kinematics, clearance = table
    edges = EdgeChecker(kinematics, clearance)
    touching = (edges.free_part(UP, INTO_TABLE) + 0.01) * INTO_TABLE
    plan = plan_to_joints(kinematics, touching, UP, clearance=clearance)
    assert "moving them apart" in plan.notes[0]
    assert plan.positions[0] == pytest.approx(touching)
    still = np.flatnonzero(np.abs(plan.velocities).max(axis=1) < 1e-9)
    assert len(still) == 3
    assert deepest(kinematics, clearance, plan.positions[still[1] :]) == math.inf
    assert_within_limits(plan, MotionLimits.of(kinematics))


@pytest.mark.parametrize(
    ("start", "goal", "code", "text"),
    [
        ([0.0, 0.0], [0.0] * 3, MoveItErrorCode.INVALID_ROBOT_STATE, "start has 2 positions"),
        ([0.0, math.nan, 0.0], [0.0] * 3, MoveItErrorCode.INVALID_ROBOT_STATE, "'joint_2' is nan"),
        ([0.0] * 3, [0.0] * 4, MoveItErrorCode.INVALID_GOAL_CONSTRAINTS, "goal has 4 positions"),
        ([0.0] * 3, [math.inf, 0, 0], MoveItErrorCode.INVALID_GOAL_CONSTRAINTS, "'joint_1' is inf"),
    ],
)
def test_positions_that_are_none_are_refused(start, goal, code, text):
    with pytest.raises(PlanningError, match=text) as caught:
        plan_to_joints(arm(THREE), np.array(start), np.array(goal))
    assert caught.value.code is code


@pytest.mark.parametrize(
    "settings",
    [
        {"timeout_s": 0.0},
        {"timeout_s": math.nan},
        {"velocity_scaling": 0.0},
        {"acceleration_scaling": 2.0},
        {"path_tolerance": -0.1},
        {"period_s": 0.0},
        {"planner": "nonsense"},
    ],
)
def test_settings_that_make_no_sense_are_refused(settings):
    with pytest.raises(UsageError):
        plan_to_joints(arm(THREE), np.zeros(3), np.ones(3), settings=MotionSettings(**settings))


def test_a_condition_holds_at_all_points():
    kinematics = arm(SEVEN)

    # The tool keeps above a height.
    def is_high(positions):
        kinematics.set(positions)
        return bool(kinematics.pose()[2, 3] > 0.3)

    goal = np.array([0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0])
    plan = plan_to_joints(kinematics, -goal, goal, condition=is_high)
    assert all(map(is_high, plan.positions))


# --- straight lines -----------------------------------------------------------------------------


def test_a_line_of_20_cm_is_straight_to_a_tenth_of_a_millimetre_and_within_limits(six):
    start, end = six.pose(), moved(six, -0.1, 0.15, -0.08)
    plan = plan_line(six, BENT, [end])
    assert plan.fraction == 1.0
    assert off_line(six, plan, start, end) < 1e-4
    six.set(plan.positions[-1])
    assert six.pose() == pytest.approx(end, abs=1e-5)
    assert_within_limits(plan, MotionLimits.of(six))


def test_a_rotation_is_spread_over_the_line(six):
    start, end = six.pose(), moved(six, 0.0, 0.0, -0.1, turn=(0.0, 0.0, 0.8))
    path = compute_cartesian_path(six, BENT, [end])
    for positions in path.positions:
        six.set(positions)
        pose = six.pose()
        part = np.linalg.norm(pose[:3, 3] - start[:3, 3]) / 0.1
        turned = start[:3, :3] @ rotation_matrix(np.array([0.0, 0.0, 0.8 * part]))
        assert pose[:3, :3] == pytest.approx(turned, abs=1e-3)


def test_the_steps_are_no_longer_than_asked(six):
    path = compute_cartesian_path(six, BENT, [moved(six, -0.1, 0.0, 0.0)], max_step_m=0.02)
    origins = []
    for positions in path.positions:
        six.set(positions)
        origins.append(six.pose()[:3, 3])
    steps = np.linalg.norm(np.diff(origins, axis=0), axis=1)
    assert len(steps) >= 5
    assert steps.max() <= 0.02 + 1e-6


def test_the_motion_stops_at_a_sharp_corner_and_not_at_dense_points(six):
    corner = [moved(six, -0.08, 0.0, 0.0), moved(six, -0.08, 0.0, -0.08)]
    plan = plan_line(six, BENT, corner)
    still = np.flatnonzero(np.abs(plan.velocities).max(axis=1) < 1e-6)
    assert len(still) == 3
    assert off_line(six, plan, corner[0], corner[1]) > 0.01
    dense = [moved_along(six, angle) for angle in np.linspace(0.0, math.pi, 40)[1:]]
    arc = plan_line(six, BENT, dense)
    assert len(np.flatnonzero(np.abs(arc.velocities).max(axis=1) < 1e-6)) == 2


def moved_along(kinematics, angle):
    """Return a pose on a half circle of 10 cm that begins at the bent arm's pose."""
    kinematics.set(BENT)
    return moved(kinematics, 0.05 * (math.cos(angle) - 1.0), 0.0, -0.05 * math.sin(angle))


def test_a_line_out_of_reach_ends_with_its_fraction_and_the_reason(six):
    path = compute_cartesian_path(six, BENT, [moved(six, 0.0, 0.0, 2.0)])
    assert 0.0 < path.fraction < 1.0
    assert path.code is MoveItErrorCode.NO_IK_SOLUTION
    assert "short" in path.reason or "limit" in path.reason
    six.set(BENT)
    with pytest.raises(PlanningError, match=r"can be followed to \d+ %") as caught:
        plan_line(six, BENT, [moved(six, 0.0, 0.0, 2.0)])
    assert caught.value.code is MoveItErrorCode.NO_IK_SOLUTION
    six.set(BENT)
    partial = plan_line(six, BENT, [moved(six, 0.0, 0.0, 2.0)], least_fraction=0.0)
    assert partial.fraction == pytest.approx(path.fraction)
    assert "The line ends at" in partial.notes[0]


def test_a_line_into_an_obstacle_ends_before_it_and_names_it(table):
    kinematics, clearance = table
    start = np.array([0.6, 0.4, 0.0, 1.3, 0.0, 0.4, 0.0])
    kinematics.set(start)
    down = moved(kinematics, 0.0, 0.0, -0.6)
    path = compute_cartesian_path(
        kinematics, start, [down], edges=EdgeChecker(kinematics, clearance)
    )
    assert 0.0 < path.fraction < 1.0
    assert path.code is MoveItErrorCode.INVALID_MOTION_PLAN
    assert "collision of" in path.reason
    assert deepest(kinematics, clearance, path.positions) == math.inf


def test_jumps_end_the_line_by_moveits_thresholds(six):
    target = [moved(six, 0.0, 0.1, -0.1)]
    whole = compute_cartesian_path(six, BENT, target)
    largest = float(np.abs(np.diff(whole.positions, axis=0)).max())
    allowed = compute_cartesian_path(six, BENT, target, jump=JointJump(revolute=1.5 * largest))
    assert allowed.fraction == 1.0
    ended = compute_cartesian_path(six, BENT, target, jump=JointJump(revolute=0.5 * largest))
    assert ended.fraction < 1.0
    assert "jumps by" in ended.reason
    assert compute_cartesian_path(six, BENT, target, jump=JointJump(10.0)).fraction == 1.0
    factor = compute_cartesian_path(six, BENT, target, jump=JointJump(1.01))
    assert factor.fraction < 1.0
    assert "average steps" in factor.reason


@pytest.mark.parametrize("links", [THREE, FIVE])
def test_arms_with_fewer_joints_follow_the_line_with_their_origin(links):
    kinematics = arm(links)
    start = np.array([0.2, 0.5, 0.9, 0.4, 0.0])[: len(links)]
    kinematics.set(start)
    begin, end = kinematics.pose(), moved(kinematics, 0.02, 0.1, -0.05)
    plan = plan_line(kinematics, start, [end])
    assert off_line(kinematics, plan, begin, end) < 5e-4


def test_a_line_to_where_the_tool_is_takes_no_time(six):
    plan = plan_line(six, BENT, [six.pose()])
    assert plan.duration_s == 0.0
    assert plan.fraction == 1.0


@pytest.mark.parametrize("change", [{"max_step_m": 0.0}, {"jump_factor": -1.0}, {"jump_rad": -0.1}])
def test_steps_and_thresholds_that_make_no_sense_are_refused(six, change):
    with pytest.raises(UsageError, match="max_step above 0"):
        plan_line(six, BENT, [six.pose()], **change)


@pytest.mark.parametrize("value", [math.nan, math.inf, 3.0])
def test_a_pose_that_is_none_is_refused(six, value):
    pose = six.pose()
    pose[0, 0] = value
    for plan in (lambda: plan_line(six, BENT, [pose]), lambda: plan_to_pose(six, BENT, pose)):
        with pytest.raises(UsageError, match="pose"):
            plan()


def test_steps_without_end_are_refused(six):
    with pytest.raises(UsageError, match="100000 steps of 1e-06 m, more than 20000"):
        plan_line(six, BENT, [moved(six, -0.1, 0.0, 0.0)], max_step_m=1e-6)


def test_a_motion_of_hours_is_refused_and_one_of_minutes_is_not():
    kinematics = arm(THREE)
    slow = [MotionSettings(velocity_scaling=part) for part in (1e-3, 1e-5)]
    plan = plan_to_joints(kinematics, np.zeros(3), np.ones(3), settings=slow[0])
    assert plan.duration_s == pytest.approx(500.0, rel=0.01)
    with pytest.raises(UsageError, match=r"takes 50\d\d\d s"):
        plan_to_joints(kinematics, np.zeros(3), np.ones(3), settings=slow[1])


def test_a_line_from_a_start_in_collision_is_refused(table):
    kinematics, clearance = table
    with pytest.raises(PlanningError, match="start is in collision") as caught:
        plan_line(kinematics, INTO_TABLE, [np.eye(4)], clearance=clearance)
    assert caught.value.code is MoveItErrorCode.START_STATE_IN_COLLISION


def test_distances_of_allowed_pairs_do_not_matter(table):
    kinematics, _ = table
    lenient = ClearanceChecker(kinematics.model)
    names = [kinematics.model.mj_model.body(n).name for n in range(kinematics.model.mj_model.nbody)]
    lenient.allow((one, other) for one in names for other in names)
    plan = plan_to_joints(kinematics, UP, INTO_TABLE, clearance=lenient)
    assert plan.planner == "straight"
