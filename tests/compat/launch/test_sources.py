"""Launch files of one language that are included by those of another."""

import pytest
from launch import InvalidLaunchFileError, LaunchContext, LaunchDescriptionSource
from launch.launch_description_sources import (
    AnyLaunchDescriptionSource,
    InvalidPythonLaunchFileError,
    PythonLaunchDescriptionSource,
    get_launch_description_from_python_launch_file,
)

from teleopctl.launch import LaunchRequest, evaluate_request

OUTER = """
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription, LogInfo
from launch.launch_description_sources import *
from launch.substitutions import LaunchConfiguration, ThisLaunchFileDir
from launch_xml.launch_description_sources import XMLLaunchDescriptionSource
from launch_yaml.launch_description_sources import YAMLLaunchDescriptionSource

def generate_launch_description():
    return LaunchDescription([
        IncludeLaunchDescription(
            kind([ThisLaunchFileDir(), "/", name]), launch_arguments=[("word", word)])
        for kind, name, word in (
            (XMLLaunchDescriptionSource, "a.launch.xml", "xml"),
            (YAMLLaunchDescriptionSource, "a.yaml", "yaml"),
            (AnyLaunchDescriptionSource, "a.yaml", "any"),
            (PythonLaunchDescriptionSource, "a.launch.py", "python"),
        )
    ] + [LogInfo(msg=[LaunchConfiguration("word"), LaunchConfiguration("left")])])
"""
INNER = """
from launch import LaunchDescription
from launch.actions import LogInfo, SetLaunchConfiguration
from launch.substitutions import LaunchConfiguration

def generate_launch_description():
    return LaunchDescription(
        [LogInfo(msg=LaunchConfiguration("word")), SetLaunchConfiguration("left", "!")],
        deprecated_reason="it is old")
"""


def test_a_python_launch_file_includes_those_of_every_language(tmp_path):
    (tmp_path / "a.launch.xml").write_text(
        '<launch><log message="$(var word)"/></launch>', encoding="utf-8"
    )
    (tmp_path / "a.yaml").write_text("launch:\n- log: {message: $(var word)}\n", encoding="utf-8")
    (tmp_path / "a.launch.py").write_text(INNER, encoding="utf-8")
    (tmp_path / "outer.launch.py").write_text(OUTER, encoding="utf-8")
    plan, _ = evaluate_request(LaunchRequest(file=str(tmp_path / "outer.launch.py")), tmp_path)
    said = [message for _, _, message in plan.start.messages]
    assert said == [
        *("xml", "yaml", "any"),
        f"launch file [{tmp_path / 'a.launch.py'}] is deprecated: it is old",
        *("python", "python!"),
    ]


def test_a_source_reads_its_file_when_it_is_asked(tmp_path):
    path = tmp_path / "a.launch.py"
    path.write_text(INNER, encoding="utf-8")
    source = PythonLaunchDescriptionSource(str(path))
    description = source.try_get_launch_description_without_context()
    assert description is not None
    assert description.deprecated_reason == "it is old"
    assert source.method == "interpreted python launch file"


def test_what_is_no_launch_file_is_refused(tmp_path):
    path = tmp_path / "a.launch.py"
    path.write_text("", encoding="utf-8")
    with pytest.raises(InvalidPythonLaunchFileError, match="does not contain the required func"):
        get_launch_description_from_python_launch_file(path)
    (tmp_path / "a.yaml").write_text("launch: 1", encoding="utf-8")
    with pytest.raises(InvalidLaunchFileError, match="expected a list of actions"):
        AnyLaunchDescriptionSource(str(tmp_path / "a.yaml")).get_launch_description(LaunchContext())
    with pytest.raises(RuntimeError, match="without launch description being set"):
        LaunchDescriptionSource().get_launch_description(LaunchContext())
