"""`RobotSimulation`: the simulator's physics in a program's own loop."""

import pytest

from teleopctl import RobotSimulation, load_robot
from teleopctl.errors import NotFoundError, UsageError

ARM = "package://teleop_description/urdf/teleop.urdf.xacro"


@pytest.fixture(scope="module")
def arm():
    return load_robot(ARM)


def test_a_commanded_joint_gets_there_and_its_follower_with_it(arm):
    simulation = RobotSimulation(arm)
    simulation.command({"joint_1": 0.5, "joint_4": -0.4})
    simulation.step(100)
    assert simulation.time_s == pytest.approx(1.0)
    assert simulation.positions["joint_1"] == pytest.approx(0.5, abs=1e-3)
    assert simulation.positions["joint_5"] == pytest.approx(0.4, abs=1e-3)
    assert abs(simulation.velocities["joint_1"]) < 1e-3
    expected = arm.forward_kinematics(simulation.positions)["claw_support"]
    assert simulation.T_world_link("claw_support") == pytest.approx(expected, abs=1e-6)


def test_two_runs_give_the_same_bits(arm):
    def run():
        simulation = RobotSimulation(arm)
        simulation.command({"joint_2": -0.7})
        simulation.step(50)
        return simulation.positions, simulation.velocities, simulation.efforts

    assert run() == run()


def test_a_reset_returns_to_the_start(arm):
    simulation = RobotSimulation(arm)
    start = simulation.positions
    simulation.command({"joint_1": 0.5})
    simulation.step(20)
    simulation.reset()
    assert (simulation.time_s, simulation.positions) == (0.0, start)


def test_mujocos_own_model_and_data_can_be_read(arm):
    simulation = RobotSimulation(arm, control_rate_hz=50)
    simulation.step()
    model, data = simulation.mujoco
    assert data.time == pytest.approx(0.02)
    assert model.njnt == len(simulation.joint_names)


def test_mistakes_are_named(arm):
    simulation = RobotSimulation(arm)
    with pytest.raises(NotFoundError, match="no joint 'joint_9'"):
        simulation.command({"joint_9": 1.0})
    with pytest.raises(NotFoundError, match="'joint_5' takes no commands"):
        simulation.command({"joint_5": 1.0})
    with pytest.raises(NotFoundError, match="no link 'claw'"):
        simulation.T_world_link("claw")
    with pytest.raises(UsageError, match="control_rate_hz"):
        RobotSimulation(arm, control_rate_hz=0)
