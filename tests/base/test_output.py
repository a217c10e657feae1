"""Logs within their bound, and processes that outlive what they write to."""

import os
import resource
import subprocess
import sys

import pytest

from teleopctl.base import output
from teleopctl.base.output import LogFile, older_part
from teleopctl.errors import UsageError
from teleopctl.testing import LONGEST_WAIT_S

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes and limits of POSIX")

LINE = b"x" * 99 + b"\n"


@pytest.fixture(autouse=True)
def _small_logs(monkeypatch):
    monkeypatch.setenv("TELEOPCTL_LOG_BYTES", "10000")


def numbered(path):
    """The lines of both parts of a log."""
    older = older_part(path)
    text = (older.read_text() if older.exists() else "") + path.read_text()
    return [int(line) for line in text.split()]


def ended(code, *, stdout, arguments=(), **options):
    """Run a program with an output of its own to its end."""
    return subprocess.run(
        [sys.executable, *arguments, "-c", code],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        timeout=LONGEST_WAIT_S,
        check=False,
        **options,
    )


def test_a_log_keeps_its_newest_lines_within_its_bound(tmp_path):
    log = LogFile(tmp_path / "log")
    for number in range(10_000):
        log.write(b"%d\n" % number)
    log.close()
    kept = numbered(tmp_path / "log")
    assert kept == list(range(kept[0], 10_000))
    assert 5000 < sum(file.stat().st_size for file in tmp_path.iterdir()) <= 10_000


@pytest.mark.parametrize("text", ["0", "-1", "1e9", "ten", "²"])
def test_a_bound_that_is_none_is_refused(text):
    with pytest.raises(UsageError, match="is not a valid log size"):
        output.log_bytes({"TELEOPCTL_LOG_BYTES": text})


def test_a_log_on_a_full_disk_is_reported_once_and_goes_on_when_there_is_room(tmp_path):
    # A limit of the file's size stands for the disk: it fails in the middle of a line as well.
    told: list[str] = []
    log = LogFile(tmp_path / "log", told.append)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (250, before[1]))
    try:
        for _ in range(5):
            log.write(LINE)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    log.write(b"after\n")
    log.close()
    assert told == [f"Cannot write {tmp_path / 'log'}: File too large; lines will be missing"]
    assert (tmp_path / "log").read_bytes() == 2 * LINE + b"x" * 50 + b"\nafter\n"


@pytest.mark.parametrize("arguments", [(), ("-u",)], ids=["buffered", "unbuffered"])
def test_a_process_in_the_background_keeps_its_own_log_within_its_bound(tmp_path, arguments):
    code = f"""
from pathlib import Path
from teleopctl.base.output import outlive_output
outlive_output(log_file=Path({str(tmp_path / "log")!r}))
for number in range(10_000):
    print(number, flush=True)
"""
    with (tmp_path / "log").open("ab") as log:
        assert ended(code, stdout=log, arguments=arguments).returncode == 0
    kept = numbered(tmp_path / "log")
    assert kept == list(range(kept[0], 10_000))
    assert sum(file.stat().st_size for file in tmp_path.iterdir()) <= 10_000


def test_who_loses_the_reader_of_its_output_goes_on_in_its_log(tmp_path):
    code = f"""
import os
from pathlib import Path
from teleopctl.base.output import outlive_output
outlive_output(log_file=Path({str(tmp_path / "log")!r}))
print("python", flush=True)
os.system("echo child")
"""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        assert ended(code, stdout=writer).returncode == 0
    finally:
        os.close(writer)
    assert (tmp_path / "log").read_text() == "python\nchild\n"


def test_without_a_log_it_goes_on_in_silence():
    code = """
from teleopctl.base.output import outlive_output
outlive_output()
print("a" * 100_000)
print("b", flush=True)
"""
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = ended(code, stdout=full)
    assert (done.returncode, done.stderr) == (0, "")


def test_who_writes_to_a_terminal_that_is_gone_goes_on():
    code = """
import os, pty, signal, sys
signal.signal(signal.SIGHUP, signal.SIG_IGN)
master, slave = pty.openpty()
os.dup2(slave, 1)
os.close(slave)
from teleopctl.base.output import outlive_output
outlive_output(lossless_stdout=True)
print("heard", flush=True)
os.close(master)
print("lost", flush=True)
sys.stderr.write("still here")
"""
    done = ended(code, stdout=subprocess.DEVNULL)
    assert (done.returncode, done.stderr) == (0, "still here")


def test_a_result_that_cannot_be_written_stays_an_error():
    code = """
from teleopctl.base.output import outlive_output
outlive_output(lossless_stdout=True)
print("result", flush=True)
"""
    with open("/dev/full", "w") as full:  # noqa: PTH123
        assert "No space left on device" in ended(code, stdout=full).stderr


INTERRUPTED = """
import queue, signal, sys, threading
from teleopctl.base.output import outlive_output

lines = [0]
came_in = []
late = []
taken = queue.SimpleQueue()

def write():
    while interrupter.is_alive():
        lines[0] += 1
        sys.stderr.write(f"{lines[0]}\\n")

def in_write(frame):
    return frame is not None and (frame.f_code is write.__code__ or in_write(frame.f_back))

def interrupted(signum, frame):
    if in_write(frame):
        came_in.append(lines[0])
        raise KeyboardInterrupt
    taken.put(None)

def interrupt():
    for _ in range(300):
        signal.pthread_kill(main, signal.SIGINT)
        taken.get()

outlive_output()
sys.setswitchinterval(1e-4)
main = threading.get_ident()
signal.signal(signal.SIGINT, interrupted)
interrupter = threading.Thread(target=interrupt)
interrupter.start()
while interrupter.is_alive():
    try:
        write()
    except KeyboardInterrupt:
        if came_in.pop() != lines[0]:
            late.append(lines[0])
        taken.put(None)
print(f"late: {late}")
"""


@pytest.mark.parametrize("mode", ["buffered", "unbuffered"])
def test_an_interrupt_is_raised_by_the_write_that_it_meets_and_no_line_is_written_twice(mode):
    env = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    if mode == "unbuffered":
        env["PYTHONUNBUFFERED"] = "1"
    done = ended(INTERRUPTED, stdout=subprocess.PIPE, env=env)
    assert (done.returncode, done.stdout) == (0, "late: []\n")
    lines = done.stderr.split()
    assert lines
    assert len(lines) == len(set(lines))
