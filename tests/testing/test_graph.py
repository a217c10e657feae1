import os
import re
import sys
from pathlib import Path

import pytest

from teleopctl.base import background
from teleopctl.testing import LONGEST_WAIT_S, Process, RosGraph, eventually

SLEEPER = [sys.executable, "-c", "import time; time.sleep(600)"]

HOSTILE_TESTS = """
import os, sys
import pytest
from teleopctl.base import background

SLEEPER = [sys.executable, "-c", "import time; time.sleep(600)"]

def test_that_removes_the_variable(ros_graph, monkeypatch):
    record = background.start("mine", SLEEPER, kind="node")
    print(f"started <{record.pid}>")
    monkeypatch.delenv("TELEOPCTL_RUNTIME_DIR")

def test_that_removes_it_for_good_and_fails(ros_graph):
    record = background.start("mine", SLEEPER, kind="node")
    print(f"started <{record.pid}>")
    del os.environ["TELEOPCTL_RUNTIME_DIR"]
    raise SystemExit("in the middle")
"""


@pytest.fixture
def users_process(tmp_path, monkeypatch):
    """A background process in the folder that counts when no variable names one."""
    (tmp_path / "user").mkdir(mode=0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "user"))
    monkeypatch.delenv("TELEOPCTL_RUNTIME_DIR")
    record = background.start("router of the user", SLEEPER, kind="router")
    assert record.file is not None
    assert record.file.is_relative_to(tmp_path / "user")
    yield record
    background.stop(record)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no variable moves the folder")
def test_whatever_a_test_does_to_the_variables_the_users_processes_live_on(users_process, tmp_path):
    (tmp_path / "test_hostile.py").write_text(HOSTILE_TESTS)
    # As it is where the package is installed, and where it is only on the path.
    env = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    plugin = ["-p", "teleopctl.testing.pytest_plugin"]
    argv = [sys.executable, "-m", "pytest", "-sq", *plugin, "test_hostile.py"]
    session = Process(argv, env, tmp_path)
    session.wait(60)
    started = [int(pid) for pid in re.findall(r"started <(\d+)>", session.stdout)]
    assert "1 failed, 1 passed" in session.stdout, session.report()
    assert len(started) == 2
    assert background.is_alive(users_process)
    assert background.records() == [users_process]
    assert [pid for pid in started if Path(f"/proc/{pid}").exists()] == []


def test_a_graph_takes_this_process_in_and_gives_it_back(tmp_path):
    before = dict(os.environ)
    with RosGraph(tmp_path) as graph:
        assert os.environ["TELEOPCTL_ROUTER"] == graph.router
        assert background.runtime_dir() == tmp_path / "runtime"
        (router,) = background.records()
        os.environ["ROS_DOMAIN_ID"] = "7"
    assert dict(os.environ) == before
    assert not background.is_alive(router)


def test_a_port_that_was_taken_meanwhile_is_replaced(tmp_path, monkeypatch):
    with RosGraph(tmp_path / "first") as first:
        second = RosGraph(tmp_path / "second")
        second._use_port(first.port)
        second.join(os.environ)
        try:
            record = second.start_router()
            assert second.port != first.port
            assert record.command[-1] == second.router == second.env["TELEOPCTL_ROUTER"]
            assert os.environ["TELEOPCTL_ROUTER"] == second.router
        finally:
            second.close()


def test_graphs_of_one_router_see_nothing_of_each_other(tmp_path):
    owner, first, second = (RosGraph(tmp_path / name) for name in ("owner", "first", "second"))
    try:
        for graph in (first, second):
            graph.folder.mkdir()
            graph.share_router(owner)
        assert first.router == second.router == owner.router
        talker = first.spawn("run teleop_py_pkg simple_publisher")
        talker.wait_for_line("Publishing")
        assert first.run("node list").stdout == "/simple_publisher\n"
        assert second.run("node list").stdout == ""
    finally:
        for graph in (first, second, owner):
            graph.close()


def test_a_shared_router_that_died_is_started_again_for_the_next_graph(tmp_path):
    owner, first, second = (RosGraph(tmp_path / name) for name in ("owner", "first", "second"))
    try:
        first.share_router(owner)
        (router,) = background.records(owner.folder / "runtime")
        background.stop(router)
        second.share_router(owner)
        assert len(background.records(owner.folder / "runtime")) == 1
        assert second.domain != first.domain
    finally:
        owner.close()


def test_what_an_ended_launch_left_is_ended_too(ros):
    (ros.folder / "waits.yaml").write_text(
        f"launch:\n- executable: {{cmd: '{sys.executable} -c \"import time; time.sleep(600)\"'}}\n"
    )
    assert ros.run("launch -d waits.yaml").returncode == 0
    launch = next(r for r in background.records() if r.kind == background.LAUNCH)
    (pid,) = [int(line) for line in _children(launch.pid)]
    os.kill(launch.pid, 9)
    eventually(lambda: not background.is_alive(launch), what="the end of the launch")
    ros.close()
    eventually(lambda: not Path(f"/proc/{pid}").exists(), what="the end of what it started")


def test_a_line_is_waited_for_and_the_next_wait_begins_behind_it(ros_without_router):
    program = ros_without_router.spawn_command(
        [sys.executable, "-c", "print('one 1'); print('one 2'); import sys; sys.exit(3)"]
    )
    assert program.wait_for_line(r"one (\d)")[1] == "1"
    assert program.wait_for_line(r"one (\d)")[1] == "2"
    assert program.wait() == 3


def test_a_line_that_does_not_come_fails_with_the_whole_output(ros_without_router):
    code = "import sys; print('to stdout'); sys.stderr.write('to stderr'); sys.exit(3)"
    program = ros_without_router.spawn_command([sys.executable, "-c", code])
    with pytest.raises(AssertionError) as failure:
        program.wait_for_line("never")
    text = str(failure.value)
    assert "no line matches 'never'" in text
    assert "stdout: to stdout" in text
    assert "stderr: to stderr" in text
    assert "status: 3" in text


def test_what_never_happens_is_named():
    with pytest.raises(AssertionError, match=r"rain did not happen within 0\.02 s"):
        eventually(lambda: False, 0.02, "rain")
    assert LONGEST_WAIT_S > 1


def test_a_session_without_these_fixtures_imports_nothing_of_teleopctl():
    code = "import sys; import teleopctl.testing.pytest_plugin\n"
    code += "print([m for m in sys.modules if m.startswith('teleopctl')])"
    process = Process([sys.executable, "-c", code], os.environ, Path.cwd())
    assert process.wait() == 0
    ground = {"teleopctl", "teleopctl.base", "teleopctl.base.lazy", "teleopctl.base.typed"}
    assert set(eval(process.stdout)) == {
        *ground,
        "teleopctl.testing",
        "teleopctl.testing.pytest_plugin",
    }


def _children(pid):
    return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()


def test_a_graph_keeps_the_folder_by_which_all_that_runs_in_it_is_found(tmp_path, monkeypatch):
    with pytest.raises(AttributeError, match="folder"):
        monkeypatch.setattr(RosGraph(tmp_path), "folder", tmp_path / "another")
