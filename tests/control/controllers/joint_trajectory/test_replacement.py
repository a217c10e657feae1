"""A new trajectory while one is running: replaced, or continued without a jump; upsampling.

Three joints start at (1.1, 2.1, 3.1) rad; the controller runs at 100 Hz.
"""

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from teleopctl.control.controllers.joint_trajectory.upsampling import spline_velocities, upsample
from teleopctl.interfaces import to_nanoseconds
from teleopctl.testing import serial_robot
from tests.control.controllers.joint_trajectory.arm import (
    JOINTS,
    Arm,
    near,
    point,
    trajectory,
)


@pytest.fixture
def arm():
    return Arm(allow_trajectory_replacement=True, allow_partial_joints_goal=True).up()


def reference(arm):
    return arm.state_messages[-1].reference.positions


class TestBlending:
    def test_the_reference_does_not_jump_at_half_speed(self):
        arm = Arm(allow_trajectory_replacement=True, speed_scaling__initial_scaling_factor=0.5).up()
        arm.send(trajectory(point(1, [11.1, 12.1, 13.1]), point(2, [21.1, 22.1, 23.1])))
        arm.step(1.0)
        before = reference(arm)
        arm.send(trajectory(point(1, [0, 0, 0]), point(2, [-5, -5, -5])))
        arm.step(0.03)
        assert reference(arm) == near(before, 0.3)

    def test_a_new_trajectory_goes_on_from_the_reference_and_its_velocity(self, arm):
        arm.freeze()
        arm.send(
            trajectory(point(1, [2.1, 3.1, 4.1], [1, 1, 1]), point(2, [3.1, 4.1, 5.1], [0, 0, 0]))
        )
        arm.step(0.5)
        before = arm.state_messages[-1].reference
        arm.send(trajectory(point(1, [5, 5, 5], [0, 0, 0])))
        arm.stack.step()
        after = arm.state_messages[-1].reference
        assert after.positions == near(before.positions, 0.02)
        assert after.velocities == near(before.velocities, 0.2)

    def test_a_joint_that_is_left_out_goes_on_and_outlasts_the_new_trajectory(self, arm):
        arm.send(trajectory(point(1.5, [1.1, 2.1, 13.1]), point(3, [1.1, 2.1, 23.1])))
        arm.step(0.3)
        arm.send(trajectory(point(0.3, [-3.9, -2.9]), point(0.6, [-8.9, -7.9]), joints=JOINTS[:2]))
        arm.step(0.8)
        first = reference(arm)
        assert first[:2] == near([-8.9, -7.9])
        arm.step(0.6)
        assert reference(arm)[2] > first[2] + 0.5
        arm.step(2.0)
        assert reference(arm) == near([-8.9, -7.9, 23.1])

    def test_a_joint_that_is_commanded_follows_the_old_path_until_the_new_one_starts(self, arm):
        arm.send(trajectory(point(0.5, [10, 2.1, 3.1]), point(1, [0, 2.1, 3.1])))
        arm.step(0.05)
        later_ns = arm.stack.time_ns + 1_450_000_000
        arm.send(trajectory(point(0.5, [-5, -5, -5]), point(1, [-5, -5, -5]), stamp_ns=later_ns))
        positions = []
        for _ in range(140):
            arm.stack.step()
            positions.append(reference(arm)[0])
        assert max(positions) > 8
        arm.step(1.2)
        assert reference(arm) == near([-5, -5, -5])

    def test_the_handoff_is_a_point_of_the_old_trajectory(self, arm):
        arm.send(trajectory(point(1, [5, 5, 5]), point(2, [50, 50, 50])))
        arm.step(0.5)
        halfway_ns = arm.stack.time_ns + 1_000_000_000
        arm.send(trajectory(point(1, [0, 0, 0]), stamp_ns=halfway_ns))
        arm.step(1.0)
        assert reference(arm) == near([27.5] * 3, 2)

    def test_a_hold_is_replaced_at_once(self, arm):
        """Nothing is running: the new trajectory stretches from now, as without the parameter."""
        arm.step(0.1)
        arm.send(trajectory(point(0.3, [4, 5, 6]), stamp_ns=arm.stack.time_ns + 500_000_000))
        arm.step(0.4)
        assert 1.1 < reference(arm)[0] < 4
        arm.step(0.8)
        assert reference(arm) == near([4, 5, 6])

    def test_trajectories_can_follow_each_other_in_quick_succession(self, arm):
        arm.send(trajectory(point(2, [5, 5, 5]), point(4, [5, 5, 5])))
        arm.step(0.2)
        arm.send(trajectory(point(0.5, [-3] * 3), stamp_ns=arm.stack.time_ns + 400_000_000))
        arm.step(0.5)
        arm.send(trajectory(point(0.5, [7, 7, 7])))
        arm.step(0.8)
        assert reference(arm) == near([7, 7, 7], 0.2)

    def test_a_partial_trajectory_without_positions_replaces_the_running_one(self):
        arm = Arm(
            allow_trajectory_replacement=True,
            allow_partial_joints_goal=True,
            allow_integration_in_goal_trajectories=True,
        ).up()
        arm.send(trajectory(point(1, [2, 3, 4]), point(2, [3, 4, 5])))
        arm.step(0.5)
        held = arm.commands[2]
        arm.send(trajectory(point(0.5, [], [0.0, 0.0]), joints=JOINTS[:2]))
        arm.step(1.0)
        assert arm.commands[2] == near(held, 0.05)

    def test_without_the_parameter_a_joint_that_is_left_out_stops(self):
        arm = Arm(allow_partial_joints_goal=True).up()
        arm.send(trajectory(point(1.5, [1.1, 2.1, 13.1]), point(3, [1.1, 2.1, 23.1])))
        arm.step(0.3)
        held = arm.commands[2]
        arm.send(trajectory(point(0.3, [-3.9, -2.9]), joints=JOINTS[:2]))
        arm.step(1.0)
        assert arm.commands[2] == near(held)


class TestUpsampling:
    def test_inner_points_get_the_velocities_of_a_smooth_spline(self):
        message = trajectory(*(point(0.1 * n, [p]) for n, p in ((1, 0.0), (2, 0.1), (3, 0.3))))
        upsample(message, 0.0)
        assert [list(p.velocities) for p in message.points] == [[0.0], [near(2.25)], [0.0]]

    @settings(max_examples=20, deadline=None)
    @given(st.lists(st.tuples(st.floats(0.01, 2.0), st.floats(-3.0, 3.0)), min_size=2, max_size=12))
    def test_accelerations_are_continuous_at_inner_points(self, knots):
        steps = [step for step, _ in knots[1:]]
        positions = [position for _, position in knots]
        velocities = spline_velocities(steps, positions)
        assert velocities[0] == velocities[-1] == 0.0
        for n in range(1, len(positions) - 1):
            before, after = steps[n - 1], steps[n]
            arriving = (
                6 * (positions[n - 1] - positions[n]) / before**2
                + (2 * velocities[n - 1] + 4 * velocities[n]) / before
            )
            leaving = (
                6 * (positions[n + 1] - positions[n]) / after**2
                - (4 * velocities[n] + 2 * velocities[n + 1]) / after
            )
            assert arriving == pytest.approx(leaving, rel=1e-6, abs=1e-3)

    def test_points_without_times_follow_each_other_at_the_policys_frequency(self):
        message = trajectory(point(0, [1.0]), point(0, [2.0]), point(0, [3.0]))
        upsample(message, 20.0)
        times = [to_nanoseconds(p.time_from_start) / 1e9 for p in message.points]
        assert times == pytest.approx([0.05, 0.1, 0.15])

    @pytest.mark.parametrize(
        "points",
        [
            pytest.param([point(1, [1.0])], id="one point"),
            pytest.param([point(1, []), point(2, [])], id="no joints"),
            pytest.param([point(1, [1.0]), point(2, [1.0, 2.0])], id="uneven lengths"),
            pytest.param([point(2, [1.0]), point(1, [2.0])], id="times go back"),
            pytest.param([point(1, [1.0], [0.5]), point(2, [2.0], [0.0])], id="has velocities"),
        ],
    )
    def test_other_trajectories_are_left_as_they_are(self, points):
        before = [list(p.velocities) for p in points]
        upsample(trajectory(*points), 0.0)
        assert [list(p.velocities) for p in points] == before

    def test_a_chunk_of_positions_on_the_topic_is_followed_smoothly(self):
        arm = Arm(
            positions_upsampling__enable=True, positions_upsampling__policy_frequency=10.0
        ).up()
        arm.send(trajectory(*(point(0, [p, 2.1, 3.1]) for p in (1.1, 1.2, 1.4, 1.5))))
        arm.step(0.2)
        assert arm.state_messages[-1].reference.velocities[0] > 0.5
        arm.step(0.5)
        assert arm.commands == near([1.5, 2.1, 3.1])
        assert arm.rejections() == []

    def test_a_chunk_without_times_is_rejected_without_a_frequency(self):
        arm = Arm(positions_upsampling__enable=True).up()
        arm.send(trajectory(*(point(0, [p, 2.1, 3.1]) for p in (1.1, 1.2))))
        assert "not strictly increasing" in arm.rejections()[0]


class TestCommands:
    def test_an_effort_beside_positions_is_that_of_now_and_not_of_the_next_command(self):
        robot = serial_robot(commands=("position", "effort"), states=("position", "velocity"))
        arm = Arm(
            robot=robot,
            command_interfaces=["position", "effort"],
            state_interfaces=["position", "velocity"],
        ).up()
        start, end = [1.1, 2.1, 3.1], [2.1, 3.1, 4.1]
        arm.send(trajectory(point(0.1, start, effort=[0] * 3), point(1.1, end, effort=[10] * 3)))
        arm.step(0.6)
        now = arm.state_messages[-1].reference
        assert arm.stack.command("joint1/effort") == now.effort[0]
        assert 0.0 < now.effort[0] < 10.0

    def test_the_requested_speed_is_written_to_its_command_interface(self):
        robot = serial_robot(
            extra_control='<gpio name="speed"><command_interface name="factor"/></gpio>'
        )
        arm = Arm(robot=robot, speed_scaling__command_interface="speed/factor").up()
        arm.stack.step()
        assert arm.stack.command("speed/factor") == 1.0
        arm.controller.speed_scaling = 0.4
        arm.stack.step()
        assert arm.stack.command("speed/factor") == 0.4
        assert arm.controller.speed_scaling == 0.4
