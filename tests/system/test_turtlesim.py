"""ROS 2's first tutorial, as it is typed: turtlesim, its keys, services, parameters and action."""

import os
import re
import sys

import pytest

from teleopctl.interfaces import get_message
from teleopctl.testing import eventually

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a pseudo-terminal")


@pytest.mark.nightly
def test_the_turtle_is_driven_turned_and_gets_company(shared_ros):
    from tests.system.terminal import Terminal

    listed = shared_ros.run("pkg executables turtlesim").stdout.splitlines()
    assert listed == [
        "turtlesim draw_square",
        "turtlesim mimic",
        "turtlesim turtle_teleop_key",
        "turtlesim turtlesim_node",
    ]
    node = shared_ros.spawn("run turtlesim turtlesim_node --port 0")
    node.wait_for_line(r"\[turtlesim\]: The window is at http://localhost:\d+/$", stream="stderr")
    said = re.findall(r"^\[INFO\] \[[\d.]+\] \[turtlesim\]: (.*)", node.stderr, re.MULTILINE)
    assert said[:2] == [
        "Starting turtlesim with node name /turtlesim",
        "Spawning turtle [turtle1] at x=[5.544445], y=[5.544445], theta=[0.000000]",
    ]
    argv = [sys.executable, "-m", "teleopctl", "run", "turtlesim", "turtle_teleop_key"]
    terminal = Terminal(argv, shared_ros.env, shared_ros.folder, is_controlling=True)
    try:
        terminal.until(r"'q' to quit\.")
        pose = get_message("turtlesim/msg/Pose"), "/turtle1/pose"

        def drive() -> bool:
            terminal.press("\x1b[A")
            return bool(shared_ros.wait_for_message(*pose).x > 5.6)

        eventually(drive)
        terminal.press("r")
        eventually(lambda: shared_ros.wait_for_message(*pose).theta > 1.5)
        node.wait_for_line("Rotation goal completed successfully", stream="stderr")
    finally:
        terminal.press("q")
        assert terminal.wait() == 0
    called = shared_ros.run(
        ["service", "call", "/spawn", "turtlesim/srv/Spawn", "{x: 2, y: 2, theta: 0.2, name: ''}"]
    )
    assert called.stdout == (
        "requester: making request: turtlesim.srv.Spawn_Request(x=2.0, y=2.0, theta=0.2, name='')\n"
        "\nresponse:\nturtlesim.srv.Spawn_Response(name='turtle2')\n\n"
    )
    node.interrupt()
    assert node.wait() == 0
