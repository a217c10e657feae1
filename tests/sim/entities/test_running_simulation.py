"""Things that come and go while a simulation runs, and leave everything else as it was."""

from __future__ import annotations

import threading
from pathlib import Path

import mujoco
import numpy as np
import pytest

from teleopctl.errors import InvalidDescriptionError, RefusedError
from teleopctl.mujoco_model import (
    NewObject,
    RobotModel,
    build_model,
    with_objects,
    with_world,
    without_objects,
)
from teleopctl.node import Future
from teleopctl.robot import World, read_world, read_world_text
from teleopctl.sim.entities.entity import bounds_of, entities, find, motion_of, move
from teleopctl.sim.entities.pushes import Push
from teleopctl.sim.entities.spawn_services import meshes_left_out
from teleopctl.sim.entities.spawning import SpawnQueue
from teleopctl.sim.simulation import Simulation
from tests.mujoco_model.test_world import cube, rod, wall, world_urdf
from tests.sim.robots import INERTIAL, box, joint, link

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
BLOCK = f'<robot name="block">{link("b", INERTIAL + box("collision", "0.2 0.2 0.2"))}</robot>'
BALL = '<body><freejoint/><geom size="0.1"/></body>'
SPHERE = f'<mujoco model="ball"><worldbody>{BALL}</worldbody></mujoco>'
BALL_IN_SPACE = """<mujoco><worldbody><body gravcomp="1"><freejoint/>
  <inertial pos="0 0 0" mass="0.5" diaginertia="0.01 0.01 0.01"/>
  <geom size="0.1"/></body></worldbody></mujoco>"""
PILLAR = '<mujoco><worldbody><geom type="box" size="0.1 0.1 0.5"/></worldbody></mujoco>'
DOOR = world_urdf(
    link("frame", ""),
    link("leaf", INERTIAL),
    joint("fixed", "world", "frame", kind="fixed"),
    joint("hinge", "frame", "leaf", axis="0 0 1"),
)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    """A rod on a hinge, and a cube above a wall."""
    file = tmp_path_factory.mktemp("world") / "world.urdf"
    file.write_text(world_urdf(wall("2 0 0.1"), cube()))
    return build_model(rod(), world=read_world(file), fixed_base=True)


def thing(text: str) -> World:
    return read_world_text(text, "resource_string")


def running(model: RobotModel) -> Simulation:
    simulation = Simulation(model, control_period_ns=10_000_000)
    simulation.apply(["hinge"], [0.5])
    simulation.step(105)
    return simulation


def spawn(simulation: Simulation, text: str, name: str, *place: float) -> None:
    coming = NewObject(thing(text), name, np.array(place), UPRIGHT)
    simulation.replace_model(with_objects(simulation.model, [coming]))


def observed(simulation: Simulation) -> tuple[float, ...]:
    simulation.read()
    return (*simulation.positions, *simulation.velocities, *simulation.free_bodies.pose(0))


def test_what_comes_falls_and_everything_else_goes_on_as_it_was(model: RobotModel) -> None:
    alone, joined = running(model), running(model)
    before = observed(joined)
    spawn(joined, BLOCK, "block", 4.0, 0.0, 1.0)
    assert observed(joined) == before
    assert joined.time_ns == alone.time_ns

    for simulation in (alone, joined):
        simulation.step(895)
    assert observed(joined) == pytest.approx(observed(alone), abs=1e-9)
    assert joined.free_bodies.pose(1)[:3] == pytest.approx([4.0, 0.0, 0.1], abs=2e-3)


def test_what_leaves_takes_nothing_with_it(model: RobotModel) -> None:
    alone, joined = running(model), running(model)
    spawn(joined, BLOCK, "first", 4.0, 0.0, 1.0)
    spawn(joined, SPHERE, "second", 4.0, 1.0, 1.0)
    joined.replace_model(without_objects(joined.model, ["first"]))
    for simulation in (alone, joined):
        simulation.step(100)

    assert list(entities(joined)) == ["test", "wall", "cube", "second"]
    assert joined.free_bodies.pose(1)[:2] == pytest.approx([4.0, 1.0])
    assert observed(joined) == pytest.approx(observed(alone), abs=1e-9)
    spawn(joined, BLOCK, "first", 4.0, 0.0, 1.0)
    assert joined.free_bodies.pose(2)[:3] == pytest.approx([4.0, 0.0, 1.0])


def test_a_command_holds_through_a_change(model: RobotModel) -> None:
    simulation = running(model)
    spawn(simulation, BLOCK, "block", 4.0, 0.0, 1.0)
    simulation.step(3000)
    simulation.read()
    assert simulation.positions[0] == pytest.approx(0.5, abs=1e-3)


def test_the_same_things_at_the_same_times_give_the_same_bits(model: RobotModel) -> None:
    runs = []
    for _ in range(2):
        simulation = running(model)
        spawn(simulation, BLOCK, "block", 2.03, 0.02, 1.0)
        simulation.step(500)
        simulation.replace_model(without_objects(simulation.model, ["cube"]))
        simulation.step(500)
        runs.append(observed(simulation))
    assert runs[0] == runs[1]


def test_a_reset_puts_things_back_to_where_they_came_in(model: RobotModel) -> None:
    simulation = running(model)
    spawn(simulation, BLOCK, "block", 4.0, 0.0, 1.0)
    move(simulation, find(simulation, "wall"), np.array([7.0, 0.0, 0.0, *UPRIGHT]), None)
    simulation.step(300)
    simulation.reset_state()
    assert simulation.free_bodies.pose(1)[2] == 1.0
    assert motion_of(simulation, find(simulation, "wall")).pose[0] == 2.0


def test_what_stands_still_can_be_put_elsewhere_and_what_lay_on_it_falls(
    model: RobotModel,
) -> None:
    simulation = running(model)
    simulation.step(3000)  # the cube sleeps
    assert simulation.free_bodies.pose(0)[2] == pytest.approx(0.3, abs=1e-3)
    wall_ = find(simulation, "wall")
    move(simulation, wall_, np.array([5.0, 0.0, 0.1, *UPRIGHT]), None)
    simulation.step(2000)
    assert simulation.free_bodies.pose(0)[2] == pytest.approx(0.1, abs=1e-3)
    assert motion_of(simulation, wall_).pose[:3] == pytest.approx([5.0, 0.0, 0.1])
    room = bounds_of(simulation, wall_, in_world=True)
    assert room is not None
    assert room.high == pytest.approx([5.1, 0.1, 0.2])
    with pytest.raises(RefusedError, match="'wall' is static"):
        move(simulation, wall_, None, np.ones(6))
    with pytest.raises(RefusedError, match="'test' is fixed to the world"):
        move(simulation, find(simulation, "test"), np.array([1.0, 0.0, 0.0, *UPRIGHT]), None)


@pytest.mark.parametrize("way", ["step", "coast"])
def test_a_thing_that_breaks_down_begins_anew_alone(model: RobotModel, way: str) -> None:
    alone, joined = running(model), running(model)
    heavy = BLOCK.replace('mass value="0.5"', 'mass value="1e20"')
    assert heavy != BLOCK
    spawn(joined, heavy, "heavy", 4.0, 0.0, 1.0)
    for simulation in (alone, joined):
        end = simulation.time_ns + 1_000_000_000
        while (left := simulation.steps_until(end)) > 0:
            getattr(simulation, way)(min(left, 37))

    assert set(joined.put_back) == {"heavy"}
    assert not joined.diverged
    assert joined.time_ns == alone.time_ns
    assert np.isfinite(joined.free_bodies.pose(1)).all()
    simulation.read()
    assert observed(joined)[:2] == observed(alone)[:2]
    assert joined.free_bodies.pose(0) == pytest.approx(alone.free_bodies.pose(0), abs=1e-4)


def test_what_breaks_down_may_be_pushed_and_driven_by_nobody(model: RobotModel) -> None:
    simulation = running(model)
    spawn(simulation, BLOCK, "block", 4.0, 0.0, 1.0)
    much = np.array([1e9, 0.0, 0.0])
    simulation.push(Push("block", much, much, np.array([0.0, 5.0, 0.0]), 1 << 40))
    simulation.step(3000)

    assert "block" in simulation.put_back
    assert len(simulation.put_back) == 1
    assert simulation.free_bodies.pose(1)[:3] == pytest.approx([4.0, 0.0, 0.1], abs=2e-3)


def test_a_scene_without_joints_becomes_one_thing_that_stands(model: RobotModel) -> None:
    simulation = running(model)
    spawn(simulation, PILLAR, "pillar", 3.0, 0.0, 0.5)
    pillar = find(simulation, "pillar")
    assert pillar.index is None
    room = bounds_of(simulation, pillar)
    assert room is not None
    assert (*room.low, *room.high) == pytest.approx((-0.1, -0.1, -0.5, 0.1, 0.1, 0.5))


def test_a_door_moves_as_it_is_pushed(model: RobotModel) -> None:
    simulation = running(model)
    spawn(simulation, DOOR, "door", 3.0, 0.0, 0.0)
    _, data = simulation.observe()
    assert data.joint("world/1/hinge").qpos[0] == 0.0
    assert simulation.has_link("door/leaf")


def test_a_mesh_that_touches_in_another_way_is_no_missing_one() -> None:
    missing = "Mesh 'package://a/b.stl' is left out: there is no such file"
    told = ["Mesh 'c.stl' is hollow: it touches as 9 convex pieces", missing, "<light> is left out"]
    assert meshes_left_out(told) == [missing]


def test_another_world_takes_the_place_of_the_first(model: RobotModel, tmp_path: Path) -> None:
    simulation = running(model)
    spawn(simulation, BLOCK, "block", 4.0, 0.0, 1.0)
    moon = SPHERE.replace("<worldbody>", '<option gravity="0 0 -1.6"/><worldbody>')
    simulation.replace_model(with_world(simulation.model, thing(moon)))
    simulation.reset_world_state()
    (ball,) = (entity for entity in entities(simulation).values() if not entity.is_robot)
    simulation.step(100)
    assert motion_of(simulation, ball).acceleration[2] == pytest.approx(-1.6)

    simulation.replace_model(with_world(simulation.model, None))
    assert list(entities(simulation)) == ["test"]
    kinds = list(simulation.model.mj_model.geom_type)
    assert kinds.count(0) == 1, "the ground is there, once"


def test_a_world_takes_its_lights_and_places_with_it(model: RobotModel) -> None:
    lit = "lights: [{kind: spot, at: [0, 0, 2]}]\nposes: {dock: {at: [1, 2, 0]}}"
    room = "things: {room: {shape: walls, size: [8, 6, 2]}, ball: {shape: sphere, radius: 0.1}}"
    empty, there = with_world(model, None), with_world(model, thing(f"things: {{}}\n{lit}"))
    for other in (with_world(there, thing(room)), there):
        bare = with_world(other, None)
        assert bare.mj_model.nlight == empty.mj_model.nlight
        assert (bare.mj_model.ngeom, bare.mj_model.nsite) == (
            empty.mj_model.ngeom,
            empty.mj_model.nsite,
        )
    assert with_world(there, None).mj_model.nlight < there.mj_model.nlight


def test_a_worlds_sun_takes_the_place_of_ours(model: RobotModel) -> None:
    sun = '<sdf version="1.8"><world name="w">{}</world></sdf>'
    sun = sun.format('<light name="l" type="directional"><diffuse>.8 .8 .8 1</diffuse></light>')
    spot = "things: {}\nlights: [{kind: spot, at: [0, 0, 2]}]"

    def suns(model: RobotModel) -> int:
        return int(np.sum(model.mj_model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL))

    built = build_model(rod(), world=thing(sun))
    assert [suns(built), suns(with_world(built, None)), suns(model)] == [1, 1, 1]
    lit = with_world(with_world(model, thing(sun)), thing(spot))
    assert (suns(lit), lit.mj_model.nlight) == (1, 2)
    # Seen from anywhere, Gazebo's ground of 0.8 is not white.
    light = built.mj_model.vis.headlight
    assert 0.8 * (light.ambient + light.diffuse + built.mj_model.light_diffuse[0]).max() <= 1.001


def test_a_push_moves_a_thing_by_its_impulse_and_turns_it_by_its_lever(model: RobotModel) -> None:
    simulation = running(model)
    spawn(simulation, BALL_IN_SPACE, "ball", 4.0, 0.0, 5.0)
    ball = find(simulation, "ball")
    nothing = np.zeros(3)
    # 2 N for 0.1 s on 0.5 kg, of which the last half fades: 0.75 of it acts.
    force = np.array([2.0, 0.0, 0.0])
    simulation.push(Push("ball", force, nothing, nothing, steps=100, ramp=50))
    simulation.step(200)
    assert motion_of(simulation, ball).twist[:3] == pytest.approx([0.302, 0.0, 0.0], abs=1e-6)
    lever = np.array([0.0, 0.1, 0.0])
    simulation.push(Push("ball", force, nothing, lever, steps=1))
    simulation.step(10)
    # 2 N at 0.1 m for 1 ms on 0.01 kg m².
    assert motion_of(simulation, ball).twist[5] == pytest.approx(-0.02, rel=1e-3)
    simulation.push(Push("cube", np.array([0.0, 0.0, 100.0]), nothing, nothing, steps=1000))
    simulation.reset_state()
    simulation.step(50)
    assert motion_of(simulation, find(simulation, "cube")).twist[2] < 0.0, "a reset ends pushes"


def test_a_file_of_several_things_becomes_as_many_placed_as_it_has_them(model: RobotModel) -> None:
    simulation = running(model)
    text = """things:
  shelf: {shape: box, size: [1, 1, 0.2], at: [1, 0, 0.1]}
  jar: {shape: sphere, radius: 0.1, mass: 0.5, at: [1, 0, 0.4], rpy: [0, 0, 0.5]}"""
    left = np.array([0.5**0.5, 0.0, 0.0, 0.5**0.5])
    coming = NewObject(thing(text), "pantry", np.array([4.0, 3.0, 1.0]), left)
    simulation.replace_model(with_objects(simulation.model, [coming]))

    assert coming.names == ("pantry/shelf", "pantry/jar")
    assert [name for name in entities(simulation) if "/" in name] == ["pantry/shelf", "pantry/jar"]
    # One metre ahead of the place is one to the left of the world.
    jar, shelf = (motion_of(simulation, find(simulation, f"pantry/{n}")) for n in ("jar", "shelf"))
    assert jar.pose[:3] == pytest.approx([4.0, 4.0, 1.4])
    assert 2 * np.arctan2(jar.pose[6], jar.pose[3]) == pytest.approx(np.pi / 2 + 0.5)
    assert shelf.pose[:3] == pytest.approx([4.0, 4.0, 1.1])
    simulation.step(1000)
    fallen = motion_of(simulation, find(simulation, "pantry/jar")).pose
    assert fallen[:3] == pytest.approx([4.0, 4.0, 1.3], abs=2e-3), "it lies on the shelf"
    alone = without_objects(simulation.model, ["pantry/shelf"])
    assert [thing.name for thing in alone.things][-1] == "pantry/jar"
    twins = thing(SPHERE.replace(BALL, 2 * BALL))
    both = with_objects(model, [NewObject(twins, "twins", np.zeros(3), UPRIGHT)])
    assert [thing.name for thing in both.things][-2:] == ["twins/part1", "twins/part2"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><worldbody/></mujoco>", "it is empty"),
        ("<mujoco><worldbody><geom size='1' pos='nan 0 0'/></worldbody></mujoco>", "not finite"),
        (
            SPHERE.replace("<geom", "<inertial pos='0 0 0' mass='-1' diaginertia='1 1 1'/><geom"),
            "mass",
        ),
    ],
)
def test_what_cannot_be_simulated_is_refused_before_anything_has_changed(
    model: RobotModel, text: str, message: str
) -> None:
    with pytest.raises(InvalidDescriptionError, match=message):
        with_objects(model, [NewObject(thing(text), "x", np.zeros(3), UPRIGHT)])


def test_what_waits_is_compiled_at_once_and_what_is_wrong_holds_up_itself_alone(
    model: RobotModel,
) -> None:
    simulation, taken = running(model), []
    begun, go_on = threading.Event(), threading.Event()

    def take(new: RobotModel) -> None:
        begun.set()
        assert go_on.wait(60.0)
        taken.append(len(new.things) - len(simulation.model.things))
        simulation.replace_model(new)

    spawning = SpawnQueue(lambda: simulation.model, take)

    def come(text: str, name: str, x: float) -> Future[NewObject]:
        return spawning.add(
            name, lambda: NewObject(thing(text), name, np.array([x, 0, 1]), UPRIGHT)
        )

    first = come(BLOCK, "first", 4.0)
    assert begun.wait(60.0)
    others = [come(BLOCK, f"block{n}", 5.0 + n) for n in range(20)]
    assert spawning.is_pending("first") and spawning.is_pending("block19")
    go_on.set()
    assert all(each.wait(60.0) and each.result() for each in (first, *others))
    assert taken == [1, 20]
    assert len(entities(simulation)) == len(entities(running(model))) + 21

    begun.clear()
    go_on.clear()
    good = [come(SPHERE, "ball", 40.0)]
    assert begun.wait(60.0)
    good += [come(SPHERE, "another", 41.0)]
    wrong = [come("<mujoco><worldbody/></mujoco>", "x", 1.0)]
    wrong += [come(BLOCK, "block3", 42.0)]
    good += [come(SPHERE, "third", 43.0)]
    go_on.set()
    assert all(each.wait(60.0) and each.result() for each in good)
    for each, why in ((wrong[0], "it is empty"), (wrong[1], "There is 'block3'")):
        assert each.wait(60.0)
        with pytest.raises(InvalidDescriptionError, match=why):
            each.result()
    assert {"ball", "another", "third"} <= set(entities(simulation))
    assert taken[2:] == [1, 1, 1]
