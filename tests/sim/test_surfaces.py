"""What bounces, spins and rolls does so by the closed forms, as its description asks for it."""

import math
from pathlib import Path

import numpy as np
import pytest

from teleopctl.mujoco_model import NewObject, RobotModel, build_model, with_objects
from teleopctl.robot import RobotDescription, read_model, read_world
from teleopctl.robot.urdf import Pose
from teleopctl.sim.simulation import Simulation
from tests.samples import sample
from tests.sim.robots import joint, link, robot

G = 9.81
MASS, RADIUS = 0.5, 0.1
INERTIA = 0.4 * MASS * RADIUS**2
STILL = robot(link("world", ""))
FLOOR = "<geometry><plane><normal>0 0 1</normal><size>20 20</size></plane></geometry>"


def bounce(restitution: float) -> str:
    return f"<bounce><restitution_coefficient>{restitution}</restitution_coefficient></bounce>"


def torsional(coefficient: float, radius: float) -> str:
    return (
        f"<friction><torsional><coefficient>{coefficient}</coefficient>"
        f"<patch_radius>{radius}</patch_radius></torsional></friction>"
    )


def thing(name: str, shape: str, surface: str, z: float = 0.0, x: float = 0.0) -> str:
    moments = "".join(f"<i{axes}>{INERTIA}</i{axes}>" for axes in ("xx", "yy", "zz"))
    return (
        f"<model name='{name}'><pose>{x} 0 {z} 0 0 0</pose><static>{str(z == 0.0).lower()}</static>"
        f"<link name='l'><inertial><mass>{MASS}</mass><inertia>{moments}</inertia></inertial>"
        f"<collision name='c'>{shape}<surface>{surface}</surface></collision></link></model>"
    )


BALL = f"<geometry><sphere><radius>{RADIUS}</radius></sphere></geometry>"
BOX = f"<geometry><box><size>{2 * RADIUS} {2 * RADIUS} {2 * RADIUS}</size></box></geometry>"


def world(tmp_path: Path, *things: str) -> RobotModel:
    file = tmp_path / "world.sdf"
    file.write_text(f"<sdf version='1.9'><world name='w'>{''.join(things)}</world></sdf>")
    built = build_model(STILL, world=read_world(file))
    assert built.warnings == ()
    return built


def heights(simulation: Simulation, body: str, seconds: float) -> list[float]:
    found = []
    for _ in range(round(seconds / simulation.timestep_s)):
        simulation.step(1)
        found.append(float(simulation.link_pose(body).position[2]) - RADIUS)
    return found


def rises(found: list[float]) -> float:
    """How high something comes after it has touched the ground."""
    touched = next(number for number, height in enumerate(found) if height < 0.0)
    return max(found[touched:])


@pytest.mark.parametrize("timestep_ns", sample([1_000_000, 300_000], 3))
@pytest.mark.parametrize("shape", [BALL, BOX], ids=["ball", "box"])
@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.5, 0.8, 0.95])
def test_what_falls_rises_by_the_square_of_its_restitution(
    tmp_path: Path, restitution: float, shape: str, timestep_ns: int
) -> None:
    floor, falls = (
        thing("floor", FLOOR, bounce(1.0)),
        thing("t", shape, bounce(restitution), 1 + RADIUS),
    )
    simulation = Simulation(
        world(tmp_path, floor, falls), control_period_ns=3_000_000, timestep_ns=timestep_ns
    )
    found = heights(simulation, "t", 0.9)
    # In the step in which it touches it may be so deep in the floor already.
    deepest = math.sqrt(2.0 * G) * simulation.timestep_s
    assert rises(found) == pytest.approx(restitution**2, rel=0.01, abs=deepest)
    assert min(found) > -1.1 * deepest


def test_of_two_that_touch_the_coefficients_are_multiplied_and_one_alone_does_nothing(
    tmp_path: Path,
) -> None:
    both = Simulation(
        world(
            tmp_path,
            thing("floor", FLOOR, bounce(0.8)),
            thing("t", BALL, bounce(0.5), 1 + RADIUS),
            thing("dull", BALL, "", 1 + RADIUS, 2.0),
        ),
        control_period_ns=1_000_000,
    )
    found = heights(both, "t", 0.7)
    assert rises(found) == pytest.approx((0.8 * 0.5) ** 2, abs=5e-3)
    both.step(300)
    assert float(both.link_pose("dull").position[2]) < RADIUS + 1e-3


def test_two_balls_of_one_mass_swap_their_speeds(tmp_path: Path) -> None:
    smooth = f"<friction><ode><mu>0</mu><mu2>0</mu2></ode></friction>{bounce(1.0)}"
    balls = [thing(name, BALL, smooth, 5.0, x) for name, x in (("a", 0.0), ("b", 1.0))]
    simulation = Simulation(world(tmp_path, *balls), control_period_ns=1_000_000)
    start = simulation.free_bodies.pose(0)
    simulation.free_bodies.put(0, start, np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    simulation.step(600)
    speeds = [float(simulation.free_bodies.twist(number)[0]) for number in (0, 1)]
    assert speeds == pytest.approx([0.0, 2.0], abs=0.01)


def test_a_robots_link_bounces_on_what_was_spawned(tmp_path: Path) -> None:
    surface = f"<collision><surface>{bounce(0.7)}</surface></collision>"
    tag = f'<gazebo reference="ball">{surface}</gazebo>'
    solid = (
        f'<inertial><mass value="{MASS}"/><inertia ixx="{INERTIA}" iyy="{INERTIA}" '
        f'izz="{INERTIA}" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>'
        f'<sphere radius="{RADIUS}"/></geometry></collision>'
    )
    loose = joint("loose", "world", "ball", kind="floating", limit="", xyz="0 0 1.3")
    built = build_model(robot(link("world", ""), link("ball", solid), loose, tag))
    assert built.warnings == ()
    file = tmp_path / "block.sdf"
    block = thing("block", BOX, bounce(1.0))
    file.write_text(f"<sdf version='1.9'>{block}</sdf>")
    coming = NewObject(
        read_world(file), "block", np.array([0.0, 0.0, 0.1]), np.array([1.0, 0, 0, 0])
    )
    simulation = Simulation(built, control_period_ns=1_000_000)
    simulation.replace_model(with_objects(built, [coming]))
    found = [height - 2 * RADIUS for height in heights(simulation, "ball", 0.8)]
    assert rises(found) == pytest.approx(0.49, rel=0.01, abs=5e-3)


def test_what_bounces_slides_and_comes_to_rest_as_if_it_did_not(tmp_path: Path) -> None:
    rough = "<friction><ode><mu>0.4</mu><mu2>0.4</mu2></ode></friction>"
    floor = thing("floor", FLOOR, bounce(0.9))
    brick = thing("brick", BOX, f"{rough}{bounce(0.9)}", RADIUS)
    simulation = Simulation(world(tmp_path, floor, brick), control_period_ns=1_000_000)
    simulation.step(500)
    start = simulation.free_bodies.pose(0)
    simulation.free_bodies.put(0, start, np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0]))
    simulation.step(2_000)
    way = simulation.free_bodies.pose(0)[0] - start[0]
    assert way == pytest.approx(1.5**2 / (2.0 * 0.4 * G), rel=0.02)
    assert np.abs(simulation.free_bodies.twist(0)).max() < 1e-3


def test_what_spins_stops_when_the_friction_of_its_patch_has_braked_it(tmp_path: Path) -> None:
    # The larger patch counts, and the smaller coefficient.
    top = thing("top", BALL, torsional(0.8, 0.02), RADIUS)
    simulation = Simulation(
        world(tmp_path, thing("floor", FLOOR, torsional(0.5, 0.01)), top),
        control_period_ns=1_000_000,
    )
    simulation.step(500)
    spin = 20.0
    put = np.array([0.0, 0.0, 0.0, 0.0, 0.0, spin])
    simulation.free_bodies.put(0, simulation.free_bodies.pose(0), put)
    moment = 3.0 * math.pi / 16.0 * 0.02 * 0.5 * MASS * G
    simulation.step(1_000)
    after = float(simulation.free_bodies.twist(0)[5])
    assert spin - after == pytest.approx(moment / INERTIA, rel=0.01)
    rest_s = INERTIA * spin / moment
    simulation.step(round((rest_s - 1.0) * 1e3) - 30)
    assert float(simulation.free_bodies.twist(0)[5]) > 0.1
    simulation.step(100)
    assert float(simulation.free_bodies.twist(0)[5]) == pytest.approx(0.0, abs=1e-3)


def test_a_ball_rolls_until_its_resistance_has_stopped_it(tmp_path: Path) -> None:
    rolling, rough = 0.002, 0.5
    resistance = f"<bullet><rolling_friction>{rolling}</rolling_friction></bullet>"
    ode = f"<ode><mu>{rough}</mu><mu2>{rough}</mu2></ode>"
    floor = thing("floor", FLOOR, f"<friction>{ode}</friction>")
    ball = thing("ball", BALL, f"<friction>{resistance}</friction>", RADIUS)
    simulation = Simulation(world(tmp_path, floor, ball), control_period_ns=1_000_000)
    simulation.step(500)
    speed = 1.0
    put = np.array([speed, 0.0, 0.0, 0.0, speed / RADIUS, 0.0])
    start = simulation.free_bodies.pose(0)
    simulation.free_bodies.put(0, start, put)
    braking = rolling * rough * MASS * G / RADIUS / (MASS + INERTIA / RADIUS**2)
    simulation.step(2_000)
    way = simulation.free_bodies.pose(0)[0] - start[0]
    assert way == pytest.approx(speed * 2.0 - braking * 2.0**2 / 2.0, rel=0.01)


def test_a_robot_of_sdf_keeps_its_surfaces(tmp_path: Path) -> None:
    file = tmp_path / "robot.sdf"
    ball = thing("ball", BALL, bounce(0.6) + torsional(0.5, 0.03), 1.0)
    file.write_text(f"<sdf version='1.9'>{ball}</sdf>")
    description = RobotDescription.from_urdf(read_model(file).text)
    surface = description.gazebo.links["l"].surface
    assert surface is not None
    assert surface.values == [0.6, 0.5, 0.03, 0.0]
    build_model(description, spawn_pose=Pose((0.0, 0.0, 1.0)))
