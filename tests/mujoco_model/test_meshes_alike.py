"""A mesh file is whole, repaired or refused for the page and for physics alike, in one sentence."""

from pathlib import Path

import pytest
import trimesh

from teleopctl.mujoco_model import build_model
from teleopctl.robot import RobotDescription
from teleopctl.viewer.scene.assets import MeshError, load_mesh

ROBOT = """
<robot name="r"><link name="world"/><link name="part">
  <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><mesh filename="{}"/></geometry></collision>
</link><joint name="j" type="fixed"><parent link="world"/><child link="part"/></joint></robot>
"""
BOX = trimesh.creation.box((1, 2, 3))
POINTER = "version https://git-lfs.github.com/spec/v1"
OBJ = trimesh.exchange.obj.export_obj(BOX)


def said_by_physics(file: Path) -> list[str]:
    built = build_model(RobotDescription.from_urdf(ROBOT.format(file)))
    return [line for line in built.warnings if str(file) in line]


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("box.obj", OBJ, ""),
        (
            "one_bad_corner.obj",
            OBJ + "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 9 10 11\n",
            "has coordinates that are not numbers; 1 triangle is left out",
        ),
        (
            "bad.obj",
            "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "has coordinates that are not numbers",
        ),
        ("corners.obj", "v 0 0 0\n", "holds no triangles"),
        ("empty.ply", "", "cannot be read"),
        ("part.step", "ISO-10303-21;", "is of an unsupported format: .dae"),
        (
            "pointer.dae",
            "version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 3\n",
            "LFS",
        ),
    ],
)
def test_both_say_the_same_of_a_file(
    tmp_path: Path, name: str, content: str, sentence: str
) -> None:
    file = tmp_path / name
    file.write_text(content)
    try:
        shown = list(load_mesh(str(file)).faults)
    except MeshError as error:
        shown = [error.message]
    acts = said_by_physics(file)
    if not sentence:
        assert shown == acts == []
        return
    assert sentence in shown[0]
    assert len(acts) == 1
    # Both begin with what they do about it; from the file's name on the words are the same.
    assert shown[0].partition(str(file))[2] == acts[0].rpartition(str(file))[2]


def test_a_repaired_mesh_has_the_same_triangles_for_both(tmp_path: Path) -> None:
    file = tmp_path / "one_bad_corner.obj"
    file.write_text(OBJ + "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 9 10 11\n")
    shown = load_mesh(str(file), bare=True)
    built = build_model(RobotDescription.from_urdf(ROBOT.format(file)))
    assert shown.faces is not None
    assert len(shown.faces) == len(BOX.faces)
    assert built.mj_model.nmeshface == len(BOX.faces)
