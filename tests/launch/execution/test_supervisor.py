"""The supervisor where the system refuses something: the launch goes on with the rest."""

import os
import subprocess
import sys
from dataclasses import replace

import pytest

from teleopctl.launch.execution import supervisor
from teleopctl.launch.execution.supervisor import Supervisor
from teleopctl.launch.model.output import BOTH, output_alias
from teleopctl.launch.model.plan import FollowUp, LaunchPlan, ProcessPlan
from teleopctl.testing import eventually

WORKS = ProcessPlan(name="works-1", command=[sys.executable, "-c", "print('done')"])


def planned(folder, processes):
    return LaunchPlan(log_directory=folder, start=FollowUp(processes=processes))


def test_a_launch_goes_on_while_its_status_cannot_be_written(tmp_path):
    (tmp_path / "processes.json.new").mkdir()
    plan = planned(tmp_path, [WORKS])
    assert Supervisor(plan, in_background=True).run() == 0
    assert (tmp_path / "works-1.log").read_text().strip() == "done"


def test_a_command_that_no_system_takes_is_one_dead_process(tmp_path, capfd):
    odd = ProcessPlan(name="odd-2", command=[sys.executable, "a\0b"])
    plan = planned(tmp_path, [WORKS, odd])
    assert Supervisor(plan).run() == 1
    output = capfd.readouterr().out
    assert "[ERROR] [odd-2]: process failed to start: embedded null byte" in output
    assert "[INFO] [works-1]: process has finished cleanly" in output


def test_a_process_whose_log_cannot_be_written_runs_and_the_launch_says_so_once(tmp_path, capfd):
    (tmp_path / "works-1.log").mkdir()
    talks = replace(WORKS, command=[sys.executable, "-c", "print('a'); print('b')"])
    assert Supervisor(planned(tmp_path, [talks])).run() == 0
    output = capfd.readouterr().out
    assert output.count("[WARNING] [launch]: Cannot write ") == 1
    assert f"{tmp_path / 'works-1.log'}: Is a directory; lines will be missing" in output


def test_a_process_that_writes_no_line_ends_does_not_fill_the_memory(tmp_path, capfd):
    code = "import os; [os.write(1, b'x' * 10_000) for _ in range(100)]"
    endless = replace(WORKS, command=[sys.executable, "-c", code], stdout=BOTH)
    assert Supervisor(planned(tmp_path, [endless])).run() == 0
    assert (tmp_path / "works-1.log").read_bytes() == b"x" * 1_000_000
    lines = capfd.readouterr().out.splitlines()
    assert max(len(line) for line in lines) < 70_000


COMPANION = """
import os, signal, sys, threading
from teleopctl.base import progress
ended = threading.Event()
signal.signal(signal.SIGINT, lambda *_: ended.set())
print("here", os.path.exists("worked"), flush=True)
progress.report(progress.READY)
ended.wait()
print("gone", os.path.exists("worked"), flush=True)
"""


def companion(tmp_path, code=COMPANION):
    (tmp_path / "companion.py").write_text(code)
    return ProcessPlan(
        name="companion-1",
        command=[sys.executable, str(tmp_path / "companion.py")],
        working_directory=str(tmp_path),
        accompanies=True,
    )


def test_what_accompanies_the_others_is_there_before_and_after_them(tmp_path):
    touch = [sys.executable, "-c", "open('worked', 'w').close()"]
    works = replace(WORKS, command=touch, working_directory=str(tmp_path))
    plan = planned(tmp_path, [works, companion(tmp_path)])
    assert Supervisor(plan).run() == 0
    assert (tmp_path / "companion-1.log").read_text() == "here False\ngone True\n"


def test_where_it_cannot_begin_the_others_do_not(tmp_path):
    refuses = companion(tmp_path, "raise SystemExit('no room')")
    plan = planned(tmp_path, [WORKS, refuses])
    assert Supervisor(plan).run() == 1
    assert not (tmp_path / "works-1.log").exists()


SIMULATOR = """
import os, sys, time
from teleopctl.base import progress
progress.report(progress.STARTING)
print("looked at", os.path.exists("looks"), flush=True)
if sys.argv[1] == "becomes ready":
    progress.report(progress.READY)
while sys.argv[1] != "ends" and not os.path.exists("looks"):
    time.sleep(0.01)
"""


@pytest.mark.parametrize(
    ("simulator", "longest_s"), [("becomes ready", 1e6), ("compiles", 0.0), ("ends", 1e6)]
)
def test_what_gives_way_starts_once_the_simulator_is_ready(
    tmp_path, monkeypatch, simulator, longest_s
):
    monkeypatch.setattr(supervisor, "_GIVE_WAY_S", longest_s)
    (tmp_path / "simulator.py").write_text(SIMULATOR)
    touch = [sys.executable, "-c", "open('looks', 'w').close()"]
    looks = replace(
        WORKS, name="looks-1", command=touch, working_directory=str(tmp_path), gives_way=True
    )
    simulates = ProcessPlan(
        name="simulates-2",
        command=[sys.executable, str(tmp_path / "simulator.py"), simulator],
        working_directory=str(tmp_path),
        simulates=True,
    )
    assert Supervisor(planned(tmp_path, [looks, simulates])).run() == 0
    assert (tmp_path / "looks").exists()
    if simulator == "becomes ready":
        assert (tmp_path / "simulates-2.log").read_text() == "looked at False\n"


def test_without_a_simulator_nothing_gives_way(tmp_path):
    assert Supervisor(planned(tmp_path, [replace(WORKS, gives_way=True)])).run() == 0
    assert (tmp_path / "works-1.log").read_text() == "done\n"


@pytest.mark.skipif(os.name == "nt", reason="FIFOs, and the signal of a broken pipe")
@pytest.mark.parametrize("program", ["shell", "python"])
def test_a_node_outlives_the_supervisor_that_reads_its_output(tmp_path, program):
    commands = {
        "shell": ["sh", "-c", "echo up; read x < fifo; echo one; echo two; echo done > done"],
        "python": [sys.executable, "-P", "-m", "teleopctl.nodes", str(tmp_path / "prints.py")],
    }
    (tmp_path / "prints.py").write_text(
        "import os, sys\n"
        "print('up')\n"
        "open('fifo').read()\n"
        "print('one')\n"
        "sys.stderr.write('two\\n')\n"
        "os.system('echo of a child')\n"
        "open('done', 'w').write('done')\n"
    )
    os.mkfifo(tmp_path / "fifo")
    node = ProcessPlan(
        name="node-1", command=commands[program], is_node=True, working_directory=str(tmp_path)
    )
    (tmp_path / "carry_out.py").write_text(
        "from pathlib import Path\n"
        "from teleopctl.launch.execution.supervisor import Supervisor\n"
        "from teleopctl.launch.model.output import Output\n"
        "from teleopctl.launch.model.plan import FollowUp, LaunchPlan, ProcessPlan\n"
        "from teleopctl.base.output import outlive_output\n"
        "outlive_output()\n"
        f"node = {node!r}\n"
        "start = FollowUp(processes=[node])\n"
        f"plan = LaunchPlan(log_directory=Path({str(tmp_path)!r}), start=start)\n"
        "Supervisor(plan).run()\n"
    )
    supervisor = subprocess.Popen(
        [sys.executable, "-P", str(tmp_path / "carry_out.py")],
        stdout=subprocess.DEVNULL,
    )
    log = tmp_path / "node-1.log"
    # For reading as well: so it opens at once, whether or not the node ever comes to read.
    fifo = os.open(tmp_path / "fifo", os.O_RDWR)
    try:
        eventually(lambda: log.exists() and log.read_text() == "up\n", what="the node's start")
    finally:
        supervisor.kill()
        supervisor.wait()
        os.close(fifo)
    eventually((tmp_path / "done").exists, what="the end of the node's work")
    if program == "python":
        assert log.read_text() == "up\none\ntwo\nof a child\n"


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such terminals")
def test_a_process_can_be_made_to_think_that_it_writes_to_a_terminal(tmp_path):
    code = "import sys; print(sys.stdout.isatty()); print(sys.stderr.isatty(), file=sys.stderr)"
    asks = replace(WORKS, command=[sys.executable, "-c", code], emulate_tty=True)
    pipes = replace(asks, name="pipes-2", emulate_tty=False)
    assert Supervisor(planned(tmp_path, [asks, pipes])).run() == 0
    assert (tmp_path / "works-1.log").read_text() == "True\nTrue\n"
    assert (tmp_path / "pipes-2.log").read_text() == "False\nFalse\n"


def test_each_stream_goes_where_the_words_of_ros2_send_it(tmp_path, capfd):
    code = "import sys; print('out'); sys.stdout.flush(); print('err', file=sys.stderr)"
    names = ("screen", "log", "both", "own_log", "full")
    processes = []
    for name in names:
        stdout, stderr = output_alias(name)
        command = [sys.executable, "-c", code]
        processes.append(ProcessPlan(name=name, command=command, stdout=stdout, stderr=stderr))
    assert Supervisor(planned(tmp_path, processes)).run() == 0
    shown, kept = capfd.readouterr().out, (tmp_path / "launch.log").read_text()
    found = {
        name: tuple(f"[{name}] {word}" in text for text in (shown, kept) for word in ("out", "err"))
        + (tmp_path / f"{name}-stdout.log").exists() * ("own",)
        for name in names
    }
    assert found == {
        "screen": (True, True, False, False),
        "log": (False, True, True, True),
        "both": (True, True, True, True),
        "own_log": (False, False, False, False, "own"),
        "full": (True, True, True, True, "own"),
    }


ROBOT = "<robot>\n" + 99 * "<link/>\n"


def test_a_very_long_argument_of_a_dead_process_is_whole_in_the_log_alone(tmp_path, capfd):
    dies = ProcessPlan(name="create-1", command=["sh", "-c", "exit 3", "-string", ROBOT])
    assert Supervisor(planned(tmp_path, [dies])).run() == 1
    shown, kept = capfd.readouterr().out, (tmp_path / "launch.log").read_text()
    begin = "exit code 3, cmd 'sh -c exit 3 -string <robot>"
    assert f"{begin}{6 * ' <link/>'} <lin… (800 characters)'].\n" in shown
    assert f"{begin}{ROBOT.removeprefix('<robot>')}'].\n" in kept
