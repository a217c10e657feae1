"""Launch files that take any robot: its arguments, its hardware, its controllers."""

import json
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from teleopctl.errors import TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.finding import builtin_file
from teleopctl.launch.frontends.yaml_file import parse_file
from teleopctl.launch.model.plan import LaunchPlan
from teleopctl.launch.model.request import LaunchRequest
from teleopctl.node import find_parameter_line

XACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="head">
  <xacro:arg name="joint" default="pan"/>
  <link name="base"/><link name="face"/>
  <joint name="$(arg joint)" type="revolute"><parent link="base"/><child link="face"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <ros2_control name="Real" type="system">
    <hardware><plugin>vendor/Driver</plugin></hardware>
    <joint name="$(arg joint)"><command_interface name="position"/>
      <state_interface name="position"/></joint>
  </ros2_control>
  {more}
</robot>"""


class Evaluated(NamedTuple):
    """A plan, and what a substitution stands for in it."""

    plan: LaunchPlan
    shown: str

    @property
    def said(self) -> list[str]:
        return [text for _, _, text in self.plan.start.messages]


@pytest.fixture
def evaluated(tmp_path):
    def evaluated(value, more="", **arguments):
        (tmp_path / "head.xacro").write_text(XACRO.replace("{more}", more))
        text = f'launch:\n- let:\n    name: shown\n    value: "{value}"\n'
        file = tmp_path / "main.yaml"
        file.write_text(text.replace("FILE", str(tmp_path / "head.xacro")))
        plan, evaluation = evaluate(
            parse_file(file), arguments, tmp_path / "log", LaunchRequest(file=str(file))
        )
        return Evaluated(plan, evaluation.context.scope.variables["shown"])

    return evaluated


def test_the_controllers_file_of_hardware_has_the_values_of_its_variables(tmp_path):
    (tmp_path / "head.xacro").write_text(XACRO.replace("{more}", ""))
    (tmp_path / "some.yaml").write_text("$(var side)_arm: {ros__parameters: {type: a/A}}\n")
    file = builtin_file("controller.yaml")
    assert file is not None
    arguments = {
        "model": str(tmp_path / "head.xacro"),
        "controllers_file": str(tmp_path / "some.yaml"),
        "side": "left",
        "hardware": "mock",
    }
    plan, _ = evaluate(parse_file(file), arguments, tmp_path / "log", LaunchRequest(file=str(file)))
    (spawner,) = (
        process.command for process in plan.start.processes if "spawner" in process.command
    )
    assert "left_arm" in spawner


def test_a_manager_that_a_plug_in_calls_otherwise_is_told(evaluated, tmp_path):
    (tmp_path / "c.yaml").write_text("{}")
    plugin = (
        '<gazebo><plugin filename="gz_ros2_control-system" name="p">'
        "<controller_manager_name>boss</controller_manager_name></plugin></gazebo>"
    )
    done = evaluated(f"$(with-plugins FILE sim {tmp_path / 'c.yaml'})", plugin)
    assert any("<controller_manager_name>boss" in text for text in done.said)


def test_launch_arguments_that_the_description_takes_are_handed_over_and_known(evaluated):
    done = evaluated("$(robot FILE)", joint="tilt", nonsense="1")
    assert '<joint name="tilt" type="revolute">' in done.shown
    assert [warning.partition(" is not")[0] for warning in done.plan.warnings] == [
        "launch argument 'nonsense'"
    ]


def test_what_the_launch_file_says_itself_comes_first(evaluated):
    done = evaluated("$(robot FILE joint:=roll)", joint="tilt")
    assert '<joint name="roll" type="revolute">' in done.shown


def test_the_arguments_are_listed_for_who_expands_the_file_again(evaluated):
    done = evaluated("$(robot-arguments FILE hardware:=sim)", joint="tilt")
    assert json.loads(done.shown) == ["joint:=tilt", "hardware:=sim"]


def test_an_argument_that_is_missing_is_named_with_all_that_there_are(evaluated):
    with pytest.raises(TeleopctlError, match="Undefined substitution argument kind") as caught:
        evaluated("$(robot FILE)", more='<link name="$(arg kind)"/>')
    assert caught.value.hint == "It takes kind, joint (pan); give them as name:=value"


def test_the_simulator_is_the_hardware_unless_the_description_is_to_decide(evaluated):
    done = evaluated("$(simulated-robot FILE sim)")
    assert "vendor/Driver" not in done.shown
    assert done.said == [
        "The simulator is the hardware of 'Real' (vendor/Driver); "
        "hardware:=as_described takes the description's own"
    ]
    done = evaluated("$(simulated-robot FILE as_described)")
    assert "vendor/Driver" in done.shown
    assert done.said == []


def test_the_controllers_are_those_that_the_description_names(evaluated, tmp_path):
    (tmp_path / "c.yaml").write_text("arm: {ros__parameters: {type: a/A}}")
    plug_in = (
        '<gazebo><plugin name="c" filename="libgz_ros2_control-system.so">'
        f"<parameters>{tmp_path}/c.yaml</parameters></plugin></gazebo>"
    )
    done = evaluated("$(robot-controllers FILE sim other.yaml)", more=plug_in)
    assert done.shown == str(tmp_path / "c.yaml")
    assert done.said == [f"Controllers of the description: {tmp_path}/c.yaml"]
    with pytest.raises(TeleopctlError, match=r"gone/c.yaml is not a file"):
        evaluated("$(robot-controllers FILE sim '')", more=plug_in.replace(str(tmp_path), "/gone"))


def test_where_the_file_that_is_named_configures_none_they_are_made_beside_what_it_says(
    evaluated, tmp_path
):
    (tmp_path / "c.yaml").write_text("controller_manager: {ros__parameters: {update_rate: 7}}")
    plug_in = (
        '<gazebo><plugin name="c" filename="libgz_ros2_control-system.so">'
        f"<parameters>{tmp_path}/c.yaml</parameters></plugin></gazebo>"
    )
    done = evaluated("$(robot-controllers FILE sim '')", more=plug_in)
    assert done.said == [f"{tmp_path}/c.yaml configures none: those of {done.shown}"]
    listed = evaluated(f"$(file-controllers {done.shown} '')").shown.split()
    assert listed == ["joint_state_broadcaster", "joint_trajectory_controller"]
    rate = evaluated(f"$(file-param {done.shown} /controller_manager update_rate 1)").shown
    assert rate == "7"


def test_the_controllers_of_plugins_come_behind_those_of_the_file(evaluated, tmp_path):
    (tmp_path / "c.yaml").write_text("controller_manager: {ros__parameters: {update_rate: 7}}\n")
    value = f"$(with-plugins FILE sim {tmp_path}/c.yaml)"
    assert evaluated(value).shown == f"{tmp_path}/c.yaml"
    plug_in = (
        '<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so">'
        "<left_joint>pan</left_joint><right_joint>pan</right_joint></plugin></gazebo>"
    )
    done = evaluated(value, more=plug_in)
    (said,) = done.said
    assert "is the controller 'd' (diff_drive_controller/DiffDriveController)" in said
    rate = evaluated(f"$(file-param {done.shown} controller_manager update_rate 100)")
    assert rate.shown == "7"
    assert evaluated(f"$(file-controllers {done.shown})").shown == "d"


PREFIXED = """# of $(nobody)
arm:
  ros__parameters: {joints: [$(var joint), $(var tool)]}
"""


def test_variables_of_the_controllers_file_are_arguments_of_the_launch_and_of_the_robot(
    evaluated, tmp_path
):
    (tmp_path / "c.yaml").write_text(PREFIXED)
    value = f"$(with-plugins FILE sim {tmp_path}/c.yaml)"
    done = evaluated(value, tool="hook")
    joints = yaml.safe_load(Path(done.shown).read_text())["arm"]["ros__parameters"]["joints"]
    assert joints == ["pan", "hook"], "by default of the description, and as given"
    assert done.plan.warnings == []
    done = evaluated(value, tool="hook", joint="tilt")
    assert "[tilt, hook]" in Path(done.shown).read_text()
    # Messages about the copy that the launch writes name the user's file.
    assert find_parameter_line([done.shown], "/arm", "joints") == f"{tmp_path}/c.yaml:3"


def test_a_variable_of_the_controllers_file_without_a_value_is_named_with_its_line(
    evaluated, tmp_path
):
    (tmp_path / "c.yaml").write_text(PREFIXED)
    with pytest.raises(TeleopctlError, match=r"\$\(var tool\): neither") as caught:
        evaluated(f"$(with-plugins FILE sim {tmp_path}/c.yaml)")
    assert caught.value.place == f"{tmp_path}/c.yaml:3"
    assert caught.value.hint == "Give it after the launch file: tool:=VALUE"


@pytest.mark.parametrize(
    ("plug_in", "sections", "namespace"),
    [
        ("", "controller_manager", ""),
        ("", "/left/controller_manager", "/left"),
        ("left", "/left/controller_manager", "/left"),
        ("/left", "/**/controller_manager", "/left"),
        ("left", "/**", "/left"),
        ("left", "controller_manager", ""),
        ("left", "/right/controller_manager", "/right"),
    ],
)
def test_controllers_run_where_the_plugin_says_and_the_file_has_something_for(
    evaluated, tmp_path, plug_in, sections, namespace
):
    (tmp_path / "c.yaml").write_text(
        f"{sections}: {{ros__parameters: {{arm: {{type: x/Y}}}}}}\n"
        f"{sections.removesuffix('controller_manager').rstrip('/*')}/own:"
        " {ros__parameters: {type: x/Z}}\n"
    )
    more = (
        '<gazebo><plugin name="c" filename="libgz_ros2_control-system.so">'
        f"<ros><namespace>{plug_in}</namespace></ros></plugin></gazebo>"
    )
    done = evaluated(f"$(robot-namespace FILE sim {tmp_path}/c.yaml)", more=more)
    assert done.shown == namespace
    assert bool(done.said) == bool(plug_in or namespace), "what is not plain is said"
    listed = evaluated(f"$(file-controllers {tmp_path}/c.yaml '{namespace}')").shown.split()
    assert listed == (["arm", "own"] if "**" not in sections else ["arm"])


def test_a_robot_of_which_nothing_moves_comes_up_without_controllers(tmp_path):
    (tmp_path / "box.urdf").write_text('<robot name="box"><link name="base"/></robot>')
    file = builtin_file("sim.yaml")
    assert file is not None
    arguments = {"model": str(tmp_path / "box.urdf"), "camera": "false", "viewer": "false"}
    plan, _ = evaluate(parse_file(file), arguments, tmp_path / "log", LaunchRequest(file=str(file)))
    names = [process.name.rpartition("-")[0] for process in plan.start.processes]
    assert names == ["mujoco_sim", "robot_state_publisher"]
    assert sum("Nothing to control" in text for _, _, text in plan.start.messages) == 1


def test_what_only_looks_on_gives_way_to_the_simulators_start(tmp_path):
    (tmp_path / "box.urdf").write_text('<robot name="box"><link name="base"/></robot>')
    file = builtin_file("sim.yaml")
    assert file is not None
    arguments = {"model": str(tmp_path / "box.urdf"), "viewer": "true", "motion": "true"}
    plan, _ = evaluate(parse_file(file), arguments, tmp_path / "log", LaunchRequest(file=str(file)))
    gives_way = {process.name.rpartition("-")[0]: process.gives_way for process in plan.processes}
    assert gives_way == {
        **dict.fromkeys(("mujoco_sim", "robot_state_publisher"), False),
        **dict.fromkeys(("camera", "move_group", "servo_node", "rviz2"), True),
    }
    assert [process.name for process in plan.processes if process.simulates] == ["mujoco_sim-1"]


def test_where_none_are_named_they_are_the_launch_files_or_made_for_the_joints(evaluated):
    assert evaluated("$(robot-controllers FILE sim other.yaml)").shown == "other.yaml"
    done = evaluated("$(robot-controllers FILE sim '')")
    parameters = yaml.safe_load(Path(done.shown).read_text())
    trajectory = parameters["/**/joint_trajectory_controller"]["ros__parameters"]
    assert trajectory["joints"] == ["pan"]
    assert done.said == [f"No controllers_file is given or described: those of {done.shown}"]


RENAMED = (
    '<gazebo><plugin name="c" filename="libgz_ros2_control-system.so"><ros>'
    "<remapping>~/odom:=odom</remapping><remapping>/tf:=tf</remapping>"
    "<remapping>joint_states:=platform/joint_states</remapping>"
    "<remapping>robot_description:=urdf</remapping><remapping>__ns:=/a</remapping>"
    "<remapping>odom</remapping></ros></plugin></gazebo>"
)


def test_controllers_get_the_remappings_of_the_plugin_that_would_run_them(evaluated):
    done = evaluated("$(robot-remappings FILE sim '')", more=RENAMED)
    assert done.shown == "-r '~/odom:=odom' -r joint_states:=platform/joint_states"
    *in_vain, obeyed = done.said
    assert obeyed.endswith("controllers: ~/odom:=odom, joint_states:=platform/joint_states")
    assert [said.partition("</")[0] for said in in_vain] == [
        "<remapping>robot_description:=urdf",
        "<remapping>__ns:=/a",
        "<remapping>odom",
    ]
    below = evaluated("$(robot-remappings FILE sim /left)", more=RENAMED)
    assert "-r /tf:=tf" in below.shown, "which is another topic there"


def test_nodes_elsewhere_find_what_controllers_were_told_to_call_otherwise(evaluated):
    names = "joint_states /tf /tf_static"
    done = evaluated(f"$(robot-remappings FILE sim /left {names})", more=RENAMED)
    assert done.shown == (
        "-r /left/joint_states:=/left/platform/joint_states "
        "-r /joint_states:=/left/platform/joint_states -r /tf:=/left/tf"
    )
    assert not done.said, "it has been said by who asked for all"
    assert not evaluated(f"$(robot-remappings FILE sim '' {names})").shown


def test_in_simulation_the_nodes_of_a_robot_get_them(tmp_path):
    (tmp_path / "head.xacro").write_text(XACRO.replace("{more}", RENAMED))
    file = builtin_file("sim.yaml")
    assert file is not None
    arguments = {
        "model": str(tmp_path / "head.xacro"),
        "camera": "false",
        "viewer": "true",
        "control": "topic",
    }
    plan, _ = evaluate(parse_file(file), arguments, tmp_path / "log", LaunchRequest(file=str(file)))
    rules = {
        process.name.rpartition("-")[0]: [word for word in process.command if ":=" in word]
        for process in plan.start.processes
    }
    assert "~/odom:=odom" in rules["ros2_control_node"]
    # In the simulator's process, the manager alone has these rules.
    arguments["control"] = "process"
    plan, _ = evaluate(parse_file(file), arguments, tmp_path / "log", LaunchRequest(file=str(file)))
    command = plan.start.processes[0].command
    (hosted,) = [word for word in command if word.startswith("--controller-manager=")]
    assert "~/odom:=odom" in hosted
    assert "~/odom:=odom" not in command
    assert "/joint_states:=/platform/joint_states" in rules["robot_state_publisher"]
    assert rules["rviz2"].index("/joint_states:=/platform/joint_states") < rules["rviz2"].index(
        "/joint_states:=/joint_states"
    ), "the first one counts"


def test_controllers_come_after_those_that_they_command(evaluated, tmp_path):
    manager = {
        name: {"type": kind}
        for name, kind in {
            "base": "diff_drive_controller/DiffDriveController",
            "left": "pid_controller/PidController",
            "other": "x/Y",
            "right": "pid_controller/PidController",
            "states": "joint_state_broadcaster/JointStateBroadcaster",
        }.items()
    }
    base = {"left_wheel_names": ["left/wheel"], "right_wheel_names": ["right/wheel"]}
    sections = {
        "controller_manager": {"ros__parameters": manager},
        "base": {"ros__parameters": base},
    }
    file = tmp_path / "c.yaml"
    file.write_text(json.dumps(sections))
    listed = evaluated(f"$(file-controllers {file})").shown.split()
    assert listed == ["states", "left", "right", "other", "base"]
    sections["left"] = {"ros__parameters": {"interfaces": ["base/linear/velocity"]}}
    file.write_text(json.dumps(sections))
    listed = evaluated(f"$(file-controllers {file})").shown.split()
    assert sorted(listed[1:]) == ["base", "left", "other", "right"]


def test_a_terminal_shows_what_pick_and_place_has_taken_and_little_of_the_others(tmp_path):
    file = builtin_file("pick_and_place.yaml")
    assert file is not None
    plan, _ = evaluate(
        parse_file(file),
        {"episodes": str(tmp_path / "cube")},
        tmp_path / "log",
        LaunchRequest(file=str(file)),
    )
    shown = {process.name.rpartition("-")[0] for process in plan.processes if not process.is_quiet}
    assert shown == {"pick_and_place", "episode_recorder"}
