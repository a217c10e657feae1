"""States to go on from later: the same bits, in the same model only."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from teleopctl.errors import InvalidFileError, RefusedError
from teleopctl.mujoco_model import NewObject, RobotModel, build_model, with_objects
from teleopctl.robot import read_model, read_world, read_world_text
from teleopctl.sim.building import simulate
from teleopctl.sim.entities.pushes import Push
from teleopctl.sim.simulation import Simulation
from teleopctl.sim.state.saved_state import SavedState
from tests.mujoco_model.test_world import cube, rod, wall, world_urdf

KEYFRAMES = """<mujoco><worldbody><body name="arm" pos="0 0 1"><joint name="hinge" axis="0 1 0"/>
  <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/></body></worldbody>
  <actuator><position joint="hinge" kp="50"/></actuator>
  <keyframe><key name="home" qpos="0.1" ctrl="0.1"/>
    <key name="bent" qpos="0.7" ctrl="0.6"/></keyframe>
</mujoco>"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    """A rod on a hinge, and a cube above a wall."""
    file = tmp_path_factory.mktemp("world") / "world.urdf"
    file.write_text(world_urdf(wall("2 0 0.1"), cube()))
    return build_model(rod(), world=read_world(file), fixed_base=True)


def begun(model: RobotModel) -> Simulation:
    return Simulation(model, control_period_ns=10_000_000)


def moving(model: RobotModel) -> Simulation:
    """On its way to 0.5 rad, in the middle of a control period."""
    simulation = begun(model)
    simulation.apply(["hinge"], [0.5])
    simulation.step(105)
    return simulation


def after(simulation: Simulation, steps: int) -> tuple[float, ...]:
    simulation.step(steps)
    simulation.read()
    return (*simulation.positions, *simulation.velocities, *simulation.free_bodies.pose(0))


def test_what_goes_on_from_a_file_gives_the_same_bits(model: RobotModel, tmp_path: Path) -> None:
    first, file = moving(model), tmp_path / "state.json"
    SavedState.of(first).write(file)
    expected = after(first, 300)

    other = begun(model)
    other.apply(["hinge"], [-0.3])
    other.step(50)
    SavedState.read(file).put(other)
    assert other.time_ns == 5_000_000, "time begins anew, within the same control period"
    assert after(other, 300) == expected


def test_what_stood_elsewhere_stands_there_again(model: RobotModel) -> None:
    simulation = moving(model)
    simulation.set_static_pose("wall", np.array([5.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0]))
    state = SavedState.of(simulation)
    simulation.reset()
    state.put(simulation)
    assert simulation.link_pose("wall").position == pytest.approx([5.0, 0.0, 0.1])


def test_gravity_and_pushes_go_on_from_where_they_were(model: RobotModel, tmp_path: Path) -> None:
    def pushed() -> Simulation:
        simulation, up = begun(model), np.array([0.0, 0.0, 5.0])
        simulation.set_gravity([0.0, 0.0, -3.7])
        simulation.push(Push("cube", up, 0.1 * up, np.zeros(3), steps=60, ramp=20))
        simulation.step(30)
        return simulation

    first, file = pushed(), tmp_path / "state.json"
    SavedState.of(first).write(file)
    expected = after(first, 300)
    other = begun(model)
    SavedState.read(file).put(other)
    assert after(other, 300) == expected
    assert other.gravity == [0.0, 0.0, -3.7]

    for row in ([999.0, *[0.0] * 9, 1.0, 0.0], [1.0, *[0.0] * 9, 0.0, 0.0], [1.0]):
        saved = SavedState.of(begun(model))
        saved = SavedState(saved.parts, {**saved.values, "pushes": np.array(row)})
        with pytest.raises(RefusedError, match="The saved state is invalid: "):
            saved.put(other)


def test_a_state_of_another_model_is_refused_and_changes_nothing(
    model: RobotModel, tmp_path: Path
) -> None:
    alone, joined = moving(model), begun(model)
    block = read_world_text("things: {block: {shape: box, size: [1, 1, 1], mass: 1}}", "text")
    coming = NewObject(block, "block", np.array([4.0, 0, 1]), np.array([1.0, 0, 0, 0]))
    joined.replace_model(with_objects(model, [coming]))
    before = after(alone, 0)
    with pytest.raises(RefusedError, match="another model: it has the body 'block'"):
        SavedState.of(joined).put(alone)
    with pytest.raises(RefusedError, match="another model: it lacks the body 'block'"):
        SavedState.of(alone).put(joined)

    file = tmp_path / "state.json"
    SavedState.of(alone).write(file)
    content = json.loads(file.read_text())
    content["values"]["physics"][3] = float("nan")
    file.write_text(json.dumps(content))
    with pytest.raises(RefusedError, match="not all of its numbers are finite"):
        SavedState.read(file).put(alone)
    content["values"]["physics"].pop()
    file.write_text(json.dumps(content))
    with pytest.raises(RefusedError, match="have other properties"):
        SavedState.read(file).put(alone)
    assert after(alone, 0) == before


@pytest.mark.parametrize("text", ["", "{}", "[1, 2]", '{"format": 3}', "[" * 100_000])
def test_what_is_no_state_is_told_with_its_file(tmp_path: Path, text: str) -> None:
    file = tmp_path / "state.json"
    file.write_text(text)
    with pytest.raises(InvalidFileError, match=r"state\.json is not a state"):
        SavedState.read(file)


def test_a_robot_of_mujoco_s_is_put_into_its_keyframes_by_name(tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(KEYFRAMES)
    simulation = simulate(read_model(file).text, control_period_ns=10_000_000).simulation
    assert simulation.positions[0] == 0.1
    simulation.reset_state(keyframe="bent")
    assert simulation.positions[0] == 0.7
    simulation.step(2000)
    simulation.read()
    assert simulation.positions[0] == pytest.approx(0.6, abs=0.2), "its controls are told too"
    simulation.reset_state()
    assert simulation.positions[0] == 0.1
