"""What ``launch --show-args`` says."""

from teleopctl.launch import describe_arguments


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
