"""Compiled models are kept in the cache, and pairs of links that touch always are found."""

import os
from pathlib import Path

import mujoco
import numpy as np
import pytest

from teleopctl.kinematics import ClearanceChecker, KinematicModel, compiled
from teleopctl.robot import RobotDescription, read_world_text
from tests.kinematics.arms import SIX, THREE, arm_urdf

CUBE = """v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 {height}
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""
WITH_MESH = """<robot name="one"><link name="base"><collision><geometry>
<mesh filename="{file}"/></geometry></collision></link></robot>"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(compiled, "cache_dir", lambda: str(tmp_path / "cache"))
    return tmp_path / "cache" / "kinematics"


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the robots that were compiled."""
    names: list[str] = []
    build = compiled.build_compiled

    def counted(description: RobotDescription, *others: object) -> compiled.CompiledModel:
        names.append(description.name)
        return build(description, *others)  # type: ignore[arg-type]

    monkeypatch.setattr(compiled, "build_compiled", counted)
    return names


def model_of(urdf: str) -> KinematicModel:
    return KinematicModel(RobotDescription.from_urdf(urdf))


def test_a_model_is_compiled_once_and_is_the_same_from_the_cache(cache, built):
    first, second = model_of(arm_urdf(SIX)), model_of(arm_urdf(SIX))
    assert built == ["arm"]
    assert len(list(cache.iterdir())) == 1
    assert second.links == first.links
    assert second.warnings == first.warnings
    for model in (first, second):
        model.set_positions({"joint_2": 0.4, "joint_5": -0.3})
    np.testing.assert_array_equal(second.pose("tool0"), first.pose("tool0"))


def test_another_description_or_file_is_another_model(cache, built, tmp_path):
    mesh = tmp_path / "part.obj"
    for time_s, height in enumerate(("0.1", "0.25")):
        mesh.write_text(CUBE.format(height=height))
        # MuJoCo keeps meshes by the second of their change.
        os.utime(mesh, (time_s, time_s))
        model = model_of(WITH_MESH.format(file=mesh))
        corners = model.mj_model.mesh_vert
        longest = np.linalg.norm(corners[:, None] - corners, axis=2).max()
        assert longest == pytest.approx(np.hypot(0.1, float(height)), rel=1e-4)
    model_of(WITH_MESH.format(file=mesh))
    assert built == ["one", "one"]


def test_a_world_is_part_of_the_model(cache, built):
    sdf = """<sdf version="1.9"><world name="w"><model name="box"><static>true</static>
    <pose>{x} 0 0.5 0 0 0</pose><link name="l"><collision name="c"><geometry><box>
    <size>0.1 0.1 0.1</size></box></geometry></collision></link></model></world></sdf>"""
    description = RobotDescription.from_urdf(arm_urdf(THREE))
    for x in (1.0, 2.0, 1.0):
        world = read_world_text(sdf.format(x=x), "box.sdf")
        model = KinematicModel(description, world)
        assert x in model.mj_model.body_pos[:, 0]
    assert built == ["arm", "arm"]


def test_a_damaged_file_is_written_again(cache, built):
    model_of(arm_urdf(THREE))
    (file,) = cache.iterdir()
    whole = file.read_bytes()
    for damaged in (
        whole[:-50],
        whole[: len(whole) // 2] + b"x" + whole[len(whole) // 2 + 1 :],
        b"",
    ):
        file.write_bytes(damaged)
        model_of(arm_urdf(THREE))
        assert file.read_bytes() == whole
    assert len(built) == 4


def test_the_models_used_longest_ago_are_removed(cache, monkeypatch):
    monkeypatch.setattr(compiled, "_MOST_KEPT", 2)
    for number, name in enumerate(("a", "b", "c")):
        model_of(arm_urdf(THREE, name=name))
        for file in cache.iterdir():
            if file.stat().st_mtime > 1_000:
                os.utime(file, (number, number))
    assert len(list(cache.iterdir())) == 2


def test_a_cache_that_cannot_be_written_costs_time_only(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(compiled, "cache_dir", lambda: str(tmp_path / "file"))
    assert model_of(arm_urdf(THREE)).links["tool0"] > 0


def test_what_is_only_drawn_is_left_out(cache):
    drawn = """<link name="flag"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
    <joint name="f" type="fixed"><parent link="tool0"/><child link="flag"/></joint>"""
    model = model_of(arm_urdf(THREE, extra=drawn))
    assert model.mj_model.ngeom == len(THREE)
    assert "flag" in model.links


def test_bodies_are_added_to_a_model_from_the_cache(cache):
    def add(spec: mujoco.MjSpec) -> None:
        spec.worldbody.add_geom(
            name="wall", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.1, 0.1], pos=[0, 0, 0.7]
        )

    model_of(arm_urdf(THREE))
    changed = model_of(arm_urdf(THREE)).with_changes(add)
    changed.set_positions({})
    assert [one.bodies for one in ClearanceChecker(changed).collisions()]


# The plate of the second link, wide as a hull of a mesh may be, is in the last link's way whatever
# the joints do.
PLATE = """<link name="plate"><collision><geometry><sphere radius="0.5"/></geometry></collision>
</link><joint name="p" type="revolute"><parent link="link_1"/><child link="plate"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>"""


def test_links_that_touch_at_nearly_all_positions_may_touch_with_one_warning(cache):
    for _ in ("compiled", "from the cache"):
        model = model_of(arm_urdf(THREE, extra=PLATE.replace('radius="0.5"', 'radius="0.31"')))
        always = [each for each in model.warnings if "touch at nearly all" in each]
        assert len(always) == len(model.touching)
        checker = ClearanceChecker(model)
        assert set(model.touching) <= checker.allowed
        model.set_positions({"joint_2": 0.3, "joint_3": 0.4})
        assert not {one.bodies for one in checker.collisions()} & set(model.touching)
