"""One small Python launch file for each construct that no other test has."""

import textwrap

import pytest

from teleopctl.launch.evaluation.evaluation import evaluate
from teleopctl.launch.frontends import read_launch_file

HEAD = """
from launch import *
from launch.actions import *
from launch.conditions import *
from launch.descriptions import Executable
from launch.event_handlers import *
from launch.events import matches_action
from launch.events.process import *
from launch.launch_description_sources import *
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.substitutions import *

def entry(name):
    return [LogInfo(msg=["is ", name])]
"""
BODY = """
def generate_launch_description():
    return LaunchDescription([
{}
    ])
"""


@pytest.fixture
def launch(tmp_path, monkeypatch):
    """What a launch file says and starts, of whose list the entries are given."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", "")

    def launch(entries, head=""):
        path = tmp_path / "file.launch.py"
        body = BODY.format(textwrap.indent(textwrap.dedent(entries).strip(), " " * 8))
        path.write_text(HEAD + textwrap.dedent(head) + body, encoding="utf-8")
        plan, _ = evaluate(read_launch_file(path), {}, tmp_path / "log")
        said = [text for _, _, text in plan.start.messages]
        return said, plan.start.processes

    return launch


def test_a_for_loop_counts(launch):
    said, _ = launch("""
        DeclareLaunchArgument("number", default_value="2"),
        ForLoop(LaunchConfiguration("number"), function=lambda i: [
            LogInfo(msg=["loop ", str(i)])]),
    """)
    assert said == ["loop 0", "loop 1"]


def test_a_for_each_loop_gives_the_values_of_each_entry(launch):
    said, _ = launch("""
        DeclareLaunchArgument("robots", default_value="{name: 'a', id: 1};{name: 'b', id: 2}"),
        ForEach(LaunchConfiguration("robots"), function=lambda name, id: [
            LogInfo(msg=[name, " ", str(id)])]),
    """)
    assert said == ["a 1", "b 2"]


def test_a_local_process_has_a_description_of_its_own(launch):
    _, (process,) = launch("""
        ExecuteLocal(process_description=Executable(
            cmd=["echo", TextSubstitution(text="hi")], name="mouth", prefix="nice",
            additional_env={"WORD": "1"})),
    """)
    assert (process.name, process.command) == ("mouth-1", ["nice", "echo", "hi"])
    assert process.environment["WORD"] == "1"


@pytest.mark.parametrize("name", ["PushRosNamespace", "PushROSNamespace"])
def test_a_namespace_has_both_spellings(launch, name):
    _, (process,) = launch(f"""
        {name}("left"), {name}("hand"),
        Node(package="tf2_ros", executable="tf2_echo", name="echo", arguments=["a", "b"]),
    """)
    assert process.node_name == "/left/hand/echo"


def test_programs_and_folders_of_packages_are_substitutions(launch, tmp_path):
    package = tmp_path / "arm"
    (package / "scripts").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>arm</name></package>")
    (package / "CMakeLists.txt").write_text("install(PROGRAMS scripts/wave DESTINATION lib/arm)")
    (package / "scripts" / "wave").write_text("#!/bin/sh\n")
    said, _ = launch("""
        LogInfo(msg=ExecutableInPackage("wave", "arm")),
        LogInfo(msg=[FindPackagePrefix("arm"), "/share/arm"]),
        LogInfo(msg=FindPackageShare("arm")),
        LogInfo(msg=LaunchLogDir()),
    """)
    wave, prefix, share, log = said
    assert wave.endswith("/wave")
    assert (tmp_path / prefix / "package.xml").resolve() == package / "package.xml"
    assert (tmp_path / share / "package.xml").resolve() == package / "package.xml"
    assert log == str(tmp_path / "log")


def test_a_file_of_any_language_is_a_source(launch, tmp_path):
    (tmp_path / "in.launch.xml").write_text("<launch><log message='xml'/></launch>")
    (tmp_path / "in.launch.yaml").write_text("launch:\n- log: {message: yaml}\n")
    (tmp_path / "in.launch.py").write_text(
        HEAD + BODY.format("        LogInfo(msg='python')"), encoding="utf-8"
    )
    said, _ = launch("""
        IncludeLaunchDescription(FrontendLaunchDescriptionSource("in.launch.xml")),
        IncludeLaunchDescription(FrontendLaunchDescriptionSource("in.launch.yaml")),
        IncludeLaunchDescription(AnyLaunchDescriptionSource("in.launch.py")),
        IncludeLaunchDescription(AnyLaunchDescriptionSource(
            [TextSubstitution(text="in.launch"), ".xml"])),
    """)
    assert said == ["xml", "yaml", "python", "xml"]


EVENTS = """
import sys

def runs(name, code="pass"):
    return ExecuteProcess(cmd=[sys.executable, "-c", code], name=name)

STAYS = "import time; print('here', flush=True); time.sleep(600)"
stays, other = runs("stays", STAYS), runs("other", STAYS)
quick, last = runs("quick"), runs("last")
never = OnProcessExit(target_action=quick, on_exit=[LogInfo(msg="never")])

def ends(matcher):
    return EmitEvent(event=ShutdownProcess(process_matcher=matcher))
"""
ENTRIES = """
RegisterEventHandler(never),
UnregisterEventHandler(never),
RegisterEventHandler(OnProcessIO(target_action=stays, on_stdout=lambda event: other)),
RegisterEventHandler(OnProcessIO(target_action=other, on_stdout=lambda event: quick)),
RegisterEventHandler(OnProcessExit(
    target_action=quick, on_exit=[LogInfo(msg="quick"), ends(matches_name("stays-1"))])),
RegisterEventHandler(OnProcessExit(
    target_action=stays, on_exit=[LogInfo(msg="stays"), ends(matches_executable(sys.executable))])),
RegisterEventHandler(OnProcessExit(
    target_action=other, on_exit=[ROSTimer(period=0.01, actions=[LogInfo(msg="timer"), last])])),
RegisterEventHandler(OnProcessStart(
    target_action=last, on_start=lambda event, context: LogInfo(msg=f"pid {event.pid > 0}"))),
stays,
"""


def test_processes_are_ended_by_name_and_by_program(ros_without_router):
    ros = ros_without_router
    body = BODY.format(textwrap.indent(ENTRIES.strip(), " " * 8))
    (ros.folder / "file.launch.py").write_text(HEAD + EVENTS + body, encoding="utf-8")
    done = ros.run("launch file.launch.py")
    said = [line.rpartition(": ")[2] for line in done.stdout.splitlines() if "launch.user" in line]
    assert said == ["quick", "stays", "timer", "pid True"], done.stdout + done.stderr
    assert done.returncode == 0
