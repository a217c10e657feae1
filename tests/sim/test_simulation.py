"""Physics: drives, modes, time, repeatability."""

import math

import numpy as np
import pytest

from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.packages import package_share
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.sim.simulation import Simulation
from tests.robot.independent import link_frames
from tests.sim.robots import INERTIAL, box, control, joint, link, model, pendulum

PERIOD_NS = 100_000_000


@pytest.fixture(scope="module")
def arm_description() -> RobotDescription:
    file = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
    return RobotDescription.from_urdf(expand_xacro(str(file), {}))


@pytest.fixture(scope="module")
def arm(arm_description: RobotDescription) -> RobotModel:
    return build_model(arm_description)


def simulate(robot: RobotModel, **options: int) -> Simulation:
    return Simulation(robot, control_period_ns=PERIOD_NS, **options)


def run(simulation: Simulation, periods: int, names=(), **command) -> None:
    for _ in range(periods):
        if names:
            simulation.apply(names, **command)
        simulation.step(simulation.steps_to_tick)
    simulation.read()


def test_the_model_of_the_arm_needs_no_repair(arm: RobotModel) -> None:
    assert arm.warnings == () and arm.excluded == ()


def test_the_arm_holds_its_pose_quietly(arm: RobotModel) -> None:
    simulation = simulate(arm)
    fastest = 0.0
    for _ in range(200):
        simulation.step(10)
        simulation.read()
        fastest = max(fastest, float(np.abs(simulation.velocities).max()))

    assert np.abs(simulation.positions).max() < 1e-9
    assert fastest < 1e-6
    assert simulation.efforts[1] == pytest.approx(0.965, abs=0.05), "the drives carry the weight"


@pytest.mark.parametrize(
    "target",
    [(0.5, 0.6, -0.7, -1.0), (-1.0, 1.2, 1.2, -0.5), (1.5, -0.7, -0.2, 0.0), (0.3, 0.1, 1.5, -1.5)],
)
def test_the_claw_comes_to_rest_where_forward_kinematics_puts_it(
    arm: RobotModel, arm_description: RobotDescription, target: tuple[float, ...]
) -> None:
    simulation = simulate(arm)
    run(simulation, 15, ["joint_1", "joint_2", "joint_3", "joint_4"], position=target)

    joints = dict(zip(simulation.joint_names, [*target, -target[3]], strict=True))
    expected = link_frames(arm_description.urdf, joints)["claw_support"][:3, 3]
    assert simulation.link_pose("claw_support").position == pytest.approx(expected, abs=1e-5)
    assert simulation.positions == pytest.approx(list(joints.values()), abs=1e-6)
    assert np.abs(simulation.velocities).max() < 1e-5


def test_the_fingers_move_as_mirror_images(arm: RobotModel) -> None:
    simulation = simulate(arm)
    simulation.apply(["joint_4"], position=[-1.0])
    worst = 0.0
    for _ in range(40):
        simulation.step(10)
        simulation.read()
        worst = max(worst, abs(simulation.positions[3] + simulation.positions[4]))

    assert simulation.positions[3] == pytest.approx(-1.0, abs=1e-3)
    assert worst < 1e-3


def test_the_same_commands_give_the_same_bits(arm: RobotModel) -> None:
    def record(simulation: Simulation) -> bytes:
        states = []
        for tick in range(30):
            angle = math.sin(tick / 5)
            simulation.apply(["joint_2", "joint_1"], position=[angle, 1.5 * angle])
            # However the period is cut into blocks.
            for block in ((100,), (30, 70), (1, 98, 1))[tick % 3]:
                simulation.step(block)
            simulation.read()
            states.append(simulation.positions.tobytes() + simulation.efforts.tobytes())
        return b"".join(states)

    first, second = simulate(arm), simulate(arm)
    expected = record(first)
    assert record(second) == expected
    first.reset()
    assert first.time_ns == 0
    assert record(first) == expected


def test_a_set_point_never_moves_faster_than_the_joint_may() -> None:
    simulation = simulate(pendulum(limit='lower="-2" upper="2" effort="200" velocity="0.5"'))
    simulation.apply(["hinge"], position=[1.0])
    fastest = 0.0
    for _ in range(300):
        simulation.step(10)
        simulation.read()
        fastest = max(fastest, float(simulation.velocities[0]))

    assert fastest == pytest.approx(0.5, abs=1e-3)
    assert simulation.positions[0] == pytest.approx(1.0, abs=1e-6)


def test_a_position_beyond_the_limits_ends_at_the_limit() -> None:
    simulation = simulate(pendulum())
    run(simulation, 30, ["hinge"], position=[5.0])

    assert simulation.positions[0] == pytest.approx(2.0, abs=1e-3)


def test_the_effort_limit_holds() -> None:
    weak = 'lower="-2" upper="2" effort="0.5" velocity="3"'
    simulation = simulate(pendulum(limit=weak))
    largest = 0.0
    for _ in range(100):
        simulation.apply(["hinge"], position=[1.0])
        simulation.step(100)
        simulation.read()
        largest = max(largest, abs(simulation.efforts[0]))

    assert largest == pytest.approx(0.5)
    assert simulation.positions[0] != pytest.approx(1.0, abs=0.1), "too weak for its own weight"


def test_a_velocity_command_is_followed_and_its_end_stops_the_joint() -> None:
    simulation = simulate(pendulum("position velocity"))
    run(simulation, 5, ["hinge"], velocity=[0.7])
    assert simulation.velocities[0] == pytest.approx(0.7, abs=1e-3)

    run(simulation, 5, ["hinge"], velocity=[math.nan])
    assert simulation.velocities[0] == pytest.approx(0.0, abs=1e-6)
    held = float(simulation.positions[0])
    run(simulation, 10)
    assert simulation.positions[0] == pytest.approx(held, abs=1e-6)


@pytest.fixture(scope="module")
def arm_by_speed(arm_description: RobotDescription) -> RobotModel:
    both = '<command_interface name="velocity"/><command_interface name="position">'
    urdf = arm_description.urdf.replace('<command_interface name="position">', both)
    return build_model(RobotDescription.from_urdf(urdf))


@pytest.mark.parametrize("rate", [10, 100, 1000])
def test_a_velocity_command_is_followed_within_one_percent_after_50_ms(
    arm_by_speed: RobotModel, rate: int
) -> None:
    simulation = Simulation(arm_by_speed, control_period_ns=round(1e9 / rate))
    wanted = [1.0, 1.0, 2.0]
    reached = []
    for millisecond in range(350):
        if simulation.at_tick:
            simulation.apply(["joint_1", "joint_2", "joint_3"], velocity=wanted)
        simulation.step(1)
        if millisecond >= 50:
            simulation.read()
            reached.append(simulation.velocities[:3] / wanted)

    assert np.abs(np.array(reached) - 1.0).max() < 0.01


def test_a_joint_that_reaches_its_limit_at_a_commanded_speed_stops_there() -> None:
    for rate in (10, 100, 1000):
        simulation = Simulation(pendulum("velocity"), control_period_ns=round(1e9 / rate))
        furthest = 0.0
        for _ in range(3000):
            if simulation.at_tick:
                simulation.apply(["hinge"], velocity=[1.0])
            simulation.step(1)
            simulation.read()
            furthest = max(furthest, float(simulation.positions[0]))

        assert 2.0 - 1e-3 < simulation.positions[0] < 2.0 + 1e-3
        assert furthest < 2.01


@pytest.mark.parametrize("rate", [50, 100, 1000])
@pytest.mark.parametrize(("name", "middle"), [("joint_1", 0.0), ("joint_3", 0.2)])
def test_a_sine_of_1_hz_and_1_rad_is_followed_within_5_mrad(
    arm: RobotModel, rate: int, name: str, middle: float
) -> None:
    simulation = Simulation(arm, control_period_ns=round(1e9 / rate))
    joint = simulation.joint_names.index(name)
    worst = 0.0
    for millisecond in range(2000):
        if simulation.at_tick:
            # The command of a period is where the joint is to be at its end.
            end = millisecond * 1e-3 + 1.0 / rate
            simulation.apply([name], position=[middle + math.sin(2 * math.pi * end)])
        simulation.step(1)
        simulation.read()
        wanted = middle + math.sin(2 * math.pi * 1e-3 * (millisecond + 1))
        if millisecond > 300:  # it starts from rest, at a speed of 6 rad/s
            worst = max(worst, abs(simulation.positions[joint] - wanted))

    assert worst < 0.005


def test_a_jump_within_the_effort_limit_comes_to_rest_without_overshoot() -> None:
    for rate in (10, 100):
        simulation = Simulation(pendulum(), control_period_ns=round(1e9 / rate))
        simulation.apply(["hinge"], position=[1.0])
        furthest = 0.0
        for _ in range(1000):
            simulation.step(1)
            simulation.read()
            furthest = max(furthest, float(simulation.positions[0]))

        assert furthest == pytest.approx(1.0, abs=1e-4)


def test_a_joint_held_back_does_not_wind_up_its_drive() -> None:
    wall = link("wall", box("collision", "1 0.2 1")) + joint(
        "stand", "base", "wall", kind="fixed", xyz="0 -0.5 1"
    )
    robot = model(
        link("base", ""),
        link("rod", box("collision", "0.1 0.1 0.8", "0 0 0.5") + INERTIAL),
        joint("hinge", "base", "rod"),
        control(hinge="velocity"),
        wall,
    )
    simulation = simulate(robot)
    run(simulation, 50, ["hinge"], velocity=[1.0])
    stuck = float(simulation.positions[0])
    assert stuck < 0.6

    run(simulation, 5, ["hinge"], velocity=[-1.0])

    assert simulation.positions[0] < stuck - 0.2, "it comes free at once"


def test_an_effort_command_leaves_the_joint_to_gravity() -> None:
    simulation = simulate(pendulum("position effort"))
    run(simulation, 5, ["hinge"], position=[0.5])

    run(simulation, 3, ["hinge"], effort=[0.0])

    assert simulation.positions[0] > 0.6, "it falls"
    assert simulation.efforts[0] == 0.0
    run(simulation, 1, ["hinge"], effort=[3.0])
    assert simulation.efforts[0] == pytest.approx(3.0)


def test_a_drive_that_takes_over_a_falling_joint_catches_it() -> None:
    simulation = simulate(pendulum("position effort"))
    run(simulation, 4, ["hinge"], effort=[0.2])

    simulation.hold()
    run(simulation, 10)
    caught = float(simulation.positions[0])
    run(simulation, 10)

    assert simulation.positions[0] == pytest.approx(caught, abs=1e-6)
    assert 0.0 < caught < 1.9


def test_a_joint_that_nothing_drives_swings_freely() -> None:
    robot = model(
        link("base", ""), link("arm"), link("tail"),
        joint("shoulder", "base", "arm"), joint("swing", "arm", "tail", axis="1 0 0"),
        control(shoulder="position"),
    )  # fmt: skip
    simulation = simulate(robot)
    run(simulation, 20, ["shoulder"], position=[0.3])

    assert abs(simulation.positions[1]) > 0.5
    # The drive does not know of that load, so it gives way a little, as a stiff spring does.
    assert simulation.positions[0] == pytest.approx(0.3, abs=0.05)


def test_a_drive_is_strong_enough_for_the_joints_that_follow_it() -> None:
    follow = '<mimic joint="lead" multiplier="5"/>'
    wide = 'lower="-9" upper="9" effort="0" velocity="0"'
    robot = model(
        link("base", ""), link("a"), link("b"),
        joint("lead", "base", "a", limit=wide),
        joint("follow", "base", "b", limit=wide, content=follow),
        control(lead="position"),
    )  # fmt: skip
    simulation = simulate(robot)
    run(simulation, 2, ["lead"], position=[0.4])

    # 0.1 s after the set-point has arrived, ten time constants of a drive at 100 rad/s.
    assert simulation.positions == pytest.approx([0.4, 2.0], abs=1e-2)


def test_initial_positions_are_those_of_ros2_control() -> None:
    tag = """<ros2_control name="h" type="system"><hardware><plugin>x/Y</plugin></hardware>
      <joint name="hinge"><command_interface name="position"/>
      <state_interface name="position"><param name="initial_value">0.4</param></state_interface>
      </joint></ros2_control>"""
    robot = model(link("base", ""), link("rod"), joint("hinge", "base", "rod"), tag)
    simulation = simulate(robot)

    assert simulation.positions[0] == pytest.approx(0.4)
    run(simulation, 5)
    assert simulation.positions[0] == pytest.approx(0.4, abs=1e-9)


def test_commands_find_their_joints_in_any_order_and_pass_over_strangers() -> None:
    robot = model(
        link("base", ""), link("a"), link("b"),
        joint("ja", "base", "a"), joint("jb", "base", "b", xyz="1 0 0.5"),
        control(ja="position", jb="position"),
    )  # fmt: skip
    simulation = simulate(robot)
    run(simulation, 10, ["jb", "stranger", "ja"], position=[0.2, 9.0, -0.1])

    assert simulation.positions == pytest.approx([-0.1, 0.2], abs=1e-6)
    assert simulation.commandable("ja") and not simulation.commandable("stranger")


@pytest.mark.parametrize(("rate", "steps"), [(10, 100), (100, 10), (300, 4), (1000, 1), (3000, 1)])
def test_time_is_exact_at_every_tick(rate: int, steps: int) -> None:
    period = round(1e9 / rate)
    simulation = Simulation(pendulum(), control_period_ns=period)
    assert simulation.steps_per_period == steps

    for tick in range(1, 50):
        simulation.step_to(tick * period)
        assert simulation.at_tick
        assert simulation.time_ns == tick * period


def test_stepping_to_a_time_ends_at_the_first_step_not_before_it() -> None:
    simulation = simulate(pendulum())
    simulation.step_to(123_400_000)

    assert simulation.time_ns == 124_000_000
    assert not simulation.at_tick
    assert simulation.steps_to_tick == 76
    assert simulation.steps_until(100) == 0


def test_a_reset_of_the_state_leaves_time_alone() -> None:
    simulation = simulate(pendulum())
    run(simulation, 5, ["hinge"], position=[1.0])

    simulation.reset_state()

    assert simulation.time_ns == 5 * PERIOD_NS
    assert simulation.positions[0] == 0.0
    run(simulation, 5)
    assert simulation.positions[0] == pytest.approx(0.0, abs=1e-9)
