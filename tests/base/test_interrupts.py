"""Interrupts that Python alone would hear late, or never."""

import signal
import subprocess
import sys
import threading

import pytest

from teleopctl.base import interrupts
from teleopctl.testing import LONGEST_WAIT_S

# A wait that the kernel does not end, as when the signal came just before it began.
DEAF_WAIT = """
import os, signal, threading
from teleopctl.base import interrupts

signal.signal(signal.SIGINT, signal.default_int_handler)
interrupts.install_sigint_handler()
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
ends = threading.Event()
def stay():
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # Not by print: whoever reads may interrupt while the thread still holds stdout's lock, which
    # the end of the program wants.
    os.write(1, b"waiting\\n")
    ends.wait()
try:
    # The start waits as well, and the interrupt may come in it.
    threading.Thread(target=stay, daemon=True).start()
    ends.wait()
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals go to processes there")
def test_an_interrupt_ends_a_wait_that_began_as_it_came():
    with subprocess.Popen(
        [sys.executable, "-c", DEAF_WAIT], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting\n"
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=30)
    assert (stdout, stderr, process.returncode) == ("interrupted\n", "", 0)


# lxml is of Cython, which clears an error of this step.
IMPORTS_AN_EXTENSION = """
import abc, signal, sys, time
from teleopctl.base import interrupts

register = abc.ABCMeta.register
def interrupted(*args):
    abc.ABCMeta.register = register
    signal.raise_signal(signal.SIGINT)
    return register(*args)
abc.ABCMeta.register = interrupted
interrupts.install_sigint_handler()
try:
    from lxml import etree
    assert abc.ABCMeta.register is register
    time.sleep(30)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_an_interrupt_within_the_import_of_an_extension_module_is_not_lost():
    done = subprocess.run(
        [sys.executable, "-c", IMPORTS_AN_EXTENSION],
        capture_output=True,
        text=True,
        timeout=LONGEST_WAIT_S,
        check=False,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("interrupted\n", "", 0)


ENDS_MEANWHILE = """
import signal, time
from teleopctl.base import interrupts

interrupts.install_sigint_handler()
interrupts.resend_signal()
signal.signal(signal.SIGINT, signal.SIG_DFL)
time.sleep(0.05)  # longer than it takes to come
"""


def test_an_interrupt_that_is_to_come_again_does_not_kill_a_program_that_has_ended():
    done = subprocess.run([sys.executable, "-c", ENDS_MEANWHILE], capture_output=True, text=True)
    assert (done.stderr, done.returncode) == ("", 0)


# Comes while the text of a function is run, as the first message of a type has one made.
WHILE_A_CODEC_IS_MADE = """
import os, signal, sys
from teleopctl.interfaces import get_message, serialize

def interrupt(frame, event, argument):
    if frame.f_code.co_filename == "<string>":
        sys.setprofile(None)
        os.kill(os.getpid(), signal.SIGINT)

text = get_message("std_msgs/msg/String")(data="hello")
sys.setprofile(interrupt)
try:
    serialize(text)
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="os.kill ends a process there")
def test_a_program_that_is_interrupted_at_its_first_message_ends_as_it_says():
    done = subprocess.run(
        [sys.executable, "-c", WHILE_A_CODEC_IS_MADE], capture_output=True, text=True
    )
    assert (done.stdout, done.stderr, done.returncode) == ("interrupted\n", "", 0)


CATCHES = """
try:
    exec("raise KeyboardInterrupt")
except KeyboardInterrupt:
    print("caught")
"""


def test_a_program_that_catches_an_interrupt_of_a_text_ends_as_it_says(tmp_path):
    (tmp_path / "program.py").write_text(CATCHES)
    command = [sys.executable, "-m", "teleopctl", "run", "program.py"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (done.stdout, done.stderr, done.returncode) == ("caught\n", "", 0)


# As a process that a launch starts: whoever is interrupted before the first line is a Python that
# starts, and may forget it or end with a fatal error.
STARTS = """
import sys
from teleopctl.base import interrupts
try:
    interrupts.install_sigint_handler()
    sys.stdin.read()  # until the interrupt has been sent, on a busy machine
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no masks")
def test_an_interrupt_that_comes_while_python_starts_is_raised_when_it_is_taken():
    with interrupts.blocked_for_children():
        process = subprocess.Popen(
            [sys.executable, "-c", STARTS],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=LONGEST_WAIT_S)
    assert (stdout, stderr, process.returncode) == ("interrupted\n", "", 0)


def test_an_interrupt_that_is_held_back_comes_at_the_end_of_the_block():
    done = []
    with pytest.raises(KeyboardInterrupt):  # noqa: SIM117 -- what is raised at the inner one's end
        with interrupts.delayed_interrupt():
            signal.raise_signal(signal.SIGINT)
            done.append("the whole block")
    assert done == ["the whole block"]


def test_nothing_is_held_back_on_another_thread():
    done = []

    def work():
        with interrupts.delayed_interrupt():
            done.append("the whole block")

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == ["the whole block"]


def test_an_exception_that_is_its_own_cause_has_an_end():
    error = ValueError("once")
    error.__cause__ = RuntimeError("twice")
    error.__cause__.__cause__ = error
    assert not interrupts.is_cause(error)
