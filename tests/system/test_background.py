"""``--detach``, ``ps``, ``logs`` and ``stop``."""

import json
import re
import sys

import psutil
import pytest

from teleopctl.testing import eventually
from tests.samples import sample

TWO_NODES = """launch:
- node: {pkg: teleop_py_pkg, exec: simple_publisher, name: mouth}
- node: {pkg: teleop_py_pkg, exec: simple_subscriber, respawn: true}
"""


@pytest.fixture
def ros(ros_with_own_router):
    """A graph whose router is among the processes of its background."""
    return ros_with_own_router


def processes(ros):
    return {entry["name"]: entry for entry in json.loads(ros.run("ps --json").stdout)}


def runs(pid):
    """Whether a process lives; one that nobody has reaped yet does not."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def test_a_detached_node_is_up_when_the_command_returns(ros):
    started = ros.run("run -d simple_publisher")
    assert started.returncode == 0, started.stderr
    assert started.stdout.startswith("simple_publisher is up: /simple_publisher [pid ")
    assert "/simple_publisher" in ros.run("node list").stdout
    entry = processes(ros)["simple_publisher"]
    assert entry["kind"] == "node"
    assert runs(entry["pid"])
    assert "Publishing at 1.0 Hz" in ros.run("logs simple_publisher").stdout
    stopped = ros.run("stop simple_publisher")
    assert (stopped.returncode, stopped.stdout) == (0, "simple_publisher has been stopped\n")
    assert "simple_publisher" not in processes(ros)
    assert ros.run("node list").stdout == ""
    # The log is there for who wants to know what was.
    assert "Publishing at 1.0 Hz" in ros.run("logs simple_publisher").stdout


def test_a_detached_node_that_dies_is_reported_with_the_end_of_its_log(ros):
    (ros.folder / "dies.py").write_text("print('my last words')\nraise SystemExit(3)\n")
    result = ros.run("run -d ./dies.py")
    assert result.returncode == 1
    assert "my last words" in result.stderr


def test_a_detached_program_that_does_its_work_and_ends_is_no_failure(ros):
    (ros.folder / "works.py").write_text("print('done')\n")
    result = ros.run("run -d ./works.py")
    assert (result.returncode, result.stdout) == (0, "works has finished\n"), result.stderr


@pytest.mark.parametrize(
    ("line", "name", "waited_for"),
    [("run -d ./waits.py", "waits", "waits"), ("launch -d waits.yaml", "waits", "spawner-2")],
)
def test_ctrl_c_takes_back_what_is_still_starting(ros, line, name, waited_for):
    (ros.folder / "waits.py").write_text("import time\ntime.sleep(600)\n")
    (ros.folder / "waits.yaml").write_text(
        "launch:\n"
        "- node: {pkg: teleop_py_pkg, exec: simple_publisher}\n"
        "- node: {pkg: controller_manager, exec: spawner, args: none_such}\n"
    )
    command = ros.spawn(line)
    eventually(lambda: waited_for in processes(ros))
    pids = [entry["pid"] for entry in processes(ros).values() if entry["kind"] != "router"]
    command.interrupt()
    assert command.wait() == 130
    assert command.stderr.endswith(f"{name} has been stopped\n")
    assert not any(runs(pid) for pid in pids)
    assert list(processes(ros)) == ["router"]


DEADLOCK = """
import threading
print('last words', flush=True)
lock = threading.Lock()
lock.acquire()
lock.acquire()
"""
WORKS_UNTIL_TOLD = """
import pathlib, time
while not pathlib.Path('go').exists():
    end_s = time.process_time() + 0.01
    while time.process_time() < end_s:
        pass
    time.sleep(0.03)
import rclpy
rclpy.init()
rclpy.spin(rclpy.create_node('late'))
"""


def test_a_program_that_hangs_is_given_up_after_the_time_without_progress(ros):
    (ros.folder / "hangs.py").write_text(DEADLOCK)
    result = ros.run("run -d --stall-timeout 2 ./hangs.py")
    assert (result.returncode, result.stdout) == (1, "")
    assert (
        "No progress for 2 s: hangs (its node has not appeared in the graph)\n  last words"
        in result.stderr
    )
    assert "`--stall-timeout`" in result.stderr
    assert processes(ros)["hangs"]["ending"] is None


def test_a_program_that_spins_is_given_up_after_the_time_in_all(ros):
    (ros.folder / "spins.py").write_text("while True:\n    pass\n")
    result = ros.run("run -d --stall-timeout 1 --timeout 1.3 ./spins.py")
    assert (result.returncode, result.stdout) == (1, "")
    assert "Not up within 1.3 s: spins (its node has not appeared in the graph)" in result.stderr


def test_a_program_that_works_is_waited_for_and_shown(ros):
    (ros.folder / "late.py").write_text(WORKS_UNTIL_TOLD)
    process = ros.spawn("run -d --stall-timeout 2 ./late.py")
    process.wait_for_line(r"Starting: late \(its node has not appeared in the graph\)")
    (ros.folder / "go").touch()
    assert process.wait() == 0, process.report()
    assert process.stdout.startswith("late is up: /late [pid ")


def test_what_each_process_of_a_launch_does_or_waits_for_is_said(ros):
    (ros.folder / "waits.yaml").write_text(
        "launch:\n"
        "- node: {pkg: teleop_py_pkg, exec: simple_publisher}\n"
        "- node: {pkg: controller_manager, exec: spawner, args: none_such}\n"
    )
    result = ros.run("launch -d --stall-timeout 4 waits.yaml")
    assert result.returncode == 1
    waits = "spawner-2 (waiting for /controller_manager)"
    assert f"Starting: {waits}\n" in result.stderr
    assert f"No progress for 4 s: {waits}\n" in result.stderr
    assert "simple_publisher-1 is up" in result.stdout


@pytest.mark.parametrize(
    ("line", "mistake"),
    sample(
        [
            ("run --timeout 3 simple_publisher", "--timeout needs --detach"),
            ("launch --stall-timeout 3 sim.yaml", "--stall-timeout needs --detach"),
            ("launch -d --timeout 0 sim.yaml", "--timeout is 0, expected a number above 0"),
            ("run -d --stall-timeout -1 simple_publisher", "--stall-timeout is -1, expected"),
        ],
        4,
    ),
)
def test_bounds_of_a_wait_that_mean_nothing_are_refused(ros, line, mistake):
    result = ros.run(line)
    assert (result.returncode, result.stdout) == (2, "")
    assert mistake in result.stderr


def test_a_detached_launch_that_starts_nothing_is_done_at_once(ros):
    (ros.folder / "says.yaml").write_text("launch:\n- log: {message: hello}\n")
    result = ros.run("launch -d says.yaml")
    assert (result.returncode, result.stdout) == (0, "says has finished\n"), result.stderr
    assert "[INFO] [launch.user]: hello" in ros.run("logs says").stdout


@pytest.mark.nightly
def test_two_of_a_name_are_told_apart(ros):
    ros.run("run -d simple_publisher")
    second = ros.run("run -d simple_publisher --ros-args -r __node:=two")
    assert second.stdout.startswith("simple_publisher-2 is up: /two")


def test_a_detached_launch_is_up_when_the_command_returns_and_its_nodes_are_listed(ros):
    (ros.folder / "two.launch.yaml").write_text(TWO_NODES)
    started = ros.run("launch -d two.launch.yaml")
    assert started.returncode == 0, started.stderr
    assert "simple_publisher-1 is up: /mouth [pid " in started.stdout
    assert ros.run("node list").stdout == "/mouth\n/simple_subscriber\n"
    listed = processes(ros)
    assert listed["two"]["kind"] == "launch"
    assert listed["simple_publisher-1"]["launch"] == "two"
    assert listed["simple_publisher-1"]["node"] == "/mouth"
    lines = ros.run("ps").stdout.splitlines()
    assert lines[0].split() == ["NAME", "PID", "KIND", "UPTIME", "COMMAND"]
    (publisher,) = [line for line in lines if line.startswith("  simple_publisher-1 ")]
    assert " teleopctl.nodes teleop_py_pkg simple_publisher --ros-args " in publisher
    # It is up before what it prints has come through its pipe.
    eventually(lambda: "[mouth]" in ros.run("logs mouth").stdout)
    for name in ("simple_publisher-1", "two/simple_publisher-1", "mouth", "/mouth"):
        assert "[mouth]: Publishing at 1.0 Hz" in ros.run(["logs", name]).stdout
    assert "[INFO] [simple_publisher-1]: process started with pid" in ros.run("logs two").stdout

    # One that was stopped stays stopped, even where it would be started again.
    assert ros.run("stop simple_subscriber-2").returncode == 0
    eventually(lambda: ros.run("node list").stdout == "/mouth\n")
    eventually(lambda: "process has finished cleanly" in ros.run("logs two").stdout)
    assert "simple_subscriber-2" not in processes(ros)

    pids = [processes(ros)[name]["pid"] for name in ("two", "simple_publisher-1")]
    assert ros.run("stop two").stdout == "two has been stopped\n"
    assert not any(runs(pid) for pid in pids)


@pytest.mark.nightly
def test_what_a_killed_launch_leaves_behind_is_listed_and_can_be_stopped(ros):
    (ros.folder / "two.yaml").write_text(TWO_NODES)
    assert ros.run("launch -d two.yaml").returncode == 0
    listed = processes(ros)
    left = listed["simple_publisher-1"]["pid"]
    psutil.Process(listed["two"]["pid"]).kill()
    eventually(lambda: "two" not in processes(ros))
    assert processes(ros)["simple_publisher-1"]["pid"] == left
    # Nobody reads its output any more: it goes on, in its log.
    before = ros.run("logs simple_subscriber-2").stdout
    eventually(lambda: len(ros.run("logs simple_subscriber-2").stdout) > len(before))
    assert "simple_publisher-1 has been stopped" in ros.run("stop --yes").stdout
    assert not runs(left)
    assert list(processes(ros)) == ["router"]


def test_what_a_killed_launch_in_the_foreground_leaves_behind_can_be_stopped(ros):
    (ros.folder / "two.yaml").write_text(TWO_NODES)
    launch = ros.spawn("launch two.yaml")
    launch.wait_for_line("Publishing")
    # As long as somebody watches it, it is not in the background.
    assert list(processes(ros)) == ["router"]
    psutil.Process(launch.pid).kill()
    eventually(
        lambda: list(processes(ros)) == ["router", "simple_publisher-1", "simple_subscriber-2"]
    )
    left = [entry["pid"] for name, entry in processes(ros).items() if name != "router"]
    told = ros.run("stop --yes")
    assert "simple_publisher-1 has been stopped" in told.stdout
    assert told.stderr == ""
    assert not any(runs(pid) for pid in left)
    assert list(processes(ros)) == ["router"]
    assert "No background processes" in ros.run("stop --yes").stderr


ONCE = """launch:
- node: {pkg: teleop_py_pkg, exec: simple_publisher, name: mouth}
- shutdown: {if: $(node-exists /mouth), reason: It runs already}
"""


def test_a_launch_that_is_refused_says_how_to_end_the_first_and_leaves_its_log_alone(ros):
    (ros.folder / "once.yaml").write_text(ONCE)
    first = ros.spawn("launch once.yaml")
    first.wait_for_line("Publishing")
    latest = (ros.folder / "log" / "latest").resolve()
    before = sorted((ros.folder / "log").iterdir())
    end = f"`kill -INT {first.pid}`, since it has no terminal"
    for line in ("launch once.yaml", "launch -d once.yaml"):
        second = ros.run(line)
        assert (second.returncode, second.stdout) == (1, "")
        assert second.stderr.endswith(f"It runs already\n  End it with {end}.\n")
    assert sorted((ros.folder / "log").iterdir()) == before
    assert (ros.folder / "log" / "latest").resolve() == latest
    for name in ("once", "simple_publisher-1", "mouth"):
        assert "Publishing" in ros.run(["logs", name]).stdout
    # In the foreground it is not for `stop`, which says what ends it.
    assert f"once runs in the foreground. End it with {end}." in ros.run("stop once").stderr

    shown = ros.run("launch --print once.yaml")
    assert shown.returncode == 0
    assert shown.stdout.startswith("simple_publisher-1:\n")
    assert shown.stdout.endswith("the launch ends: It runs already\n")

    first.interrupt()
    first.wait()
    assert ros.run("launch -d once.yaml").returncode == 0
    second = ros.run("launch -d once.yaml").stderr
    assert second.endswith("It runs already\n  End it with `teleopctl stop once`.\n")


def test_what_a_launch_file_printed_before_it_was_refused_is_kept(ros):
    (ros.folder / "prints.launch.py").write_text(
        "print('my own words')\n\ndef generate_launch_description():\n    raise ValueError('no')\n"
    )
    assert "no" in ros.run("launch -d prints.launch.py").stderr
    assert "my own words" in ros.run("logs prints").stdout


@pytest.mark.nightly
def test_a_launch_in_the_foreground_that_ends_leaves_no_record(ros):
    (ros.folder / "two.yaml").write_text(TWO_NODES)
    launch = ros.spawn("launch two.yaml")
    launch.wait_for_line("Publishing")
    folder = ros.folder / "runtime" / "processes"
    before = set(folder.iterdir())
    assert any(file.stem == str(launch.pid) for file in before)
    launch.interrupt()
    launch.wait()
    assert {file.stem for file in before - set(folder.iterdir())} == {str(launch.pid)}


def test_a_detached_launch_with_a_node_that_dies_fails_and_says_why(ros):
    (ros.folder / "dies.yaml").write_text(
        "launch:\n"
        "- node: {pkg: teleop_py_pkg, exec: simple_publisher}\n"
        "- executable: {cmd: \"sh -c 'echo my last words; exit 3'\"}\n"
    )
    result = ros.run("launch -d dies.yaml")
    assert result.returncode == 1
    assert "sh-2 died with exit code 3" in result.stderr
    assert "my last words" in result.stderr
    told = ros.run("stop --yes").stderr
    assert "dies/sh-2 exited 3" in told
    assert "my last words" not in told


def test_a_detached_launch_whose_programs_end_at_once_is_not_said_to_be_up(ros):
    (ros.folder / "fails.py").write_text("raise SystemExit('my last words')\n")
    (ros.folder / "fails.yaml").write_text(
        f"launch:\n- executable: {{cmd: '{sys.executable} fails.py'}}\n"
    )
    result = ros.run("launch -d fails.yaml")
    assert (result.returncode, result.stdout) == (1, "")
    assert "died with exit code 1:\n  my last words" in result.stderr
    (ros.folder / "works.yaml").write_text(
        f"launch:\n- executable: {{cmd: '{sys.executable} -c pass', name: works}}\n"
    )
    result = ros.run("launch -d works.yaml")
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "works has finished"
    assert "is up" not in result.stdout


def test_logs_follow_one_that_begins_anew_and_show_both_its_parts(ros):
    (ros.folder / "counts.py").write_text(
        "import itertools, rclpy\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('counts')\n"
        "numbers = itertools.count()\n"
        "node.create_timer(0.001, lambda: print(next(numbers), flush=True))\n"
        "rclpy.spin(node)\n"
    )
    ros.env["TELEOPCTL_LOG_BYTES"] = "10000"
    assert ros.run("run -d ./counts.py").returncode == 0
    follower = ros.spawn("logs -f counts")
    follower.wait_for_line("^2500$")  # two parts have 10 kB, which is about 2000 numbers
    assert ros.run("stop counts").returncode == 0
    assert follower.wait() == 0
    received = [int(line) for line in follower.stdout.split()]
    kept = [int(line) for line in ros.run("logs counts").stdout.split()]
    assert received == list(range(received[0], received[-1] + 1))
    assert kept == list(range(kept[0], received[-1] + 1))
    assert kept[0] > 0
    (older,) = (ros.folder / "log").glob("counts-*.log.1")
    assert older.read_text().startswith(f"{kept[0]}\n")


def test_a_node_that_dies_later_is_seen_until_stop_has_told_of_it(ros):
    (ros.folder / "dies.py").write_text(
        "import rclpy\n"
        "from std_msgs.msg import String\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('dies')\n"
        "def die(message):\n"
        "    raise RuntimeError('my last words')\n"
        "node.create_subscription(String, 'die', die, 10)\n"
        "rclpy.spin(node)\n"
    )
    assert ros.run("run -d ./dies.py").returncode == 0
    assert processes(ros)["dies"]["ending"] is None
    ros.run("topic pub --once -w 1 /die std_msgs/msg/String")
    eventually(lambda: processes(ros)["dies"]["ending"] is not None)
    assert re.search(r"^dies +\d+ +node +exited 1, \d+ s ago ", ros.run("ps").stdout, re.MULTILINE)
    told = ros.run("stop dies")
    assert told.returncode == 0
    assert re.search(r"^WARNING: dies exited 1, \d+ s ago; its last lines:$", told.stderr, re.M)
    assert told.stderr.endswith("  RuntimeError: my last words\n")
    assert "dies" not in processes(ros)


@pytest.mark.nightly
def test_a_process_of_a_launch_that_is_killed_later_is_seen_with_its_signal(ros):
    (ros.folder / "two.yaml").write_text(TWO_NODES.replace(", respawn: true", ""))
    assert ros.run("launch -d two.yaml").returncode == 0
    psutil.Process(processes(ros)["simple_publisher-1"]["pid"]).kill()
    eventually(lambda: processes(ros)["simple_publisher-1"]["ending"] is not None)
    lines = ros.run("ps").stdout.splitlines()
    assert any(re.match(r"  simple_publisher-1 .* killed by SIGKILL, \d+ s ago ", x) for x in lines)
    psutil.Process(processes(ros)["simple_subscriber-2"]["pid"]).kill()
    # The launch has ended with its processes, and they are still told of.
    eventually(lambda: "two" not in processes(ros))
    told = ros.run("stop --yes").stderr
    assert "WARNING: two/simple_publisher-1 killed by SIGKILL" in told
    assert "Publishing at 1.0 Hz" in told
    assert list(processes(ros)) == ["router"]


@pytest.mark.nightly
def test_a_name_that_is_taken_again_is_no_longer_that_of_what_died(ros):
    ros.run("run -d simple_publisher")
    psutil.Process(processes(ros)["simple_publisher"]["pid"]).kill()
    eventually(lambda: processes(ros)["simple_publisher"]["ending"] is not None)
    ros.run("run -d simple_publisher")
    assert processes(ros)["simple_publisher"]["ending"] is None


def test_a_detached_launch_that_is_taken_down_while_it_starts_has_not_come_up(ros):
    (ros.folder / "ends.yaml").write_text(
        "launch:\n"
        "- node: {pkg: controller_manager, exec: spawner, args: none_such}\n"
        "- executable: {cmd: 'true', required: true}\n"
    )
    result = ros.run("launch -d ends.yaml")
    assert result.returncode == 1
    assert "ends is up" not in result.stdout
    assert "The launch ended while it was starting" in result.stderr
    assert "process[true-2] was required" in result.stderr


def test_a_detached_launch_whose_programs_have_done_their_work_is_not_up_but_has_finished(ros):
    (ros.folder / "works.yaml").write_text("launch:\n- executable: {cmd: 'true'}\n")
    result = ros.run("launch -d works.yaml")
    assert result.returncode == 0, result.stderr
    assert result.stdout.endswith("works has finished\n")
    assert "is up" not in result.stdout.splitlines()[-1]


def test_logs_follow_until_the_process_ends(ros):
    (ros.folder / "counts.py").write_text(
        "import rclpy, sys\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('counts')\n"
        "node.create_timer(0.1, lambda: print('tick', flush=True))\n"
        "rclpy.spin(node)\n"
    )
    assert ros.run("run -d ./counts.py").returncode == 0
    follower = ros.spawn("logs -f counts")
    follower.wait_for_line("tick")
    follower.wait_for_line("tick")
    assert ros.run("stop counts").returncode == 0
    assert follower.wait() == 0
    assert len(ros.run("logs -n 1 counts").stdout.splitlines()) == 1


@pytest.mark.parametrize("verb", ["stop", "logs"])
def test_an_unknown_name_is_an_error_that_lists_what_runs(ros, verb):
    ros.run("run -d simple_publisher")
    result = ros.run(f"{verb} nothing_like_it")
    assert result.returncode == 1
    assert "Nothing named 'nothing_like_it' runs in the background" in result.stderr
    assert "simple_publisher" in result.stderr


def test_stop_ends_the_nodes_and_all_the_router_too(ros):
    ros.run("run -d simple_publisher")
    assert ros.run("stop --yes").stdout == "simple_publisher has been stopped\n"
    assert list(processes(ros)) == ["router"]
    assert ros.run("stop --all").stdout == "router has been stopped\n"
    nothing = ros.run("ps")
    assert (nothing.returncode, nothing.stdout) == (0, "")
    assert "No background processes" in nothing.stderr
    assert ros.run("ps --json").stdout == "[]\n"


def test_a_recorded_launch_whose_work_is_done_at_once_has_come_up(ros):
    (ros.folder / "quick.yaml").write_text("launch: [executable: {cmd: 'true'}]\n")
    result = ros.run("launch -d quick.yaml record:=bag")
    assert result.returncode == 0, result.stderr
    assert "true-1 has finished" in result.stdout
    assert re.search(r"^recorder (is up|has finished)", result.stdout, re.MULTILINE)
