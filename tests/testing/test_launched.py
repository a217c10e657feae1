import re
import sys

import pytest

from teleopctl.base import background
from teleopctl.base.background import ProcessRecord, StartTime
from teleopctl.launch.execution import status
from teleopctl.launch.execution.running import died
from teleopctl.launch.execution.status import ProcessStatus
from teleopctl.testing import LaunchedSystem, RosGraph

TALKER = """
launch:
- arg: {name: name, default: simple_publisher}
- node: {pkg: teleop_py_pkg, exec: simple_publisher, name: $(var name)}
"""


@pytest.fixture
def talker(ros_graph, ros_launch) -> LaunchedSystem:
    (ros_graph.folder / "talker.yaml").write_text(TALKER)
    launched: LaunchedSystem = ros_launch("talker.yaml", "name:=parrot")
    return launched


def test_a_launch_file_is_up_when_the_call_returns_and_its_lines_are_waited_for(talker, ros_graph):
    assert talker.is_running
    assert ros_graph.run("node list").stdout.splitlines() == ["/parrot"]
    talker.wait_for_line(r"\[simple_publisher-1\].*Publishing at ([\d.]+) Hz")


def test_it_is_taken_down_in_the_middle_of_a_test(talker, ros_graph):
    talker.stop()
    assert not talker.is_running
    assert ros_graph.run("node list").stdout == ""
    with pytest.raises(AssertionError, match="no line matches 'never'") as failure:
        talker.wait_for_line("never")
    assert "process started" in str(failure.value)
    talker.stop()


def test_what_dies_fails_with_its_last_words(ros_graph, ros_launch):
    (ros_graph.folder / "dies.py").write_text("raise SystemExit('my last words')")
    # A node beside it, which is waited for: what is no node is up as soon as it runs.
    (ros_graph.folder / "dies.yaml").write_text(
        f"{TALKER}- executable: {{cmd: {sys.executable} dies.py}}\n"
    )
    with pytest.raises(AssertionError, match="exit status 1") as failure:
        ros_launch("dies.yaml")
    assert "my last words" in str(failure.value)


def test_what_has_done_its_work_is_no_failure(ros_graph, ros_launch):
    (ros_graph.folder / "works.yaml").write_text(
        f"launch:\n- executable: {{cmd: {sys.executable} -c print(7)}}\n"
    )
    launched = ros_launch("works.yaml")
    assert launched.wait_for_line(r"\] (\d)$")[1] == "7"
    launched.stop()


def test_a_launch_that_ends_while_it_is_looked_for_is_one_launch(tmp_path, monkeypatch):
    request = tmp_path / "request.json"
    record = ProcessRecord(
        "short",
        7,
        StartTime(),
        ("launch", str(request)),
        tmp_path / "log",
        "launch",
        tmp_path / "7",
    )
    dead = ProcessStatus(
        *(
            "talker-1",
            8,
            StartTime(),
            "died",
            1,
            0.0,
            "talker.log",
            ["talker"],
            "/talker",
            True,
            False,
        )
    )
    status.write(tmp_path, [dead], 0)
    # It runs when it is asked for what runs, and no longer when it is asked for what has ended.
    monkeypatch.setattr(background, "records", lambda _=None: [record])
    monkeypatch.setattr(background, "ended_records", lambda _=None: [record])
    assert RosGraph(tmp_path)._launches() == [record]
    assert [entry.record.name for entry in died(tmp_path)] == ["talker-1"]


@pytest.mark.nightly
def test_the_report_of_a_failure_has_the_output_of_all_that_ran(ros_graph):
    (ros_graph.folder / "talker.yaml").write_text(TALKER)
    (ros_graph.folder / "test_fails.py").write_text(
        "def test_that_fails(ros_graph, ros_launch):\n"
        f"    ros_launch({str(ros_graph.folder / 'talker.yaml')!r}).wait_for_line('Publishing')\n"
        "    ros_graph.spawn('run no_such_package no_such_node').wait()\n"
        "    ros_graph.run('topic type /no_such_topic')\n"
        "    assert False\n"
    )
    ros_graph.env["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    done = ros_graph.run_module(
        "pytest", "-p teleopctl.testing.pytest_plugin test_fails.py", timeout=60
    )
    assert done.returncode == 1, done.stdout
    for part in (
        r"--- ROS graph: process \d+ ---",
        "no_such_package",
        r"--- ROS graph: last command -+\n.* topic type /no_such_topic\n",
        r"--- ROS graph: router-.*\.log ---|--- ROS graph: talker-.*\.log ---",
        r"\[simple_publisher-1\].*Publishing at 1.0 Hz",
    ):
        assert re.search(part, done.stdout), f"{part} is not in\n{done.stdout}"
