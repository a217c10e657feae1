"""The joint trajectory controller: three joints at (1.1, 2.1, 3.1), 100 Hz."""

import math
from typing import Any

import pytest

from teleopctl.control.controllers.joint_trajectory.settings import read_gains
from teleopctl.control.lifecycle import State
from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import Parameter
from teleopctl.testing import ControlStack, serial_robot
from tests.control.controllers.joint_trajectory.arm import (
    JOINTS,
    Arm,
    Time,
    near,
    point,
    trajectory,
)

DYNAMICS = '<param name="calculate_dynamics">true</param>'


@pytest.fixture
def arm():
    return Arm().up()


class TestConfiguration:
    @pytest.mark.parametrize(
        "interfaces",
        [
            [],
            ["strange"],
            ["effort", "velocity"],
            ["effort", "velocity", "acceleration"],
            ["velocity", "acceleration"],
            ["acceleration"],
        ],
    )
    def test_command_interfaces_that_make_no_sense_are_refused(self, interfaces):
        assert not Arm(command_interfaces=interfaces).configure()

    @pytest.mark.parametrize(
        "interfaces",
        [[], ["strange"], ["effort"], ["velocity"], ["velocity", "acceleration"], ["acceleration"]],
    )
    def test_state_interfaces_that_make_no_sense_are_refused(self, interfaces):
        assert not Arm(state_interfaces=interfaces).configure()

    @pytest.mark.parametrize("commands", [["velocity"], ["effort"], ["position", "effort"]])
    def test_velocity_is_needed_for_commands_by_velocity_or_effort(self, commands):
        arm = Arm(command_interfaces=commands)
        assert arm.controller.lifecycle_state is State.UNCONFIGURED
        assert not arm.configure()

    def test_a_joint_that_is_named_twice_is_refused(self):
        arm = Arm(joints=["joint1", "joint2", "joint1"])
        assert not arm.configure()
        assert "names 'joint1' twice: ['joint1', 'joint2', 'joint1']" in arm.rejections()[0]

    def test_interfaces_are_claimed_joint_by_joint(self):
        states = ["position", "velocity"]
        robot = serial_robot(commands=("position", "velocity"), states=states)
        arm = Arm(robot=robot, command_interfaces=states, state_interfaces=states)
        assert arm.configure()
        spec = arm.stack.manager.controllers["arm"]
        expected = tuple(f"{joint}/{name}" for joint in JOINTS for name in states)
        assert spec.required_command_interfaces == expected
        assert spec.required_state_interfaces == expected

    @pytest.mark.parametrize("command_joints", [["a", "b", "c", "d"], ["joint1", "strange"]])
    def test_command_joints_must_fit_the_joints(self, command_joints):
        assert not Arm(command_joints=command_joints).configure()

    def test_other_command_joints_are_claimed(self):
        arm = Arm(command_joints=["joint2", "joint1"])
        assert arm.configure()
        assert arm.stack.manager.controllers["arm"].required_command_interfaces == (
            "joint2/position",
            "joint1/position",
        )

    @pytest.mark.parametrize(("timeout", "kept"), [(3.0, 3.0), (1.0, 0.0)])
    def test_a_command_timeout_shorter_than_the_goal_time_is_dropped(self, timeout, kept):
        arm = Arm(cmd_timeout=timeout, constraints__goal_time=2.0)
        assert arm.configure()
        assert arm.controller._settings.cmd_timeout == kept

    def test_the_old_name_of_open_loop_is_known_and_warned_of(self):
        arm = Arm(open_loop_control=True)
        assert arm.configure()
        assert arm.controller._settings.open_loop
        assert any("deprecated" in text for text in arm.node.log.texts("warning"))

    def test_a_deceleration_without_velocities_has_no_effect(self):
        arm = Arm(constraints__decelerate_on_cancel=True).up()
        (slowing,) = arm.node.log.texts("warning")
        assert slowing.startswith("'constraints.decelerate_on_cancel' has no effect: it needs")

    @pytest.mark.parametrize(
        ("given", "low", "high"),
        [
            ({}, -math.inf, math.inf),
            ({"i_clamp": 2.0}, -2.0, 2.0),
            ({"i_clamp": 2.0, "i_clamp_max": 1.0}, -2.0, 1.0),
        ],
    )
    def test_the_integral_has_one_clamp_or_two(self, given, low, high):
        values: dict[str, Any] = {f"gains.joint1.{name}": value for name, value in given.items()}
        read: Any = values.get
        gains = read_gains("joint1", read)
        assert (gains.i_clamp_min, gains.i_clamp_max) == (low, high)

    def test_tolerances_changed_while_running_count_from_the_next_update(self, arm):
        arm.node.set_parameters([Parameter("constraints.joint1.trajectory", value=0.25)])
        arm.step(0.01)
        assert arm.controller._tolerances.path[0].position == 0.25


class TestHold:
    def test_activation_holds_what_is_measured(self, arm):
        arm.step(0.05)
        assert arm.commands == near([1.1, 2.1, 3.1])

    def test_activation_continues_from_the_last_command(self):
        arm = Arm()
        assert arm.configure()
        for joint, value in zip(JOINTS, (3.1, 4.1, 5.1), strict=True):
            arm.stack.resources.command_interfaces[f"{joint}/position"].value = value
        arm.activate().step(0.05)
        assert arm.commands == near([3.1, 4.1, 5.1])

    def test_activation_can_be_told_to_hold_what_is_measured(self):
        arm = Arm(set_last_command_interface_value_as_state_on_activation=False)
        assert arm.configure()
        for joint in JOINTS:
            arm.stack.resources.command_interfaces[f"{joint}/position"].value = 9.0
        arm.activate().step(0.05)
        assert arm.commands == near([1.1, 2.1, 3.1])

    def test_an_unknown_position_is_held_once_it_is_known(self):
        arm = Arm()
        assert arm.configure()
        arm.stack.resources.state_interfaces["joint1/position"].value = math.nan
        arm.activate().step(0.05)
        assert all(map(math.isnan, arm.commands))
        arm.stack.resources.state_interfaces["joint1/position"].value = 0.7
        arm.step(0.05)
        assert arm.commands == near([0.7, 2.1, 3.1])


class TestMotion:
    def test_all_joints_reach_the_points_in_time(self, arm):
        arm.send(trajectory(point(0.25, [1, 2, 3]), point(0.5, [2, 3, 4])))
        arm.step(0.25)
        # Commands lead by one period, so this one is the point itself.
        assert arm.commands == near([1, 2, 3])
        arm.step(0.26)
        assert arm.commands == near([2, 3, 4])
        arm.step(1.0)
        assert arm.commands == near([2, 3, 4])

    def test_half_way_between_points(self, arm):
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.5)
        assert arm.commands == near([1.6, 2.6, 3.6])

    def test_joint_order_does_not_matter(self, arm):
        arm.send(trajectory(point(0.1, [2, 3, 1]), joints=["joint2", "joint3", "joint1"]))
        arm.step(0.2)
        assert arm.commands == near([1, 2, 3])

    def test_a_partial_goal_moves_only_its_joints(self):
        arm = Arm(allow_partial_joints_goal=True).up()
        arm.step(0.05)
        arm.send(trajectory(point(0.1, [1.0, 2.0]), joints=["joint2", "joint1"]))
        arm.step(0.2)
        assert arm.commands == near([2.0, 1.0, 3.1])
        arm.send(trajectory(point(0.1, [1.5]), joints=["joint1"]))
        arm.step(0.2)
        assert arm.commands == near([1.5, 1.0, 3.1])

    def test_a_partial_goal_is_refused_by_default(self, arm):
        arm.step(0.05)
        arm.send(trajectory(point(0.1, [1.0, 2.0]), joints=["joint2", "joint1"]))
        arm.step(0.2)
        assert arm.commands == near([1.1, 2.1, 3.1])
        assert arm.rejections() == [
            "Joints on incoming trajectory don't match the controller joints."
        ]

    def test_a_trajectory_of_the_past_leaves_the_running_one_alone(self, arm):
        arm.send(trajectory(point(0.5, [2, 3, 4])))
        arm.step(0.1)
        late = arm.stack.time_ns - 2 * 10**9
        arm.send(trajectory(point(1.0, [9, 9, 9]), stamp_ns=late))
        arm.step(0.5)
        assert arm.commands == near([2, 3, 4])

    def test_a_trajectory_that_has_begun_heads_for_its_next_point(self, arm):
        begun = arm.stack.time_ns - 10**9
        points = (point(0.5, [9, 9, 9]), point(1.5, [2, 3, 4]))
        arm.send(trajectory(*points, stamp_ns=begun))
        arm.step(0.6)
        assert arm.commands == near([2, 3, 4])

    def test_a_trajectory_of_the_future_begins_at_once_and_slowly(self, arm):
        future = arm.stack.time_ns + 10**9
        arm.send(trajectory(point(1.0, [3.1, 4.1, 5.1]), stamp_ns=future))
        arm.step(1.0)
        assert arm.commands == near([2.1, 3.1, 4.1], 0.02)
        arm.step(1.0)
        assert arm.commands == near([3.1, 4.1, 5.1])

    def test_a_stamp_of_another_clock_is_told(self, arm):
        wall_clock = arm.stack.time_ns + 10**18
        arm.send(trajectory(point(1.0, [3.1, 4.1, 5.1]), stamp_ns=wall_clock))
        assert "starts in 1000000000 s" in arm.node.log.texts("warning")[-1]

    def test_velocities_alone_are_integrated_where_allowed(self):
        arm = Arm(allow_integration_in_goal_trajectories=True).up()
        arm.send(trajectory(point(1.0, (), [1, 1, 1]), point(2.0, (), [0, 0, 0])))
        arm.step(2.1)
        assert arm.commands == near([2.1, 3.1, 4.1])

    def test_speed_scaling_slows_the_trajectory(self, arm):
        factor = get_message("control_msgs/msg/SpeedScalingFactor")
        arm.node.receive("~/speed_scaling_input", factor(factor=0.5))
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(1.0)
        assert arm.commands == near([1.6, 2.6, 3.6], 0.01)
        arm.node.receive("~/speed_scaling_input", factor(factor=-0.12))
        arm.step(0.01)
        assert arm.state_messages[-1].speed_scaling_factor == 0.5
        arm.node.receive("~/speed_scaling_input", factor(factor=0.0))
        arm.step(0.5)
        assert arm.commands == near([1.6, 2.6, 3.6], 0.02)

    def test_a_pause_by_speed_scaling_takes_no_command_back(self, arm):
        factor = get_message("control_msgs/msg/SpeedScalingFactor")
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.5)
        for pace in (0.0, 0.3, 0.0, 0.9, 1.0):
            arm.node.receive("~/speed_scaling_input", factor(factor=pace))
            for _ in range(5):
                before = arm.commands
                arm.step(0.01)
                assert arm.commands >= before
        arm.step(1.0)
        assert arm.commands == near([2.1, 3.1, 4.1])

    def test_a_measurement_that_is_missing_for_a_moment_leaves_the_trajectory_alone(self, arm):
        states = arm.stack.resources.state_interfaces
        arm.freeze()
        states["joint1/position"].value = math.nan
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.08)
        states["joint1/position"].value = 1.1
        arm.step(0.42)
        assert arm.commands == near([1.6, 2.6, 3.6], 0.02)
        arm.step(1.0)
        assert arm.commands == near([2.1, 3.1, 4.1])

    def test_after_a_clock_that_went_back_the_arm_holds(self, arm):
        arm.send(trajectory(point(10.0, [2, 3, 4])))
        arm.step(1.0)
        before = arm.commands
        arm.stack.time_ns = ControlStack.start_ns - 10**9
        arm.step(0.5)
        assert arm.commands == near(before, 0.02)


class TestOpenAndClosedLoop:
    def test_closed_loop_starts_where_the_arm_is_measured(self):
        arm = Arm().up()
        arm.step(0.05)
        arm.freeze(joint1_position=1.4)
        arm.send(trajectory(point(1.0, [1.4, 2.1, 3.1])))
        arm.step(0.01)
        assert arm.commands[0] == near(1.4)

    def test_open_loop_continues_from_the_command_of_before_the_activation(self):
        arm = Arm(open_loop_control=True).up()
        arm.send(trajectory(point(0.1, [2.0, 3.0, 4.0])))
        arm.step(0.2)
        arm.deactivate()
        arm.freeze(joint1_position=1.0)
        arm.activate()
        arm.send(trajectory(point(1.0, [3.0, 3.0, 4.0])))
        arm.step(0.01)
        assert arm.commands[0] == pytest.approx(2.01, abs=2e-3)

    def test_open_loop_continues_from_the_last_command(self):
        arm = Arm(interpolate_from_desired_state=True).up()
        arm.step(0.05)
        arm.freeze(joint1_position=1.4)
        arm.send(trajectory(point(1.0, [1.1, 2.1, 3.1])))
        arm.step(0.01)
        assert arm.commands[0] == near(1.1)


class TestRejection:
    @pytest.mark.parametrize(
        ("message", "reason"),
        [
            (trajectory(joints=[]), "Joints on incoming trajectory don't match"),
            (trajectory(), "Empty trajectory received."),
            (
                trajectory(point(1, [1, 2, 3]), joints=["joint1", "joint2", "other"]),
                "Incoming joint other doesn't match the controller's joints.",
            ),
            (
                trajectory(point(1, [1, 2, 3], [0, 1, 0])),
                "Velocity of last trajectory point of joint joint2 is not zero: 1.000000",
            ),
            (
                trajectory(point(0.25, [1, 2, 3]), stamp_ns=1),
                "Received trajectory with non-zero start time (0.000000) that ends in the past",
            ),
            (
                trajectory(point(1, [1, 2, 3]), point(1, [1, 2, 3])),
                "Time between points 0 and 1 is not strictly increasing, "
                "it is 1.000000 and 1.000000 respectively",
            ),
            (
                trajectory(point(1, [1, 2])),
                "Mismatch between joint_names size (3) and positions (2) at point #0.",
            ),
            (
                trajectory(point(1, [1, 2, 3], [0, 0])),
                "Mismatch between joint_names size (3) and velocities (2) at point #0.",
            ),
            (trajectory(point(1, [1, 2, math.nan])), "not finite"),
            (trajectory(point(1, [1, 2, 3], effort=[1, 1, 1])), "no effort command interface"),
            (trajectory(point(1, (), [0, 0, 0])), "positions (0)"),
        ],
    )
    def test_invalid_trajectories_are_named_and_ignored(self, arm, message, reason):
        arm.send(message)
        arm.step(0.1)
        assert arm.commands == near([1.1, 2.1, 3.1])
        (said,) = arm.rejections()
        assert reason in said

    def test_a_stamp_of_now_is_accepted(self, arm):
        arm.send(trajectory(point(10, [1, 2, 3]), stamp_ns=arm.stack.time_ns))
        assert not arm.rejections()

    def test_with_integration_something_must_still_be_given(self):
        arm = Arm(allow_integration_in_goal_trajectories=True).up()
        arm.send(trajectory(point(1, (), (), [0, 0, 0])))
        assert not arm.rejections()
        arm.send(trajectory(point(1)))
        arm.send(trajectory(point(1, (), [0, 0])))
        assert len(arm.rejections()) == 2

    def test_a_final_velocity_is_accepted_where_allowed(self):
        arm = Arm(allow_nonzero_velocity_at_trajectory_end=True).up()
        arm.send(trajectory(point(1, [1, 2, 3], [1, 1, 1])))
        assert not arm.rejections()

    def test_an_inactive_controller_says_that_it_ignores(self, arm):
        arm.deactivate()
        arm.send(trajectory(point(1, [1, 2, 3])))
        assert any("not active" in text for text in arm.node.log.texts("warning"))


class TestTolerances:
    def test_leaving_the_path_holds_the_measured_position(self):
        arm = Arm(constraints__joint1__trajectory=0.0001).up()
        arm.step(0.05)
        arm.freeze()
        arm.send(trajectory(point(1.0, [2, 3, 4])))
        arm.step(0.5)
        assert arm.commands == near([1.1, 2.1, 3.1], 0.02)
        assert any("State tolerances failed for joint joint1" in t for t in arm.rejections())

    def test_a_late_goal_holds_the_measured_position(self):
        arm = Arm(constraints__joint1__goal=0.1, constraints__goal_time=1e-6).up()
        arm.step(0.05)
        arm.freeze()
        arm.send(trajectory(point(0.2, [2, 3, 4])))
        arm.step(0.5)
        assert arm.commands == near([1.1, 2.1, 3.1])
        count = len(arm.rejections())
        arm.freeze(joint1_position=5.0)
        arm.step(0.2)
        assert len(arm.rejections()) == count

    def test_the_last_point_is_kept_without_a_timeout(self, arm):
        arm.send(trajectory(point(0.1, [2, 3, 4])))
        arm.step(5.0)
        assert arm.commands == near([2, 3, 4])

    def test_a_timeout_leads_to_a_hold(self):
        arm = Arm(cmd_timeout=0.1).up()
        arm.send(trajectory(point(0.1, [2, 3, 4])))
        arm.step(0.5)
        assert "Aborted due to command timeout" in arm.node.log.texts("warning")
        assert len(arm.controller._trajectory.points) == 1


class TestState:
    def test_state_message(self, arm):
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.5)
        message = arm.state_messages[-1]
        assert list(message.joint_names) == JOINTS
        assert list(message.reference.positions) == near([1.59, 2.59, 3.59], 2e-3)
        assert len(message.feedback.positions) == len(message.error.positions) == 3
        assert len(message.feedback.velocities) == len(message.feedback.accelerations) == 0
        assert list(message.output.positions) == near(arm.commands)
        assert len(message.output.velocities) == 0
        seconds = message.reference.time_from_start.nanosec / 1e9
        assert seconds == near(0.49)
        stamp = message.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == arm.stack.time_ns

    def test_a_revolute_error_is_not_wrapped(self, arm):
        arm.freeze()
        arm.send(trajectory(point(0.02, [1.1, 2.1, 9.1])))
        arm.step(0.1)
        assert arm.state_messages[-1].error.positions[2] == near(6.0)

    def test_a_continuous_error_is_the_shortest_angle(self):
        arm = Arm(robot=serial_robot(kind="continuous")).up()
        arm.freeze()
        arm.send(trajectory(point(0.02, [1.1, 2.1, 6.6])))
        arm.step(0.1)
        assert arm.state_messages[-1].error.positions[2] == near(6.6 - 3.1 - 2 * math.pi)

    def test_the_trajectory_can_be_queried(self, arm):
        query = arm.node.endpoints["~/query_state"].callback
        service = get_service("control_msgs/srv/QueryTrajectoryState")

        def ask(time_ns):
            sec, nanosec = divmod(time_ns, 10**9)
            request = service.Request(time=Time(sec=sec, nanosec=nanosec))
            return query(request, service.Response())

        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.01)
        start = arm.stack.time_ns
        answer = ask(start + 500_000_000)
        assert answer.success
        assert list(answer.position) == near([1.6, 2.6, 3.6])
        assert not ask(start + 2 * 10**9).success
        assert not ask(start - 10**9).success


class TestOtherInterfaces:
    STATES = ("position", "velocity")

    def test_velocity_commands_come_from_the_pid_and_the_feed_forward(self):
        robot = serial_robot(commands=("velocity",), states=self.STATES)
        gains = {f"gains__{joint}__p": 1.0 for joint in JOINTS}
        gains["gains__joint1__ff_velocity_scale"] = 1.0
        arm = Arm(
            robot=robot,
            command_interfaces=["velocity"],
            state_interfaces=list(self.STATES),
            **gains,
        ).up()
        arm.freeze()
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.5)
        error = arm.state_messages[-1].error.positions
        first, second, _ = arm.stack.commands("velocity")
        assert second == near(error[1])
        assert first == near(error[0] + 1.0)

    @pytest.mark.parametrize(
        ("gain", "told"),
        [
            ({"antiwindup_strategy": "magic"}, "Unknown antiwindup strategy : 'magic'"),
            ({"u_clamp_max": -1.0, "u_clamp_min": 1.0}, "u_min (1) must be less than u_max (-1)"),
        ],
    )
    def test_gains_that_cannot_be_are_refused_where_they_are_used(self, gain, told):
        gains = {f"gains__joint2__{name}": value for name, value in gain.items()}
        robot = serial_robot(commands=("position", "velocity"), states=self.STATES)
        interfaces = {"command_interfaces": ["velocity"], "state_interfaces": list(self.STATES)}
        arm = Arm(robot=robot, **interfaces, **gains)
        assert not arm.configure()
        (error,) = arm.node.log.texts("error")
        assert error.startswith("Gains of 'joint2': ")
        assert told in error
        assert Arm(robot=robot, **gains).configure()

    def test_gains_that_cannot_be_are_left_out_while_it_runs(self):
        robot = serial_robot(commands=("velocity",), states=self.STATES)
        interfaces = {"command_interfaces": ["velocity"], "state_interfaces": list(self.STATES)}
        arm = Arm(robot=robot, **interfaces, gains__joint1__p=1.0).up()
        arm.node.set_parameters([Parameter("gains.joint1.i_clamp_max", value=-1.0)])
        arm.step(0.01)
        assert "Skipping new gains." in arm.node.log.texts("error")[-1]
        arm.step(0.01)
        assert len(arm.node.log.texts("error")) == 1

    def test_it_may_command_a_controller_of_each_joint(self):
        robot = serial_robot(commands=("velocity",), states=self.STATES, parameters=DYNAMICS)
        chained = [f"pid/{joint}" for joint in JOINTS]
        arm = Arm(robot=robot, command_joints=chained)
        options = {
            "dof_names": JOINTS,
            "command_interface": "velocity",
            "reference_and_state_interfaces": ["position"],
        } | {f"gains.{joint}.p": 20.0 for joint in JOINTS}
        arm.stack.load_controller("pid", "pid_controller/PidController", options)
        arm.stack.activate("pid")
        arm.up()
        arm.send(trajectory(point(1.0, [2.1, 2.6, 2.8])))
        arm.step(2.0)
        assert [arm.stack.state(f"{joint}/position") for joint in JOINTS] == near([2.1, 2.6, 2.8])

    def test_one_missing_measurement_does_not_spoil_the_pid(self):
        robot = serial_robot(commands=("velocity",), states=self.STATES)
        gains = {f"gains__{joint}__{gain}": 1.0 for joint in JOINTS for gain in "pid"}
        interfaces = {"command_interfaces": ["velocity"], "state_interfaces": list(self.STATES)}
        arm = Arm(robot=robot, **interfaces, **gains).up()
        arm.freeze()
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.2)
        states = arm.stack.resources.state_interfaces
        for name in ("joint1/position", "joint1/velocity"):
            good, states[name].value = states[name].value, math.nan
            before = arm.stack.commands("velocity")
            arm.step(0.01)
            assert arm.stack.commands("velocity") == near(before, 0.05)
            states[name].value = good
        arm.step(0.2)
        assert all(map(math.isfinite, arm.stack.commands("velocity")))

    def test_deactivation_stops_velocities_and_keeps_positions(self):
        robot = serial_robot(commands=self.STATES, states=self.STATES)
        arm = Arm(
            robot=robot, command_interfaces=list(self.STATES), state_interfaces=list(self.STATES)
        ).up()
        arm.send(trajectory(point(1.0, [2.1, 3.1, 4.1])))
        arm.step(0.5)
        before = arm.stack.commands("position")
        assert arm.stack.commands("velocity") == near([1.0, 1.0, 1.0])
        arm.deactivate()
        assert arm.stack.commands("position") == before
        assert arm.stack.commands("velocity") == [0.0, 0.0, 0.0]
        assert arm.stack.manager.cleanup_controller("arm")
        arm.up()


class TestPositionCommands:
    """The extension ~/commands."""

    def limited(self):
        limits = 'lower="-4" upper="4" effort="10" velocity="2"'
        return Arm(robot=serial_robot(initial=(0.0,), limits=limits)).up()

    def test_positions_are_reached_and_the_velocity_limit_is_kept(self):
        arm = self.limited()
        arm.step(0.05)
        arm.command(1.0, 0.0, -1.0)
        previous = arm.commands
        while arm.commands != near([1.0, 0.0, -1.0], 1e-9):
            arm.step(0.01)
            speeds = [
                abs(now - then) / 0.01 for now, then in zip(arm.commands, previous, strict=True)
            ]
            assert max(speeds) <= 2.0 + 1e-6
            previous = arm.commands
        assert arm.stack.time_ns < ControlStack.start_ns + 10**9

    def test_a_position_outside_the_limits_is_clamped_and_reported_once(self):
        arm = self.limited()
        arm.command(9.0, 0.0, 0.0)
        arm.step(5.0)
        assert arm.commands == near([4.0, 0.0, 0.0])
        warnings = [*arm.node.log.texts("warning"), *arm.stack.log.texts("warning")]
        (report,) = [text for text in warnings if "limits" in text]
        assert "'joint1'" in report
        assert "position 9 is clamped to 4" in report
        assert "[-4, 4]" in report

    @pytest.mark.parametrize("positions", [(1.0, 2.0), (1.0, math.nan, 0.0), ()])
    def test_what_does_not_fit_is_named_and_ignored(self, positions):
        arm = self.limited()
        arm.command(*positions)
        arm.step(0.2)
        assert arm.commands == near([0.0, 0.0, 0.0])
        assert len(arm.rejections()) == 1
        assert arm.controller.lifecycle_state is State.ACTIVE


def test_commands_outside_the_limits_are_clamped_and_reported_once():
    arm = Arm(
        robot=serial_robot(initial=(0.0,), limits='lower="-1" upper="1" effort="1" velocity="99"'),
        enforce_limits=True,
    )
    arm.up()
    arm.send(trajectory(point(0.5, [3.0, 0.0, 0.0])))
    arm.step(1.0)
    assert arm.commands == near([1.0, 0.0, 0.0])
    reports = [text for text in arm.stack.log.texts("warning") if "outside its limits" in text]
    assert len(reports) == 1


class TestStartElsewhere:
    SLOW = serial_robot(limits='lower="-100" upper="100" effort="1000" velocity="2"')

    def test_a_start_that_the_joint_cannot_reach_in_time_is_reported_once_and_commanded(self):
        arm = Arm(robot=self.SLOW).up()
        arm.send(trajectory(point(0.0, [1.1, 2.6, 3.1]), point(1.0, [1.1, 2.1, 3.1])))
        arm.step(0.02)
        assert arm.node.log.texts("warning") == [
            "The trajectory starts elsewhere: joint2 is at 2.1, the first point at 2.6 comes at "
            "once, and the way takes 0.25 s at the velocity limit of 2. The controller commands it "
            "all the same. 'teleopctl topic echo --once /arm/controller_state' prints where the "
            "joints are."
        ]
        assert arm.commands[1] == pytest.approx(2.6, abs=0.05)
        arm.send(trajectory(point(0.1, [-1.1, 2.6, 3.1])))
        arm.step(0.1)
        assert len(arm.node.log.texts("warning")) == 1

    @pytest.mark.parametrize(
        "first",
        [
            point(0.0, [1.1, 2.105, 3.1]),  # within MoveIt's allowed_start_tolerance
            point(1.0, [1.1, 4.0, 3.1]),
            point(0.0, [], [0.0, 0.0, 0.0]),
        ],
    )
    def test_one_that_it_can_reach_is_not(self, first):
        arm = Arm(robot=self.SLOW, allow_integration_in_goal_trajectories=True).up()
        arm.send(trajectory(first))
        arm.step(0.05)
        assert arm.node.log.texts("warning") == []
