"""Timing of joint paths: the fastest law, limits resampled at 1 ms, jerk, rounded corners."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st

from teleopctl.errors import UsageError
from teleopctl.kinematics import GroupKinematics, KinematicModel, find_groups
from teleopctl.kinematics.motion.limits import MotionLimits
from teleopctl.kinematics.motion.path import JointPath
from teleopctl.kinematics.motion.timing import (
    excess,
    fastest_law,
    interpolated_excess,
    sampled,
    smoothed_law,
)
from teleopctl.robot import RobotDescription
from tests.kinematics.arms import THREE, arm, arm_urdf

ROUNDING = 1.0 + 1e-6


def limits(velocities, accelerations, jerk_time_s=0.1):
    velocities, accelerations = np.array(velocities), np.array(accelerations)
    with np.errstate(divide="ignore"):
        jerks = accelerations / jerk_time_s
    return MotionLimits(velocities, accelerations, jerks)


def random_problem(seed):
    generator = np.random.default_rng(seed)
    count = int(generator.integers(1, 8))
    velocities, accelerations = generator.uniform(0.5, 3, count), generator.uniform(1, 15, count)
    corners = generator.uniform(-2, 2, (int(generator.integers(2, 8)), count))
    return corners, limits(velocities, accelerations)


@pytest.mark.parametrize(
    ("distance", "duration"),
    [
        (0.1, 2.0 * math.sqrt(0.1 / 4.0)),  # never at full speed
        (3.0, 3.0 / 2.0 + 2.0 / 4.0),  # at full speed between
    ],
)
def test_one_joint_moves_in_the_shortest_time(distance, duration):
    path = JointPath.rounded(np.array([[1.0], [1.0 + distance]]), np.array([2.0]), 0.01)
    assert fastest_law(path, limits([2.0], [4.0])).duration_s == pytest.approx(duration, rel=2e-3)


def test_the_slowest_joint_decides_and_all_arrive_together():
    law = fastest_law(
        JointPath.rounded(np.array([[0.0, 0.0], [1.0, 1.0]]), np.ones(2), 0.0),
        limits([2.0, 0.5], [4.0, 100.0]),
    )
    assert law.duration_s == pytest.approx(1.0 / 0.5 + 0.5 / 4.0, rel=2e-3)
    positions, *_ = law.at(np.array([0.3, 1.0]))
    assert positions[:, 0] == pytest.approx(positions[:, 1])


@given(st.integers(0, 10_000))
def test_limits_are_kept_at_each_millisecond_and_jerk_after_smoothing(seed):
    corners, most = random_problem(seed)
    law = fastest_law(JointPath.rounded(corners, most.velocities, 0.05), most)
    velocity, acceleration, _ = excess(law, most)
    assert velocity <= 1.005
    assert acceleration <= ROUNDING
    smooth = smoothed_law(law, most)
    assert max(excess(smooth, most)) <= ROUNDING
    between = interpolated_excess(sampled(smooth, 0.01), most)
    assert max(between) <= 1.002
    assert law.duration_s < smooth.duration_s <= 1.005 * (law.duration_s + 0.3)


@given(st.integers(0, 10_000))
def test_points_begin_and_end_at_rest_and_their_derivatives_agree(seed):
    corners, most = random_problem(seed)
    law = smoothed_law(fastest_law(JointPath.rounded(corners, most.velocities, 0.05), most), most)
    times, positions, velocities, accelerations = sampled(law, 0.004)
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(law.duration_s)
    assert positions[[0, -1]] == pytest.approx(corners[[0, -1]], abs=1e-9)
    assert not velocities[[0, -1]].any()
    # The trapezoidal rule, whose error is bounded by the jerk: j dt³ / 12 a step.
    steps = np.diff(times)[:, None]
    moved = 0.5 * steps * (velocities[1:] + velocities[:-1])
    assert np.diff(positions, axis=0) == pytest.approx(moved, abs=150 * 0.004**3)
    gained = 0.5 * steps * (accelerations[1:] + accelerations[:-1])
    assert np.diff(velocities, axis=0) == pytest.approx(gained, abs=150 * 0.004**2)


@given(st.integers(0, 10_000), st.sampled_from([0.01, 0.1]))
def test_rounded_corners_stay_within_the_tolerance_of_the_polyline(seed, tolerance):
    corners, most = random_problem(seed)
    path = JointPath.rounded(corners, most.velocities, tolerance)
    for point in path.positions(np.linspace(0.0, path.length, 200)):
        distances = []
        for start, end in pairwise(corners):
            way = end - start
            part = np.clip((point - start) @ way / (way @ way), 0.0, 1.0)
            distances.append(np.linalg.norm(point - start - part * way))
        # Each joint is within the tolerance.
        assert min(distances) <= tolerance * math.sqrt(corners.shape[1]) + 1e-9


def test_the_direction_is_continuous_at_rounded_corners():
    path = JointPath.rounded(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), np.ones(2), 0.05)
    before, _ = path.derivatives(path.breaks[1:-1], np.arange(len(path.coefficients) - 1))
    after, _ = path.derivatives(path.breaks[1:-1])
    assert before == pytest.approx(after, abs=1e-9)
    # The corner itself is passed at the tolerance.
    middle = path.positions(np.array([0.5 * path.length]))[0]
    assert np.abs(middle - [1.0, 0.0]) == pytest.approx(0.05)


def test_without_tolerance_the_motion_stops_at_each_corner():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    most = limits([1.0, 1.0], [5.0, 5.0])
    law = fastest_law(JointPath.rounded(corners, np.ones(2), 0.0), most)
    assert law.duration_s == pytest.approx(2.0 * (1.0 + 1.0 / 5.0), rel=1e-2)
    middle = law.times[np.argmin(np.abs(law.parameters - 1.0))]
    positions, velocities, _ = law.at(np.array([middle]))
    assert positions[0] == pytest.approx(corners[1])
    assert velocities[0] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_path_that_goes_back_on_itself_turns_within_the_limits():
    corners = np.array([[0.0, 0.0], [1.0, 0.5], [0.0, 0.0]])
    most = limits([1.0, 1.0], [5.0, 5.0])
    law = fastest_law(JointPath.rounded(corners, np.ones(2), 0.02), most)
    assert excess(law, most)[1] <= ROUNDING
    assert law.duration_s < 2.0 * (1.0 + 1.0 / 5.0)


def test_collinear_corners_cost_nothing():
    most = limits([1.0, 2.0], [5.0, 5.0])
    line = np.array([[0.0, 0.0], [1.0, 0.5]])
    parts = line[0] + np.array([0.0, 0.2, 0.2, 0.7, 1.0])[:, None] * (line[1] - line[0])
    whole, split = (
        fastest_law(JointPath.rounded(corners, np.ones(2), 0.0), most) for corners in (line, parts)
    )
    assert split.duration_s == pytest.approx(whole.duration_s, rel=2e-3)


@pytest.mark.nightly
@given(st.integers(0, 10_000))
def test_a_path_whose_geometry_is_kept_is_followed_exactly_within_all_limits(seed):
    corners, most = random_problem(seed)
    path = JointPath.spline(corners, most.velocities)
    law = smoothed_law(fastest_law(path, most), most, keeps_path=True)
    assert max(excess(law, most)) <= 1.002
    _, positions, *_ = sampled(law, 0.1)
    dense = path.positions(np.linspace(0.0, path.length, 1000))
    gaps = [np.abs(dense - point).max(axis=1).min() for point in positions]
    assert max(gaps) < 0.01 * max(1.0, path.length)


def test_a_spline_passes_its_points_with_a_continuous_second_derivative():
    points = np.random.default_rng(3).uniform(-1, 1, (9, 4))
    path = JointPath.spline(points, np.ones(4))
    assert path.positions(path.breaks) == pytest.approx(points)
    inner = path.breaks[1:-1]
    for before, after in zip(
        path.derivatives(inner, np.arange(7)), path.derivatives(inner), strict=True
    ):
        assert before == pytest.approx(after, abs=1e-9)


def test_smoothing_takes_as_long_as_the_acceleration_takes_to_build_up():
    most = limits([2.0], [4.0], jerk_time_s=0.1)
    law = fastest_law(JointPath.rounded(np.array([[0.0], [3.0]]), np.ones(1), 0.0), most)
    smooth = smoothed_law(law, most)
    assert smooth.duration_s - law.duration_s == pytest.approx(0.1, abs=0.06)


def test_without_a_limit_of_jerk_nothing_is_smoothed():
    most = MotionLimits(np.ones(1), np.full(1, 4.0), np.full(1, np.inf))
    law = fastest_law(JointPath.rounded(np.array([[0.0], [3.0]]), np.ones(1), 0.0), most)
    assert smoothed_law(law, most).duration_s == pytest.approx(law.duration_s)


def test_scaled_limits_take_longer():
    corners, most = random_problem(5)
    path = JointPath.rounded(corners, most.velocities, 0.05)
    whole = fastest_law(path, most).duration_s
    half = fastest_law(path, most.scaled(0.5, 0.25)).duration_s
    assert half == pytest.approx(2.0 * whole, rel=1e-6)


@pytest.mark.parametrize("factors", [(0.0, 1.0), (1.0, 1.5), (math.nan, 1.0), (1.0, -0.1)])
def test_scaling_factors_outside_of_0_to_1_are_refused(factors):
    with pytest.raises(UsageError, match="scaling factor"):
        random_problem(0)[1].scaled(*factors)


def test_limits_that_the_description_lacks_are_assumed():
    most = MotionLimits.of(arm(THREE, velocity=2.0))
    assert most.velocities == pytest.approx([2.0] * 3)
    assert most.accelerations == pytest.approx([10.0] * 3)
    assert most.jerks == pytest.approx([100.0] * 3)
    assert most.assumed == ()


def test_a_joint_without_a_velocity_limit_moves_at_1_and_that_is_said():
    text = arm_urdf(THREE).replace(
        'velocity="2.0" effort="100"/></joint><link name="link_2"',
        ('velocity="0" effort="100"/></joint><link name="link_2"'),
    )
    description = RobotDescription.from_urdf(text)
    kinematics = GroupKinematics(KinematicModel(description), find_groups(description).group())
    most = MotionLimits.of(kinematics)
    assert most.velocities == pytest.approx([1.0, 2.0, 2.0])
    assert most.assumed == ("No velocity limit of 'joint_1': 1 rad/s or m/s is used",)


def test_given_accelerations_and_jerks_precede_those_of_the_description():
    most = MotionLimits.of(arm(THREE), {"joint_2": 3.0}, {"joint_3": 7.0})
    assert most.accelerations == pytest.approx([10.0, 3.0, 10.0])
    assert most.jerks == pytest.approx([100.0, 30.0, 7.0])
