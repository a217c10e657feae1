"""``os.environ`` in a Python launch file: that of the place where it stands, in both directions."""

import os

import pytest

from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file
from teleopctl.launch.model.events import ShutdownBegan

INCLUDED = """
import os
from launch import LaunchDescription
from launch.actions import ExecuteProcess, OpaqueFunction

def look(context):
    os.environ["E_FUNCTION"] = os.environ["E_PATH"] + "+"

def generate_launch_description():
    os.environ["E_PATH"] += ":b"
    os.environ["E_FILE"] = os.environ["E_PATH"]
    return LaunchDescription([
        OpaqueFunction(function=look), ExecuteProcess(cmd=["true"], name="inside")
    ])
"""
FILE = """
import os
from launch import LaunchDescription
from launch.actions import *
from launch.event_handlers import OnShutdown

def later(event, context):
    seen = os.environ["E_PATH"], os.environ.get("E_FILE"), context.environment["E_PATH"]
    return LogInfo(msg=" ".join(seen))

def generate_launch_description():
    return LaunchDescription([
        SetEnvironmentVariable("E_PATH", "a"),
        ExecuteProcess(cmd=["true"], name="before"),
        GroupAction([
            IncludeLaunchDescription("included.launch.py"),
            ExecuteProcess(cmd=["true"], name="behind", additional_env={"E_OWN": "1"}),
            RegisterEventHandler(OnShutdown(on_shutdown=later)),
        ], scoped=SCOPED),
        ExecuteProcess(cmd=["true"], name="outside"),
        UnsetEnvironmentVariable("E_PATH"),
        OpaqueFunction(function=lambda context: [LogInfo(msg=str("E_PATH" in os.environ))]),
    ])
"""


@pytest.mark.parametrize("scoped", [True, False])
def test_functions_see_what_was_set_and_what_they_set_reaches_as_far_as_they_do(tmp_path, scoped):
    (tmp_path / "included.launch.py").write_text(INCLUDED)
    path = tmp_path / "file.launch.py"
    path.write_text(FILE.replace("SCOPED", str(scoped)))
    file = read_launch_file(path)
    before = dict(os.environ)
    plan, evaluation = evaluate(file, {}, tmp_path / "log")
    assert dict(os.environ) == before
    environments = {
        process.name.partition("-")[0]: {
            name[2:]: value for name, value in process.environment.items() if name[:2] == "E_"
        }
        for process in plan.processes
    }
    changed = {"PATH": "a:b", "FILE": "a:b", "FUNCTION": "a:b+"}
    assert environments == {
        "before": {"PATH": "a"},
        "inside": changed,
        "behind": {**changed, "OWN": "1"},
        "outside": {"PATH": "a"} if scoped else changed,
    }
    assert [text for _, _, text in plan.start.messages] == ["False"]
    if scoped:
        (message,) = evaluation.handle_event(ShutdownBegan("")).messages
        assert message[2] == "a:b a:b a:b"
        assert dict(os.environ) == before
