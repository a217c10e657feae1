"""Functions that Zenoh calls on its own threads."""

import subprocess
import sys
import threading

import pytest

from teleopctl.base.interrupts import is_swallowed
from teleopctl.testing import eventually
from teleopctl.wire import direct_callback, open_session

KEY = "test/callbacks"


@pytest.fixture
def session(shared_ros):
    with open_session("client") as session:
        yield session


def test_python_keeps_its_state_of_a_thread_that_calls_often(session):
    of_thread = threading.local()
    calls_in_one_state = []

    def receive(_):
        of_thread.calls = getattr(of_thread, "calls", 0) + 1
        calls_in_one_state.append(of_thread.calls)

    def is_kept():
        other.put(KEY, b"")
        return max(calls_in_one_state, default=0) > 2

    with open_session("client") as other:
        subscriber = session.declare_subscriber(KEY, direct_callback(receive))
        eventually(is_kept, what="a second call in the same state")
        subscriber.undeclare()


def test_a_program_that_hears_little_does_not_load_what_keeps_the_state(session):
    program = f"""
import sys
from teleopctl.wire import direct_callback, open_session
received = []
with open_session("client") as session:
    subscriber = session.declare_subscriber("{KEY}", direct_callback(received.append))
    for _ in range(3):
        session.put("{KEY}", b"")
    print(len(received), "ctypes" in sys.modules, "threading" in sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "3 False False\n"


def test_no_interrupt_is_raised_in_what_zenoh_calls(session):
    seen = []

    def receive(_):
        seen.append(is_swallowed(sys._getframe()))

    subscriber = session.declare_subscriber(KEY, direct_callback(receive))
    session.put(KEY, b"")
    subscriber.undeclare()
    assert seen == [True]


def test_the_end_is_told(session):
    ended = threading.Event()
    session.get(KEY, direct_callback(lambda _: None, ended.set))
    assert ended.wait(20)
