"""Worlds of our own in YAML: short to write, and checked line by line."""

from __future__ import annotations

from pathlib import Path

import pytest

from teleopctl.errors import InvalidDescriptionError
from teleopctl.mujoco_model import build_model
from teleopctl.robot import read_world
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import link, robot

KITCHEN = """\
world: kitchen
gravity: [0, 0, -9.0]
things:
  table: {shape: table, size: [0.9, 0.6, 0.4], at: [2, 0, 0]}
  cube: {shape: box, size: [0.1, 0.1, 0.1], at: [2, 0, 0.5], mass: 0.1, color: red, friction: 0.6}
  bin: {shape: bin, size: [0.4, 0.3, 0.2], at: [4, 0, 0]}
  ball: {shape: sphere, radius: 0.05, at: [4, 0, 0.5], mass: 0.2}
  ramp: {shape: ramp, size: [1, 0.5, 0.3], at: [6, 0, 0], color: [0.2, 0.4, 0.6]}
  room: {shape: walls, size: [20, 20, 1]}
  crate: {shape: bin, size: [0.4, 0.4, 0.4], at: [0, 4, 0.001], mass: 3}
lights:
- {kind: spot, at: [0, 0, 3], direction: [0, 0, -1], color: white}
"""


def built(folder: Path, text: str) -> Simulation:
    file = folder / "world.yaml"
    file.write_text(text)
    base = robot(link("base", ""))
    model = build_model(base, world=read_world(file), fixed_base=True)
    assert model.warnings == ()
    return Simulation(model, control_period_ns=10_000_000)


def test_things_stand_and_lie_where_they_are_put(tmp_path: Path) -> None:
    simulation = built(tmp_path, KITCHEN)
    simulation.step(2500)
    bodies = simulation.free_bodies
    assert [body.link for body in bodies.bodies] == ["cube", "ball", "crate"]
    assert bodies.pose(0)[:3] == pytest.approx([2.0, 0.0, 0.45], abs=1e-3)
    # Within the bin, on its floor of 1 cm.
    assert bodies.pose(1)[2] == pytest.approx(0.06, abs=1e-3)
    m = simulation.model.mj_model
    assert [round(float(m.body(n).mass[0]), 9) for n in ("cube", "ball", "crate")] == [0.1, 0.2, 3]
    assert m.opt.gravity[2] == -9.0


def test_a_ramp_rises_along_x_to_its_height(tmp_path: Path) -> None:
    world = "things:\n  ramp: {shape: ramp, size: [2, 1, 1]}\n"
    for x, height in ((-0.5, 0.25), (0.5, 0.75)):
        ball = f"  ball: {{shape: sphere, radius: 0.01, at: [{x}, 0, {height + 0.02}], mass: 1}}\n"
        simulation = built(tmp_path, world + ball)
        simulation.step(100)
        place = simulation.free_bodies.pose(0)
        # A little above the slope, on which it has begun to roll down.
        assert place[0] < x
        assert place[2] - (0.5 + place[0] / 2) == pytest.approx(0.01 * 1.25**0.5, abs=2e-3)


def test_what_bounces_rises_to_the_square_of_it(tmp_path: Path) -> None:
    simulation = built(
        tmp_path,
        "things:\n  floor: {shape: plane, size: [5, 5], bounce: 1}\n"
        "  ball: {shape: sphere, radius: 0.1, at: [0, 2, 1.1], mass: 1, bounce: 0.6}\n",
    )
    # At the top of its second arc: after one fall, and a rise by 0.6 of that time.
    simulation.step(round((2.0 / 9.81) ** 0.5 * 1.6e3))
    assert simulation.free_bodies.pose(0)[2] - 0.1 == pytest.approx(0.36, abs=5e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ": it is empty"),
        ("things: [1", ": not YAML"),
        ("things:\n  a: {shape: bux}", ":2: 'shape' is 'bux', should be box, sphere"),
        ("things:\n  a:\n    shape: box", ":3: 'a' lacks its size"),
        ("things:\n  a: {shape: box,\n    sise: [1, 1, 1]}", ":3: 'a' has no 'sise'"),
        ("things:\n  a: {shape: box, size: [1, 1, -1]}", ":2: 'size'[2] should be a positive"),
        ("things:\n  a: {shape: box, size: [1, 1, .nan]}", "should be a positive number"),
        ("things:\n  a: {shape: sphere, radius: 1, mass: -2}", "'mass' should be a positive"),
        (
            "things:\n  a: {shape: plane, mass: 2}",
            "'mass' is not allowed for a plane, which is static",
        ),
        ("things:\n  a: {shape: mesh, file: none.stl}", "'file' is not found: "),
        ("things:\n  a: {shape: sphere, radius: 1, color: puce}", "'color' is 'puce'"),
        ("things:\n  a: {shape: sphere, radius: 1, bounce: 1.5}", "'bounce' should be from 0 to 1"),
        ("thinks: {}", ":1: the world has no 'thinks'"),
        ("lights: [{kind: lamp}]", ":1: 'kind' is 'lamp', should be directional"),
        ("things:\n  a: {shape: sphere, radius: 1}\n  a: {shape: plane}", "is given twice"),
    ],
)
def test_a_mistake_is_told_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "world.yaml"
    file.write_text(text)
    with pytest.raises(InvalidDescriptionError) as caught:
        read_world(file)
    assert str(file) in caught.value.message
    assert message in caught.value.message
