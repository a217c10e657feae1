"""Sampling a trajectory: degrees, edges, integration, cached index."""

import math

import pytest

from teleopctl.control.controllers.joint_trajectory.trajectory import (
    InterpolationMethod,
    Trajectory,
    TrajectoryPoint,
    shift_to_nearest_turn,
    shortest_angle,
)

SECOND = 1_000_000_000
START = 100 * SECOND


def ns(seconds: float) -> int:
    return START + round(seconds * SECOND)


def point(seconds, positions=(), velocities=(), accelerations=(), effort=()):
    return TrajectoryPoint(
        list(positions),
        list(velocities),
        list(accelerations),
        list(effort),
        round(seconds * SECOND),
    )


def begun(points, before) -> Trajectory:
    trajectory = Trajectory(points, START)
    trajectory.set_point_before(START, before)
    return trajectory


def sampled(trajectory, time_ns, *method):
    """The sample at a time, where there is one."""
    sample = trajectory.sample(time_ns, *method)
    assert sample is not None
    return sample


def near(value):
    return pytest.approx(value, abs=1e-8)


class TestPositionsOnly:
    @pytest.fixture
    def trajectory(self):
        points = [point(1, [1.0]), point(2, [2.0]), point(3, [3.0])]
        return begun(points, TrajectoryPoint([0.0]))

    @pytest.mark.parametrize(
        ("seconds", "position"),
        [(0, 0), (0.5, 0.5), (1.0, 1.0), (1.5, 1.5), (2.5, 2.5), (3.0, 3), (3.125, 3), (30, 3)],
    )
    def test_runs_in_straight_lines_and_stays_at_the_end(self, trajectory, seconds, position):
        state = sampled(trajectory, ns(seconds)).state
        assert state.positions == near([position])
        assert state.velocities == near([1.0 if seconds < 3 else 0.0])
        assert state.accelerations == near([0.0])

    def test_cannot_be_sampled_before_it_began(self, trajectory):
        assert trajectory.sample(ns(-0.5)) is None

    def test_names_the_points_around_the_sample(self, trajectory):
        indices, cached = [], []
        for seconds in (0.5, 1.0, 2.5, 3.5):
            sample = trajectory.sample(ns(seconds))
            indices.append((sample.start_index, sample.end_index))
            cached.append(trajectory.last_index)
        assert indices == [(0, 0), (0, 1), (1, 2), (2, 3)]
        assert cached == [0, 0, 1, 2]

    def test_between_first_and_second_point(self, trajectory):
        sample = trajectory.sample(ns(1.5))
        assert (sample.start_index, sample.end_index) == (0, 1)

    def test_an_update_forgets_where_the_sampling_was(self, trajectory):
        trajectory.sample(ns(2.5))
        assert trajectory.last_index == 1
        trajectory.update([point(1, [7.0])])
        assert trajectory.last_index == 0
        assert not trajectory.sampled_already
        assert trajectory.start_ns == 0


def test_an_empty_trajectory_starts_when_sampled_and_gives_nothing():
    trajectory = Trajectory()
    trajectory.set_point_before(START, TrajectoryPoint([0.0]))
    assert trajectory.sample(ns(1)) is None
    assert trajectory.start_ns == ns(1)


def test_without_a_stamp_a_trajectory_starts_when_first_sampled():
    trajectory = Trajectory([point(1, [1.0])])
    trajectory.set_point_before(START, TrajectoryPoint([0.0]))
    assert sampled(trajectory, START).state.positions == near([0.0])
    assert sampled(trajectory, ns(0.25)).state.positions == near([0.25])


@pytest.mark.parametrize("accelerations", [(), (3.0,)])
def test_velocities_at_both_ends_give_a_cubic(accelerations):
    trajectory = begun(
        [point(0, [0.0], [-2.0]), point(2, [4.0], [10.0], accelerations)], TrajectoryPoint([0.0])
    )
    root = math.sqrt(2.0)
    state = sampled(trajectory, ns(root)).state
    assert state.positions == near([0.0])
    assert state.velocities == pytest.approx([4.0], abs=1e-7)
    assert state.accelerations == pytest.approx([6.0 * root], abs=1e-7)
    last_instant = sampled(trajectory, ns(2) - 1).state
    assert last_instant.accelerations == pytest.approx([12.0], abs=1e-7)


def test_accelerations_at_both_ends_give_a_quintic():
    trajectory = begun(
        [point(0, [0.0], [24.0], [-100.0]), point(2, [0.0], [4.0], [0.0])], TrajectoryPoint([0.0])
    )
    state = sampled(trajectory, ns(1)).state
    assert state.positions == near([0.0])
    assert state.velocities == near([-6.0])
    assert state.accelerations == near([10.0])


def test_a_start_without_derivatives_is_taken_at_rest():
    points = [
        point(1, [1.0], [0.0], [0.0]),
        point(2, [2.0], [0.0], [0.0]),
    ]
    trajectory = begun(points, TrajectoryPoint([0.0]))
    state = sampled(trajectory, ns(0.25)).state
    t = 0.25
    assert state.positions == near([10 * t**3 - 15 * t**4 + 6 * t**5])
    assert state.accelerations == near([60 * t - 180 * t**2 + 120 * t**3])


class TestIntegration:
    @pytest.mark.parametrize(
        "before", [TrajectoryPoint([0.0], [0.0], [0.0]), TrajectoryPoint([0.0])]
    )
    def test_velocities_only(self, before):
        points = [point(1, (), [1.0]), point(2, (), [2.0]), point(3, (), [1.0])]
        trajectory = begun(points, before)
        middle = sampled(trajectory, ns(0.5)).state
        assert (middle.positions, middle.velocities) == (near([0.125]), near([0.5]))
        assert middle.accelerations == near([1.0])
        for seconds, position, velocity in [(1, 0.5, 1), (2, 2.0, 2), (3, 3.5, 1)]:
            state = sampled(trajectory, ns(seconds)).state
            assert state.positions == near([position])
            assert state.velocities == near([velocity])
        after = sampled(trajectory, ns(30)).state
        assert (after.positions, after.velocities) == (near([3.5]), near([1.0]))
        assert after.accelerations == near([0.0])

    def test_accelerations_only(self):
        points = [point(i, (), (), [a]) for i, a in [(1, 1.0), (2, 2.0), (3, 1.0)]]
        trajectory = begun(points, TrajectoryPoint([0.0]))
        for seconds, position, velocity in [(1, 0.25, 0.5), (2, 1.5, 2.0), (3, 4.25, 3.5)]:
            trajectory.sample(ns(seconds - 0.5))
            state = sampled(trajectory, ns(seconds)).state
            assert state.positions == near([position])
            assert state.velocities == near([velocity])
        after = sampled(trajectory, ns(30)).state
        assert (after.velocities, after.accelerations) == (near([3.5]), near([1.0]))

    def test_a_step_over_the_last_segment_still_finds_its_end(self):
        points = [point(1, (), [1.0]), point(2, (), [2.0]), point(3, (), [1.0])]
        trajectory = begun(points, TrajectoryPoint([0.0]))
        for seconds in (0.5, 1.5):
            trajectory.sample(ns(seconds))
        assert sampled(trajectory, ns(4)).state.positions == near([3.5])

    def test_points_that_no_sample_fell_between_are_integrated_too(self):
        points = [point(1, (), [1.0]), point(2, (), [2.0]), point(3, (), [1.0])]
        trajectory = begun(points, TrajectoryPoint([0.0]))
        assert sampled(trajectory, ns(2.5)).state.positions == near([0.5 + 1.5 + 0.875])
        assert sampled(trajectory, ns(4)).state.positions == near([3.5])

    def test_a_step_over_everything_still_finds_the_end(self):
        points = [point(1, (), [1.0]), point(2, (), [2.0]), point(3, (), [1.0])]
        trajectory = begun(points, TrajectoryPoint([0.0]))
        assert sampled(trajectory, ns(4)).state.positions == near([3.5])


def test_without_interpolation_the_next_point_is_taken_at_once():
    points = [point(1, [1.0]), point(2, [2.0]), point(3, [3.0])]
    trajectory = begun(points, TrajectoryPoint([0.0]))
    expected = {0.5: 0.0, 1.0: 2.0, 1.5: 2.0, 2.5: 3.0}
    for seconds, position in expected.items():
        state = sampled(trajectory, ns(seconds), InterpolationMethod.NONE).state
        assert state.positions == [position]
        assert state.velocities == []


def test_a_first_point_at_zero_is_a_step():
    trajectory = begun([point(0, [1.0])], TrajectoryPoint([0.0]))
    assert sampled(trajectory, START).state.positions == [1.0]


def test_effort_runs_in_a_straight_line():
    trajectory = begun(
        [point(0, [0.0], effort=[2.0]), point(2, [1.0], effort=[4.0])], TrajectoryPoint([0.0])
    )
    assert sampled(trajectory, ns(1)).state.effort == near([3.0])


class TestWraparound:
    def test_only_flagged_joints_take_the_shortest_way(self):
        target = [1.5 * math.pi, 1.5 * math.pi, 1.0]
        moved = shift_to_nearest_turn([0.0, 0.0, 0.0], target, [True, False, True])
        assert moved == near([2.0 * math.pi, 0.0, 0.0])

    def test_half_a_turn_keeps_its_direction(self):
        assert shortest_angle(0.0, math.pi) == near(math.pi)
        assert shortest_angle(math.pi, 0.0) == near(-math.pi)

    def test_the_point_before_is_shifted(self):
        trajectory = Trajectory([point(1, [1.5 * math.pi])], START)
        trajectory.set_point_before(START, TrajectoryPoint([0.0]), [True])
        assert sampled(trajectory, START).state.positions == near([2.0 * math.pi])
