"""What ``launch --show-args`` says."""

import pytest

from teleopctl.launch import describe_arguments
from teleopctl.launch.finding import builtin_file


def test_an_argument_is_told_with_its_choices_and_default(tmp_path):
    file = tmp_path / "main.launch.xml"
    file.write_text(
        """
        <launch>
          <arg name="a" description="one"><choice value="x"/><choice value="y"/></arg>
          <arg name="b" description="two." default="x"><choice value="x"/></arg>
          <arg name="c"><choice value="x"/></arg>
          <group><for len="2" name="i"><arg name="d" default="$(var a)/d"/></for></group>
        </launch>
        """,
        encoding="utf-8",
    )
    assert list(describe_arguments(file, {})) == [
        "Arguments (pass arguments as '<name>:=<value>'):",
        "",
        "    'a':",
        "        one. Valid choices are: ['x', 'y']",
        "",
        "    'b':",
        "        two. Valid choices are: ['x']",
        "        (default: 'x')",
        "",
        "    'c':",
        "        One of: ['x']",
        "",
        "    'd':",
        "        no description given",
        "        (default: $(var a)/d)",
    ]


def test_a_description_that_is_given_tells_its_arguments_too(tmp_path):
    file = tmp_path / "main.launch.xml"
    file.write_text('<launch><arg name="model"/></launch>', encoding="utf-8")
    arm = tmp_path / "arm.xacro"
    arm.write_text(
        '<robot xmlns:xacro="x"><xacro:arg name="kind"/><xacro:arg name="tall" default="1.5"/>'
        '<xacro:arg name="model" default="declared by the launch file"/></robot>',
        encoding="utf-8",
    )
    *_, kind, _, tall, default = describe_arguments(file, {"model": str(arm)})
    assert (kind, tall, default) == ("    'kind'", "    'tall'", "        (default: '1.5')")


def test_no_description_is_expanded_to_tell_arguments(tmp_path, monkeypatch):
    from teleopctl import robot

    monkeypatch.setattr(robot, "read_xacro", lambda *_: pytest.fail("it was expanded"))
    file = builtin_file("sim.yaml")
    assert file is not None
    assert "    'controllers_file':" in describe_arguments(file, {})
