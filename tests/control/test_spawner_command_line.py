"""The spawner's command line."""

import pytest

from teleopctl.control.controller_manager_node import without_node_name
from teleopctl.nodes.spawner import read_command_line


def test_no_name_is_wrong_usage(capsys):
    with pytest.raises(SystemExit) as stopped:
        read_command_line([])
    assert stopped.value.code != 0
    assert "At least one controller name" in capsys.readouterr().err


def test_the_same_file_twice_counts_once():
    _, (request,) = read_command_line(["a", "-p", "x.yaml", "-p", "y.yaml", "-p", "x.yaml"])
    assert request.param_files == ["y.yaml", "x.yaml"]


def test_parameter_files_of_the_spawner_are_the_controllers_as_well():
    _, (a, b) = read_command_line(
        ["a", "-p", "x.yaml", "--controller", "b", "-p", "y.yaml"], ["z.yaml", "x.yaml"]
    )
    assert a.param_files == ["x.yaml", "z.yaml"]
    assert b.param_files == ["x.yaml", "y.yaml", "z.yaml"]


def test_controllers_with_options_of_their_own():
    words = ["a", "-p", "all.yaml", "--controller", "b", "-p", "b.yaml", "--inactive"]
    _, (a, b) = read_command_line(words)
    assert (a.name, a.param_files, a.inactive) == ("a", ["all.yaml"], False)
    assert (b.name, b.param_files, b.inactive) == ("b", ["all.yaml", "b.yaml"], True)


def test_controllers_do_not_inherit_the_name_of_the_managers_node():
    words = ["--ros-args", "-r", "__node:=cm", "-r", "a:=b", "--params-file", "f.yaml"]
    assert without_node_name(words) == ["--ros-args", "-r", "a:=b", "--params-file", "f.yaml"]


def test_one_word_may_hold_several_names_as_a_launch_argument_gives_them():
    _, requests = read_command_line(["a b", "c"])
    assert [request.name for request in requests] == ["a", "b", "c"]


def test_the_options_of_ros_2_before_jazzy_are_known():
    words = ["a", "-t", "x/X", "--stopped", "-n", "/left", "--controller", "b", "-t", "y/Y"]
    options, (a, b) = read_command_line(words)
    assert options.controller_manager == "/left/controller_manager"
    assert (a.type, a.inactive, b.type) == ("x/X", True, "y/Y")
    absolute, _ = read_command_line(["a", "-n", "left", "-c", "/right/manager"])
    assert absolute.controller_manager == "/right/manager"
