import errno
import os
import signal
import subprocess
import sys

import psutil
import pytest

from teleopctl.base import background
from teleopctl.base.start_timeouts import StartTimeouts
from teleopctl.errors import TeleopctlError
from teleopctl.testing import LONGEST_WAIT_S, eventually

SLEEPER = [sys.executable, "-c", "import time; time.sleep(600)"]
ANNOUNCER = """
import sys, time
from teleopctl.base.background import announce_ready
print("to the log", file=sys.stderr, flush=True)
announce_ready({failure})
print("from now on to the log as well", flush=True)
time.sleep(600)
"""


def announcer(failure=None):
    return [sys.executable, "-c", ANNOUNCER.format(failure=repr(failure))]


def _file_of(record):
    assert record.file is not None
    return record.file


@pytest.fixture(autouse=True)
def _isolated(ros_without_router):
    """Records and logs of their own, everything ended afterwards."""


def test_what_was_started_is_on_record_until_it_is_stopped():
    record = background.start("sleeper", SLEEPER, kind="node")
    assert background.records() == [record]
    assert record.name == "sleeper"
    assert record.command == tuple(SLEEPER)
    assert record.kind == "node"
    assert record.start.time == pytest.approx(psutil.Process(record.pid).create_time())
    background.stop(record)
    assert background.records() == []
    assert not psutil.pid_exists(record.pid)


def test_output_goes_to_a_log_file_of_its_own(ros_without_router):
    speaker = [sys.executable, "-c", "print('out'); import sys; sys.stderr.write('err')"]
    records = [background.start("a/b speaker", speaker, kind="node") for _ in range(2)]
    eventually(lambda: not background.records(), what="their end")
    assert records[0].log_file != records[1].log_file
    for record in records:
        assert record.log_file.parent == ros_without_router.folder / "log"
        assert sorted(record.log_file.read_text().split()) == ["err", "out"]


def test_several_of_one_name_are_listed_oldest_first():
    started = [background.start("twin", SLEEPER, kind="node") for _ in range(3)]
    listed = background.records()
    assert {record.pid for record in listed} == {record.pid for record in started}
    assert [r.start.time for r in listed] == sorted(r.start.time for r in listed)


def test_another_process_with_the_same_pid_is_not_ours():
    record = background.start("sleeper", SLEEPER, kind="node")
    impostor = record._replace(start=record.start._replace(mark="another"))
    background._write(impostor, _file_of(record))
    assert background.records() == []
    background.stop(impostor)
    assert psutil.pid_exists(record.pid)
    psutil.Process(record.pid).kill()


def test_a_pid_that_a_child_has_had_before_is_that_of_the_recorded_process(monkeypatch):
    record = background.start("sleeper", SLEEPER, kind="node")
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    sleeper = background._children[record.pid]
    monkeypatch.setitem(background._children, record.pid, ended)
    background.stop(record)
    assert sleeper.wait(LONGEST_WAIT_S) != 0


def test_a_record_holds_when_the_clock_is_set():
    record = background.start("sleeper", SLEEPER, kind="node")
    an_hour_ago = record._replace(start=record.start._replace(time=record.start.time - 3600))
    background._write(an_hour_ago, _file_of(record))
    assert background.records() == [an_hour_ago]


@pytest.mark.parametrize("content", ["", "{", "[]", "{}", '{"pid": "x"}', "\0"])
def test_a_damaged_record_is_removed(content):
    path = background.runtime_dir() / "processes" / "1.json"
    path.parent.mkdir(parents=True)
    path.write_text(content)
    assert background.records() == []
    assert not path.exists()


def test_a_process_that_was_killed_leaves_no_record():
    record = background.start("sleeper", SLEEPER, kind="node")
    psutil.Process(record.pid).kill()
    eventually(lambda: background.records() == [], what="its end")


def test_the_exit_status_of_a_child_is_known_after_it_was_seen_to_have_ended():
    record = background.start("ends", [sys.executable, "-c", "raise SystemExit(3)"], kind="node")
    eventually(lambda: not background.is_alive(record))
    assert background.exit_status(record) == 3


def test_stopping_what_has_ended_does_no_harm():
    record = background.start("sleeper", SLEEPER, kind="node")
    background.stop(record)
    background.stop(record)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to ignore")
def test_what_ignores_the_signals_is_killed_with_its_children():
    stubborn = """
import signal, subprocess, sys, time
from teleopctl.base.background import announce_ready
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
announce_ready()
time.sleep(600)
"""
    record = background.start(
        "stubborn", [sys.executable, "-c", stubborn], kind="node", until_ready=StartTimeouts()
    )
    (child,) = psutil.Process(record.pid).children()
    background.stop(record, patience_s=0.1)
    assert background.records() == []
    eventually(
        lambda: not child.is_running() or child.status() == psutil.STATUS_ZOMBIE,
        what="the end of the child",
    )


def test_starting_waits_until_the_process_says_that_it_is_ready():
    record = background.start("announcer", announcer(), kind="node", until_ready=StartTimeouts())
    eventually(lambda: "as well" in record.log_file.read_text(), what="output in the log")
    assert record.log_file.read_text().startswith("to the log")
    assert background.READY not in record.log_file.read_text().splitlines()


def test_a_process_that_cannot_be_recorded_does_not_stay(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    before = {child.pid for child in psutil.Process().children()}
    with monkeypatch.context() as unwritable:
        unwritable.setenv("TELEOPCTL_RUNTIME_DIR", str(tmp_path / "file"))
        with pytest.raises(TeleopctlError, match="Cannot record a background process in "):
            background.start("sleeper", SLEEPER, kind="node")
    assert {child.pid for child in psutil.Process().children()} == before


def test_a_log_folder_that_takes_no_files_is_named(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "file"))
    with pytest.raises(TeleopctlError, match=r"Cannot write to the log folder .*file: ") as failure:
        background.start("sleeper", SLEEPER, kind="node")
    assert "ROS_LOG_DIR" in str(failure.value.hint)


def test_looking_for_records_makes_no_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("TELEOPCTL_RUNTIME_DIR", str(tmp_path / "none"))
    assert background.records() == []
    assert not (tmp_path / "none").exists()


def test_a_failure_to_start_is_reported_in_the_words_of_the_process():
    with pytest.raises(TeleopctlError, match="there is no robot") as failure:
        background.start(
            "announcer",
            announcer("there is no\nrobot"),
            kind="node",
            until_ready=StartTimeouts(),
        )
    assert "log" in str(failure.value.hint)
    assert background.records() == []


def test_an_end_before_it_is_ready_is_reported_with_the_log():
    with pytest.raises(TeleopctlError, match="ended while it was starting") as failure:
        background.start(
            "broken",
            [sys.executable, "-c", "raise SystemExit('gone')"],
            kind="node",
            until_ready=StartTimeouts(),
        )
    (log_file,) = background.logs_dir().iterdir()
    assert str(log_file) in str(failure.value.hint)
    assert log_file.read_text() == "gone\n"


def test_silence_is_ended_when_the_time_is_up():
    with pytest.raises(TeleopctlError, match=r"silent is not ready after \d\.\d s"):
        background.start("silent", SLEEPER, kind="node", until_ready=StartTimeouts(stall_s=0.2))
    assert background.records() == []


def test_a_program_that_does_not_exist_is_named():
    with pytest.raises(TeleopctlError, match="no-such-program"):
        background.start("x", ["/no-such-program"], kind="node")
    assert background.records() == []


def test_announcing_in_the_foreground_changes_nothing():
    result = subprocess.run(
        [
            sys.executable,
            "-c",
            "from teleopctl.base.background import announce_ready as a; a(); print(1)",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert result.stdout == "1\n"


def test_logs_are_where_ros_puts_them(monkeypatch, tmp_path):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "here"))
    assert background.logs_dir() == tmp_path / "here"
    monkeypatch.delenv("ROS_LOG_DIR")
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
    assert background.logs_dir() == tmp_path / "home" / "log"
    monkeypatch.delenv("ROS_HOME")
    assert background.logs_dir().parts[-2:] == (".ros", "log")


def test_records_are_in_the_users_runtime_folder(monkeypatch):
    monkeypatch.delenv("TELEOPCTL_RUNTIME_DIR")
    assert "teleopctl" in str(background.runtime_dir())


def test_a_folder_that_cannot_be_made_is_an_error_that_names_the_variable(monkeypatch, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    monkeypatch.setenv("TELEOPCTL_RUNTIME_DIR", str(file))
    with pytest.raises(TeleopctlError) as failure:
        background.start("sleeper", SLEEPER, kind="node")
    assert "TELEOPCTL_RUNTIME_DIR" in str(failure.value.hint)
    # So that the environment can be taken down.
    monkeypatch.setenv("TELEOPCTL_RUNTIME_DIR", str(tmp_path / "runtime"))


@pytest.mark.skipif(os.name == "nt", reason="a signal to itself ends a process there")
def test_an_interrupt_as_a_process_is_started_leaves_neither_process_nor_record(monkeypatch):
    started = []

    class Interrupted(subprocess.Popen):
        def __init__(self, *args, **options):
            super().__init__(*args, **options)
            started.append(self)
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        background.start("sleeper", SLEEPER, kind="node")
    monkeypatch.undo()
    (process,) = started
    assert process.wait(LONGEST_WAIT_S) == -signal.SIGKILL
    assert "sleeper" not in {record.name for record in background.records()}


@pytest.mark.skipif(os.name == "nt", reason="a signal to itself ends a process there")
@pytest.mark.parametrize(
    "module", [["teleopctl.launch", "none.json"], ["teleopctl.nodes", "simple_publisher"]]
)
def test_what_is_interrupted_as_its_python_starts_ends_as_it_should(module):
    record = background.start(
        "starts", [sys.executable, "-P", "-m", *module], kind="node", takes_interrupts=True
    )
    os.kill(record.pid, signal.SIGINT)
    assert background._children[record.pid].wait(LONGEST_WAIT_S) == 130
    assert record.log_file.read_text() == ""


def test_what_does_not_end_keeps_its_record_and_is_no_success(monkeypatch):
    record = background.start("driver", SLEEPER, kind="node")
    # As in a call of a driver that not even SIGKILL ends.
    with monkeypatch.context() as patched:
        patched.setattr(background, "_wait", lambda process, timeout_s: False)
        patched.setattr(psutil.Process, "kill", lambda process: None)
        patched.setattr(psutil.Process, "send_signal", lambda process, number: None)
        with pytest.raises(TeleopctlError, match=rf"driver \(pid {record.pid}\) has not ended"):
            background.stop(record)
    assert background.records() == [record]
    background.stop(record)
    assert background.records() == []


def test_a_record_that_cannot_be_written_leaves_no_process_and_no_file(monkeypatch):
    folder = background.runtime_dir() / "processes"
    started = []

    class Known(subprocess.Popen):
        def __init__(self, *args, **options):
            super().__init__(*args, **options)
            started.append(self)

    def refuse(path, target):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr(subprocess, "Popen", Known)
        patched.setattr(os, "replace", refuse)
        with pytest.raises(TeleopctlError, match="Cannot record a background process"):
            background.start("sleeper", SLEEPER, kind="node")
    (process,) = started
    assert process.wait(LONGEST_WAIT_S) == -signal.SIGKILL
    assert list(folder.iterdir()) == []
