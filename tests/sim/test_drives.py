"""Drives: how soon positions and velocities are reached, in any pose, and what efforts are told."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from teleopctl.mujoco_model import RobotModel, build_model
from teleopctl.robot import RobotDescription, read_model, simulated
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import INERTIAL, box, control, joint, link, model

SMALL = 1e-3
JOINTS = ["turn", "lift", "roll", "hand"]
# In the model's own pose the first and the third joint turn all that is above them about itself.
BENT = [0.3, 1.2, -0.4, 1.0]
LIMIT = 'lower="-3" upper="3" effort="40" velocity="3"'


@pytest.fixture(scope="module")
def arm() -> RobotModel:
    """Four links of 0.5 kg; joints turn about the links, and across them, in turns."""
    axes = dict(zip(JOINTS, ("0 0 1", "1 0 0", "0 0 1", "1 0 0"), strict=True))
    parts, parent = [link("base", "")], "base"
    for name, axis in axes.items():
        parts += [link(f"{name}_link"), joint(name, parent, f"{name}_link", axis=axis, limit=LIMIT)]
        parent = f"{name}_link"
    return model(*parts, control(**dict.fromkeys(JOINTS, "position velocity")))


def bent(arm: RobotModel, rate: int) -> Simulation:
    simulation = Simulation(arm, control_period_ns=round(1e9 / rate))
    simulation.reset_state(positions=dict(zip(JOINTS, BENT, strict=True)))
    simulation.apply(JOINTS, position=BENT)
    simulation.step(simulation.steps_per_period)
    return simulation


def jump(simulation: Simulation, number: int, size: float) -> np.ndarray:
    """What is left of a jump of one joint after each millisecond, as a part of it."""
    target = list(BENT)
    target[number] += size
    left = []
    for _ in range(500):
        if simulation.at_tick:
            simulation.apply(JOINTS, position=target)
        simulation.step(1)
        simulation.read()
        left.append((target[number] - simulation.positions[number]) / size)
    return np.array(left)


@pytest.mark.parametrize("number", range(4), ids=JOINTS)
@pytest.mark.parametrize(
    ("rate", "within_ms"), [(10, 145), (50, 80), (100, 50), (250, 30), (1000, 30)]
)
def test_a_small_jump_is_done_in_the_pose_that_the_robot_has(
    arm: RobotModel, rate: int, within_ms: int, number: int
) -> None:
    left = jump(bent(arm, rate), number, SMALL)
    assert np.abs(left[within_ms:]).max() < 0.01
    assert left.min() > -0.01, "it does not go beyond"


@pytest.mark.parametrize("rate", [10, 50, 100, 1000])
def test_a_large_jump_brakes_in_time(arm: RobotModel, rate: int) -> None:
    for number in range(4):
        left = jump(bent(arm, rate), number, 0.5)
        assert left.min() > -0.01
        assert abs(left[-1]) < 1e-3


@pytest.mark.parametrize(("rate", "within_ms"), [(100, 30), (1000, 20)])
def test_a_velocity_that_the_effort_allows_is_reached_soon(
    arm: RobotModel, rate: int, within_ms: int
) -> None:
    for number in range(4):
        simulation = bent(arm, rate)
        wanted = [math.nan] * 4
        wanted[number] = 0.1
        reached = []
        for _ in range(100):
            if simulation.at_tick:
                position = list(BENT)
                position[number] = math.nan
                simulation.apply(JOINTS, position=position, velocity=wanted)
            simulation.step(1)
            simulation.read()
            reached.append(simulation.velocities[number] / 0.1)
        assert np.abs(np.array(reached[within_ms:]) - 1.0).max() < 0.01


def test_efforts_and_accelerations_that_are_told_are_those_of_the_motion(arm: RobotModel) -> None:
    simulation = bent(arm, 100)
    model, _ = simulation.observe()
    check = mujoco.MjData(model)
    largest, measured = 0.0, np.zeros(4)
    for millisecond in range(400):
        if simulation.at_tick:
            way = 0.5 * (1.0 - math.cos(2.0 * math.pi * (millisecond * 1e-3 + 0.01)))
            simulation.apply(JOINTS, position=[start + way for start in BENT])
        simulation.read()
        positions, velocities = simulation.positions.copy(), simulation.velocities.copy()
        if not simulation.at_tick:
            measured = simulation.observe()[1].qacc.copy()
        tick = simulation.at_tick
        simulation.step(1)
        simulation.read()
        check.qpos[:], check.qvel[:] = positions, velocities
        check.qacc[:] = (simulation.velocities - velocities) / simulation.timestep_s
        mujoco.mj_inverse(model, check)
        assert simulation.efforts == pytest.approx(check.qfrc_inverse, abs=1e-6)
        if not tick:
            assert measured == pytest.approx(check.qacc, abs=1e-6)
        largest = max(largest, float(np.abs(check.qacc).max()))
    assert largest > 10.0


def test_a_state_that_was_saved_in_another_pose_goes_on_with_the_same_bits(arm: RobotModel) -> None:
    def go_on(simulation: Simulation, direction: float) -> None:
        for tick in range(20):
            way = 0.05 * direction * tick
            simulation.apply(JOINTS, position=[start + way for start in BENT])
            simulation.step(10)

    first, other = bent(arm, 100), Simulation(arm, control_period_ns=10_000_000)
    go_on(first, 1.0)
    first.step(5)
    other.restore(first.save())
    for simulation in (first, other):
        simulation.step(5)
        go_on(simulation, -1.0)
        simulation.read()
    assert first.positions.tobytes() == other.positions.tobytes()
    assert first.efforts.tobytes() == other.efforts.tobytes()


@pytest.mark.parametrize("rate", [10, 100, 1000])
def test_a_rod_that_is_sent_through_a_wall_rests_against_it_with_its_effort(rate: int) -> None:
    wall = link("wall", box("collision", "1 0.2 1")) + joint(
        "stand", "base", "wall", kind="fixed", xyz="0 -0.5 1"
    )
    rod = box("collision", "0.1 0.1 0.8", "0 0 0.5") + INERTIAL
    robot = model(
        link("base", ""), link("rod", rod), joint("hinge", "base", "rod"),
        control(hinge="position"), wall,
    )  # fmt: skip
    simulation = Simulation(robot, control_period_ns=round(1e9 / rate))
    fastest, places = 0.0, []
    for millisecond in range(3000):
        if simulation.at_tick:
            simulation.apply(["hinge"], position=[1.5])
        simulation.step(1)
        simulation.read()
        assert abs(simulation.efforts[0]) <= 20.0 * (1.0 + 1e-9)
        if millisecond >= 1500:
            fastest = max(fastest, abs(float(simulation.velocities[0])))
            places.append(float(simulation.positions[0]))
    assert fastest < 1e-4, "it does not chatter"
    assert max(places) - min(places) < 1e-5
    assert simulation.efforts[0] == pytest.approx(20.0, rel=1e-3)


@pytest.mark.parametrize("kind", ["prismatic", "revolute"])
def test_an_effort_of_zero_limits_nothing_and_is_named_with_its_line(kind: str) -> None:
    limit = 'lower="-1" upper="1" effort="{}" velocity="0"'
    urdf = f"""<robot name="slide"><link name="world"/>
      {link("weight")}{link("other")}
      {joint("lift", "world", "weight", kind=kind, axis="0 0 1", limit=limit.format(0))}
      {joint("loose", "world", "other", kind=kind, axis="0 0 1", limit=limit.format(0))}
      {control(lift="position")}</robot>"""
    description = RobotDescription.from_urdf(urdf)
    model = build_model(description)
    (line,) = [n for n, text in enumerate(urdf.split("\n"), 1) if 'name="lift" type' in text]
    told = (
        f"No effort limit for lift (line {line}): effort 0 limits nothing, as in MuJoCo's reading "
        "of URDF; in Gazebo such a joint exerts no effort"
    )
    assert [warning for warning in model.warnings if "effort" in warning] == [told]
    simulation = Simulation(model, control_period_ns=10_000_000)
    simulation.step(1000)
    simulation.read()
    weight = 0.5 * 9.81 if kind == "prismatic" else 0.0
    assert simulation.efforts[0] == pytest.approx(weight, rel=1e-3)
    bounded = RobotDescription.from_urdf(urdf.replace('effort="0"', 'effort="20"'))
    assert not any("effort" in warning for warning in build_model(bounded).warnings)


def test_an_effort_that_sdf_does_not_limit_is_not_named(tmp_path: Path) -> None:
    file = tmp_path / "slide.sdf"
    axis = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper>{}</limit></axis>"
    text = """<sdf version="1.9"><model name="slide"><link name="weight"/>
      <joint name="lift" type="prismatic"><parent>world</parent><child>weight</child>{}</joint>
      </model></sdf>"""
    for effort, named in (
        ("", False),
        ("<effort>-1</effort>", False),
        ("<effort>0</effort>", True),
    ):
        file.write_text(text.format(axis.format(effort)))
        description = RobotDescription.from_urdf(simulated(read_model(file).text).urdf)
        warnings = build_model(description).warnings
        assert any("effort 0 limits nothing" in warning for warning in warnings) is named


def test_a_repeated_command_moves_with_the_same_bits(arm: RobotModel) -> None:
    repeated, fresh = bent(arm, 100), bent(arm, 100)
    target = [0.5, 1.0, 0.2, 0.9]
    for tick in range(40):
        repeated.apply(JOINTS, position=target)
        # Another name in every other command, so that none equals the one before.
        fresh.apply([*JOINTS, *["nothing"] * (tick % 2)], position=[*target, *[0.0] * (tick % 2)])
        for simulation in (repeated, fresh):
            simulation.step(simulation.steps_per_period)
            simulation.read()
        assert repeated.positions.tobytes() == fresh.positions.tobytes()
        assert repeated.efforts.tobytes() == fresh.efforts.tobytes()


@pytest.mark.parametrize("between", ["hold", "reset_state"])
def test_a_command_is_applied_again_after_a_hold_or_reset(arm: RobotModel, between: str) -> None:
    simulation = bent(arm, 100)
    for _ in range(2):
        simulation.apply(JOINTS, velocity=[0.5] * 4)
        simulation.step(50 * simulation.steps_per_period)
        simulation.read()
        assert simulation.velocities[3] == pytest.approx(0.5, abs=0.05)
        getattr(simulation, between)()
        simulation.step(50 * simulation.steps_per_period)
