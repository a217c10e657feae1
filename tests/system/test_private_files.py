"""Files of a launch: who may read them, and what is left of one that is killed."""

import json
import os
import signal
import stat
import sys

import psutil
import pytest

from teleopctl.testing import eventually

if sys.platform == "win32":
    pytest.skip("files have no modes there", allow_module_level=True)

LAUNCH_FILE = """
from tempfile import NamedTemporaryFile
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile

def generate_launch_description():
    with NamedTemporaryFile("w", suffix=".yaml", delete=False) as file:
        file.write("{/**: {ros__parameters: {secret: s3cret}}}")
    return LaunchDescription([
        Node(package="demo_nodes_py", executable="talker", parameters=[
            {"key": "s3cret"}, file.name, ParameterFile(file.name, allow_substs=True)]),
        # More lines than a small log holds.
        ExecuteProcess(cmd=["seq", "2000"]),
    ])
"""


@pytest.fixture
def launch_file(ros):
    (ros.folder / "talk.launch.py").write_text(LAUNCH_FILE)
    (ros.folder / "tmp").mkdir()
    ros.env["TMPDIR"] = str(ros.folder / "tmp")
    return ros.folder / "talk.launch.py"


def files_below(folder):
    return [path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()]


def killed(process):
    """Kill a process and all that it has started, the starters first."""
    members = [psutil.Process(process), *psutil.Process(process).children(recursive=True)]
    for member in members:
        member.send_signal(signal.SIGKILL)
    psutil.wait_procs(members)


def open_to_others(folder):
    return [path for path in files_below(folder) if stat.S_IMODE(path.stat().st_mode) & 0o077]


def test_logs_parameters_and_progress_are_the_users_alone(ros, launch_file):
    ros.env["TELEOPCTL_LOG_BYTES"] = "4096"
    before = os.umask(0)
    try:
        assert ros.run(["launch", "--detach", str(launch_file)], 60).returncode == 0
        done = ros.run(["run", "--detach", "demo_nodes_py", "talker"], 60)
    finally:
        os.umask(before)
    assert done.returncode == 0, done.stderr
    logs = ros.folder / "log"
    eventually(lambda: any(path.name.endswith(".log.1") for path in files_below(logs)))
    written = files_below(logs)
    for kind in (".log", ".log.1", ".progress", ".yaml", ".json"):
        assert any(path.name.endswith(kind) for path in written), kind
    assert open_to_others(logs) == []
    assert open_to_others(ros.folder / "runtime") == []


@pytest.mark.parametrize("detached", [True, False])
def test_a_launch_that_is_killed_leaves_nothing_among_temporary_files(ros, launch_file, detached):
    if detached:
        assert ros.run(["launch", "--detach", str(launch_file)], 60).returncode == 0
        (pid,) = (record["pid"] for record in records(ros) if record["kind"] == "launch")
    else:
        process = ros.spawn(["launch", str(launch_file)])
        process.wait_for_line("Publishing")
        pid = process.pid
    (temporary,) = (ros.folder / "runtime" / "temporary").iterdir()
    assert files_below(temporary)
    killed(pid)
    assert list((ros.folder / "tmp").iterdir()) == []
    # What it had among the records goes when it is forgotten, or with the next launch.
    eventually(lambda: ros.run("ps").returncode == 0 and not temporary.exists())


def records(ros):
    return [json.loads(f.read_text()) for f in (ros.folder / "runtime/processes").glob("*.json")]
