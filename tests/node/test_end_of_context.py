"""Publishing and creating nodes when the context has ended, in real programs."""

from __future__ import annotations

import os
import signal
import sys

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import (
    Clock,
    Context,
    Duration,
    ExternalShutdownException,
    Node,
    NotInitializedException,
)
from teleopctl.node.values.exceptions import RCLError

STRING = get_message("std_msgs/msg/String")
TEXT = "Failed to publish: publisher's context is invalid"

TALKING = """
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("talking")
publisher = node.create_publisher(String, "chatter", 10)
print("ready", flush=True)
while True:
    publisher.publish(String(data="on and on"))
"""

CATCHING = """
import rclpy
from rclpy.impl.implementation_singleton import rclpy_implementation
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("catching")
publisher = node.create_publisher(String, "chatter", 10)
print("ready", flush=True)
try:
    while True:
        publisher.publish(String(data="on and on"))
except rclpy_implementation.RCLError as error:
    print(error, flush=True)
"""


SPINNING = """
import threading
from teleopctl.node import Node, SingleThreadedExecutor, init, spin_in_thread
with init():
    executor = SingleThreadedExecutor()
    executor.add_node(Node("spinning"))
    thread = spin_in_thread(executor)
    print("ready", flush=True)
    thread.join()
    print("ended", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM is for POSIX only")
def test_a_thread_that_spins_ends_by_a_signal_without_a_traceback(ros, tmp_path):
    path = tmp_path / "spinning.py"
    path.write_text(SPINNING)
    program = ros.spawn_command([sys.executable, str(path)])
    program.wait_for_line("ready")
    os.kill(program.pid, signal.SIGTERM)
    program.wait_for_line("ended", stream="stdout")
    assert (program.wait(), program.stderr) == (0, ""), program.report()


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM is for POSIX only")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)])
def test_a_program_that_only_publishes_ends_by_a_signal(ros, tmp_path, number, status):
    path = tmp_path / "talking.py"
    path.write_text(TALKING)
    program = ros.spawn_command([sys.executable, "-m", "teleopctl.nodes", str(path)])
    program.wait_for_line("ready")
    os.kill(program.pid, number)
    assert program.wait() == status, program.report()
    assert "Traceback" not in program.stderr


def test_a_program_may_catch_what_rclpy_raises(ros, tmp_path):
    path = tmp_path / "catching.py"
    path.write_text(CATCHING)
    program = ros.spawn_command([sys.executable, "-m", "teleopctl.nodes", str(path)])
    program.wait_for_line("ready")
    program.terminate()
    assert program.wait() == 0, program.report()
    assert program.stdout.splitlines() == ["ready", TEXT]


STARTING = """
import os, signal, rclpy
rclpy.init()
os.kill(os.getpid(), signal.SIGTERM)
rclpy.spin(rclpy.create_node("starting"))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM is for POSIX only")
def test_a_program_that_is_terminated_before_its_node_is_made_ends_quietly(ros, tmp_path):
    path = tmp_path / "starting.py"
    path.write_text(STARTING)
    program = ros.spawn_command([sys.executable, "-m", "teleopctl.nodes", str(path)])
    assert program.wait() == 0, program.report()
    assert (program.stdout, program.stderr) == ("", "")


def test_a_context_that_a_signal_ended_says_so_and_one_that_was_never_begun_does_not():
    context = Context()
    with pytest.raises(NotInitializedException, match="has not been called") as raised:
        Node("early", context=context)
    assert not isinstance(raised.value, ExternalShutdownException)
    context.init([])
    context.end_by_signal()
    with pytest.raises(ExternalShutdownException, match="the context was shut down by a signal"):
        Node("late", context=context)
    with pytest.raises(NotInitializedException):  # as rclpy
        Clock().sleep_for(Duration(seconds=1), context)
    context.try_shutdown()


@pytest.mark.parametrize("publishes_after_signal", [False, True])
def test_what_ends_in_order_publishes_until_it_is_shut_down(ros, publishes_after_signal):
    del ros
    context = Context()
    context.init([], publishes_after_signal=publishes_after_signal)
    publisher = Node("tester", context=context).create_publisher(STRING, "chatter", 10)
    context.end_by_signal()
    if publishes_after_signal:
        publisher.publish(STRING())
    else:
        with pytest.raises(ExternalShutdownException, match=TEXT):
            publisher.publish(STRING())
    context.try_shutdown()
    with pytest.raises(RCLError, match=TEXT):
        publisher.publish(STRING())
