"""``teleopctl robot check``: check_urdf's text, what was ignored, and whether it stands."""

import itertools
import json
import sys
from pathlib import Path

import pytest

from teleopctl.cli import main
from tests.sim.robots import box, control, joint, link

INERTIAL = """<inertial><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"""
# A table of four legs' width that stands, and the same on a knife's edge, which does not.
STANDS = box("collision", "0.4 0.4 0.1") + INERTIAL
FALLS = box("collision", "0.02 0.02 1") + INERTIAL.replace("<mass", '<origin xyz="0.1 0 0"/><mass')
ARM = (
    link("world", ""),
    link("base", box("visual", "0.1 0.1 0.1")),
    link("upper"),
    link("tool"),
    joint("weld", "world", "base", kind="fixed"),
    joint("b_shoulder", "base", "upper"),
    joint("a_camera", "base", "tool", kind="fixed"),
    control(b_shoulder="position"),
)


def write(file: Path, *parts: str) -> Path:
    file.write_text(f'<robot name="{file.stem}">{"".join(parts)}</robot>')
    return file


def test_a_file_is_told_as_check_urdf_does_and_then_what_the_simulator_makes_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = '<visual><geometry><mesh filename="package://no_such/x.stl"/></geometry></visual>'
    strange = '<gazebo reference="upper"><kp>1e6</kp></gazebo><sponsor/>'
    file = write(tmp_path / "arm.urdf", *ARM, link("flag", mesh), strange)
    file.write_text(
        file.read_text().replace("</robot>", joint("j", "tool", "flag", kind="fixed") + "</robot>")
    )

    assert main.run(["robot", "check", str(file), "--simulate"]) == 1

    assert capsys.readouterr().out.splitlines() == [
        "robot name is: arm",
        "---------- Successfully Parsed XML ---------------",
        "root Link: world has 1 child(ren)",
        "    child(1):  base",
        "        child(1):  tool",
        "            child(1):  flag",
        "        child(2):  upper",
        "",
        "5 links, 4 joints (3 fixed, 1 revolute)",
        "Mass: 1 kg",
        "Package no_such: not found",
        "Meshes: 0 of 1 found",
        "  not found: package://no_such/x.stl",
        "<ros2_control> hardware (mock_components/GenericSystem):",
        "  b_shoulder: commands position; states position",
        "Guessed or left out:",
        "  The simulator is the hardware of 'hardware' (mock_components/GenericSystem)",
        "  Mesh 'package://no_such/x.stl' is left out: Package 'no_such' not found",
        "  Rotor inertias are assumed, in kg m^2 or kg: b_shoulder 0.02; "
        '<param name="armature"> of a joint in <ros2_control> says one',
        "Without effect:",
        "  <kp> of 'upper' (line 7) has no effect: contacts are as stiff as steps of physics allow",
        "Unknown:",
        "  <sponsor> in <robot> is unknown (line 7)",
        "In simulation it stands",
        "1 of 1 joints follow a command",
    ]


def test_a_folder_becomes_a_table_and_fails_with_the_first_robot_that_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "stands.urdf", link("table", STANDS))
    (tmp_path / "parts.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="m"/></robot>'
    )
    (tmp_path / "package.xml").write_text("<package/>")
    (tmp_path / "ball.xml").write_text(
        '<mujoco><worldbody><body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody>'
        "</mujoco>"
    )
    assert main.run(["robot", "check", str(tmp_path), "-s"]) == 0
    capsys.readouterr()

    write(tmp_path / "falls.urdf", link("knife", FALLS), '<gazebo reference="knife"/>')
    (tmp_path / "broken.urdf").write_text(
        '<robot name="two"><link name="a"/><link name="b"/></robot>'
    )
    assert main.run(["robot", "check", str(tmp_path), "-s", "--json"]) == 1

    reports = {Path(one["file"]).name: one for one in json.loads(capsys.readouterr().out)}
    verdicts = {name: one["trial"] and one["trial"]["verdict"] for name, one in reports.items()}
    assert verdicts == {
        "ball.xml": "stands",
        "broken.urdf": None,
        "falls.urdf": "falls",
        "stands.urdf": "stands",
    }
    file = tmp_path / "broken.urdf"
    assert reports[file.name]["error"] == f"{file}: Two root links found: [a] and [b]"
    assert main.run(["robot", "check", str(tmp_path / "stands.urdf"), str(tmp_path)]) == 1
    table = capsys.readouterr().out.splitlines()
    assert table[0].split() == ["FILE", "PARSES", "COMPILES", "RESULT", "WHY", "NOT"]
    assert table[-1] == "4 of 5 robots are fine"


def test_a_chain_of_links_may_be_longer_than_pythons_stack(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [f"link_{number}" for number in range(450)]
    links = "".join(link(name, "") for name in names)
    joints = "".join(joint(two, one, two, kind="fixed") for one, two in itertools.pairwise(names))
    file = write(tmp_path / "chain.urdf", links, joints)
    main.run(["robot", "check", str(file)])  # with all that it imports
    usual = sys.getrecursionlimit()
    sys.setrecursionlimit(400)
    try:
        main.run(["robot", "check", str(file)])
    finally:
        sys.setrecursionlimit(usual)
    assert capsys.readouterr().out.count("450 links, 449 joints") == 2


def test_what_is_absurd_is_told_in_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("teleopctl.mujoco_model.mesh_content._LARGEST", 600)
    (tmp_path / "large.stl").write_bytes(bytes(684))
    mesh = f'<collision><geometry><mesh filename="{tmp_path}/large.stl"/></geometry></collision>'
    said = {
        link("base", mesh + INERTIAL): "large.stl has 0.0 GB; at most 0 GB are read",
        link(
            "base", STANDS.replace('ixx="', 'ixx="-')
        ): "-0.01, 0.01, 0.01, which must be positive",
        link("base", STANDS)
        + link("tip", box("collision", "1e20 1 1"))
        + joint("j", "base", "tip"): "MuJoCo: Inertia matrix",
        link("base", STANDS)
        + link("tip", STANDS)
        + joint("j", "base", "tip", limit='lower="1" upper="-1" effort="-5" velocity="2"'): "are "
        "ignored: lower 1 is above upper -1\n  Joint 'j': effort -5 is taken as 5",
    }
    for number, (content, words) in enumerate(said.items()):
        main.run(["robot", "check", str(write(tmp_path / f"robot{number}.urdf", content))])
        assert words in capsys.readouterr().out
