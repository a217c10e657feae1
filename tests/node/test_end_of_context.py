"""Publishing when the context has ended, in real programs."""

from __future__ import annotations

import os
import signal
import sys

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import Context, ExternalShutdownException, Node
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
