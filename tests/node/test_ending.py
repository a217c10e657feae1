"""A program that ends without ``rclpy.shutdown()``."""

from __future__ import annotations

import sys

PROGRAM = """
import threading, time
import rclpy
from std_msgs.msg import String

class TakesItsTime:
    def __del__(self):
        for _ in range(10):
            time.sleep(0.005)

# Python is still ending while it goes.
late = TakesItsTime()
rclpy.init()
node = rclpy.create_node("busy")
threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
once = threading.Event()

def use():
    while True:
        node.get_node_names()
        node.destroy_publisher(node.create_publisher(String, "said", 10))
        once.set()

threading.Thread(target=use, daemon=True).start()
once.wait()
"""


def test_daemon_threads_that_use_a_node_do_not_abort_a_program_that_ends(ros, tmp_path):
    """A thread that is in Zenoh's code while Python ends is "FATAL: exception not rethrown"."""
    (tmp_path / "busy.py").write_text(PROGRAM)
    command = [sys.executable, "-m", "teleopctl.nodes", str(tmp_path / "busy.py")]
    programs = [ros.spawn_command(command) for _ in range(2)]
    for program in programs:
        assert program.wait() == 0, program.report()


INTERRUPTED = """
import concurrent.futures, signal, threading, time
import rclpy
from rclpy.executors import MultiThreadedExecutor

submit = concurrent.futures.ThreadPoolExecutor.submit
submitted = []

def interrupted(pool, work):
    if submitted:
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        # Once Python has begun to end, a pool refuses work.
        while True:
            submit(pool, int)
            time.sleep(0.01)
    submitted.append(submit(pool, work))

concurrent.futures.ThreadPoolExecutor.submit = interrupted
rclpy.init()
MultiThreadedExecutor(3)
"""


def test_ctrl_c_while_a_multi_threaded_executor_starts_its_threads_ends_the_program(ros, tmp_path):
    """The first thread waits for the others, never started; Python waits for the first."""
    (tmp_path / "interrupted.py").write_text(INTERRUPTED)
    program = ros.spawn_command(
        [sys.executable, "-m", "teleopctl.nodes", str(tmp_path / "interrupted.py")]
    )
    program.wait()
    assert "RuntimeError" not in program.stderr, program.report()
