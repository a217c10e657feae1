"""A Python launch file's ``Node``: the command line and the parameters that it becomes."""

import textwrap

import pytest
import yaml

from teleopctl.errors import NotFoundError, TeleopctlError
from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.request import LaunchRequest

HEAD = """
from pathlib import Path
from typing import List
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import (
    Node, PushRosNamespace, SetParameter, SetParametersFromFile, SetRemap, SetUseSimTime
)
from launch_ros.descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare

def camera(**kwargs):
    return Node(package="camera", executable="camera", **kwargs)

def generate_launch_description():
    return LaunchDescription([
"""


@pytest.fixture
def plan(tmp_path):
    def plan(entities, **arguments):
        path = tmp_path / "file.launch.py"
        path.write_text(HEAD + textwrap.indent(entities, " " * 8) + "\n    ])\n", encoding="utf-8")
        request = LaunchRequest(file=str(path), skip_missing=arguments.pop("skip_missing", False))
        return evaluate(read_launch_file(path), arguments, tmp_path / "log", request)[0]

    return plan


def ros_words(process):
    words = process.command[process.command.index("--ros-args") + 1 :]
    return [word for word in words if word != "-r"]


@pytest.fixture
def parameters(plan):
    """The parameters of a node, from the text of the mapping in the launch file."""

    def parameters(mapping, **arguments):
        (content,) = plan(f"camera(parameters=[{mapping}])", **arguments).start.files.values()
        return yaml.safe_load(content)["/**"]["ros__parameters"]

    return parameters


def test_name_namespace_arguments_and_remappings_become_words(plan):
    (process,) = plan(
        "camera(name='eye', namespace=['left', '_side'], arguments=['a b', '--c'],\n"
        "       remappings=[('image', '/seen')], ros_arguments=['--log-level', 'debug'])"
    ).processes
    assert process.name == "camera-1"
    assert process.command[5:8] == ["camera", "a b", "--c"]
    assert ros_words(process) == [
        "--log-level",
        "debug",
        "__node:=eye",
        "__ns:=/left_side",
        "image:=/seen",
    ]


def test_values_have_the_types_that_python_gives_them(parameters):
    assert parameters(
        "{'i': 1, 'f': 2.5, 'b': True, 's': '12', 'l': ['1', 'a'], 'n': [1, 2.5]}"
    ) == {
        "i": 1,
        "f": 2.5,
        "b": True,
        "s": "12",
        "l": ["1", "a"],
        "n": [1.0, 2.5],
    }


def test_what_substitutions_give_is_read_as_yaml_does_unless_a_type_is_demanded(parameters):
    assert parameters(
        "{'rate': LaunchConfiguration('x'),\n"
        " 'text': ParameterValue(LaunchConfiguration('x'), value_type=str),\n"
        " 'joined': ['a', LaunchConfiguration('x')],\n"
        " 'list': [[LaunchConfiguration('x')], ['3']],\n"
        " 'numbers': ParameterValue(LaunchConfiguration('y'), value_type=List[float])}",
        x="12",
        y="[1, 2]",
    ) == {"rate": 12, "text": "12", "joined": "a12", "list": [12, 3], "numbers": [1.0, 2.0]}


def test_mappings_in_mappings_are_dotted_names(parameters):
    assert parameters("{'a': {'b': {LaunchConfiguration('x'): 1}}, 'c': 2}", x="z") == {
        "a.b.z": 1,
        "c": 2,
    }


def test_files_and_mappings_keep_their_order(plan, tmp_path):
    (tmp_path / "p.yaml").write_text("{}")
    (process,) = plan(
        f"camera(parameters=[{{'a': 1}}, Path({str(tmp_path / 'p.yaml')!r}), {{'a': 2}}])"
    ).processes
    files = [word for word in ros_words(process) if word != "--params-file"]
    assert [file.rpartition("/")[2] for file in files] == [
        "camera-1-parameters.yaml",
        "p.yaml",
        "camera-1-parameters-2.yaml",
    ]


def test_substitutions_in_a_parameter_file_are_evaluated_where_that_is_allowed(plan, tmp_path):
    file = tmp_path / "p.yaml"
    file.write_text("/**: {ros__parameters: {who: $(var who)}}")
    (content,) = plan(
        f"camera(parameters=[ParameterFile({str(file)!r}, allow_substs=True)])", who="Ada"
    ).start.files.values()
    assert content == "/**: {ros__parameters: {who: Ada}}"


def test_a_parameter_file_that_is_missing_is_a_warning_as_in_ros2(plan):
    result = plan("camera(parameters=['/nowhere.yaml'])")
    assert result.start.messages == [
        ("WARNING", "camera-1", "Parameter file path is not a file: /nowhere.yaml")
    ]
    assert "--params-file" not in result.processes[0].command


def test_what_a_group_sets_ends_with_it(plan):
    inside, behind = plan(
        "GroupAction([PushRosNamespace('arm'), SetRemap('a', 'b'), SetParameter('x', 1),\n"
        "             camera(namespace='left')]), camera()"
    ).processes
    assert ros_words(inside)[0] == "__ns:=/arm/left"
    assert "a:=b" in inside.command
    assert "--ros-args" not in behind.command


@pytest.mark.parametrize(
    ("entity", "message"),
    [
        ("camera(parameters={'a': 1})", "Expecting list of parameters, got {'a': 1}"),
        ("camera(parameters=[{'a': None}])", "parameter 'a': None is no value of a parameter"),
        ("Node(package='camera', executable='camra')", "No executable found"),
        ("Node(package='nowhere', executable='x')", "Package 'nowhere' not found"),
        ("Node(package='camera')", "the keyword argument 'executable' is missing"),
        ("camera(parameters=[{'a': ParameterValue(1, value_type=dict)}])", "none of the types"),
    ],
)
def test_a_mistake_is_told_with_file_and_line(plan, entity, message):
    with pytest.raises(TeleopctlError) as caught:
        plan(entity)
    assert "file.launch.py:" in caught.value.message
    assert message in caught.value.message


def test_the_spellings_of_old_releases_are_understood_with_a_warning(plan):
    with pytest.warns(UserWarning, match="'node_executable' is deprecated, use 'executable'"):
        (process,) = plan("Node(package='camera', node_executable='camera')").processes
    assert process.name == "camera-1"


def test_a_file_sees_what_a_sourced_ros2_sets(plan, monkeypatch):
    for name in ("ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    (process,) = plan(
        "camera(arguments=[__import__('os').environ['ROS_DISTRO'],\n"
        "                  FindPackageShare('teleopctl').find('teleopctl')])"
    ).processes
    assert process.command[6] == "jazzy"
    assert process.command[7].endswith("teleopctl")


def test_a_package_that_python_asks_for_in_an_included_file_can_be_left_out(plan, tmp_path):
    included = tmp_path / "inner.launch.py"
    included.write_text(
        "from ament_index_python.packages import get_package_share_directory\n"
        "def generate_launch_description():\n"
        "    get_package_share_directory('nowhere')\n"
    )
    entities = (
        f"__import__('launch').actions.IncludeLaunchDescription(\n    {str(included)!r}), camera()"
    )
    with pytest.raises(NotFoundError, match=r"inner\.launch\.py:3: .*'nowhere'"):
        plan(entities)
    result = plan(entities, skip_missing=True)
    assert [process.name for process in result.processes] == ["camera-1"]
    ((level, _, message),) = result.start.messages
    assert level == "WARNING"
    assert message.startswith("left out: ")


@pytest.mark.parametrize("skips", [False, True])
def test_a_spawner_goes_on_past_controllers_that_are_missing_as_programs_may_be(plan, skips):
    spawner = (
        'Node(package="controller_manager", executable="spawner", arguments=["a", "--ros-args"])'
    )
    (process,) = plan(spawner, skip_missing=skips).processes
    words = process.command[process.command.index("spawner") + 1 :]
    assert words == [*(["--keep-going"] if skips else []), "a", "--ros-args"]


def test_import_launch_ros_alone_reaches_all_its_parts():
    import launch_ros

    assert launch_ros.events.matches_node_name
    assert launch_ros.event_handlers.OnStateTransition
