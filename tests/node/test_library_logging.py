"""What library code logs with Python's logging appears as a node's."""

import logging
import re
import subprocess
import sys
import warnings
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node import Context, Node
from teleopctl.node.values.logging import LoggingSeverity, set_logger_level
from teleopctl.tf.history import TransformSample
from teleopctl.tf.transforms import IDENTITY
from teleopctl.tf.tree import FrameTree

LIBRARY = logging.getLogger("teleopctl")
MODULE = logging.getLogger("teleopctl.tf.tree")


def reject_a_transform():
    """Have the library complain of a frame that stands in itself."""
    FrameTree(10**9).insert(TransformSample(1, "base", IDENTITY), "base", "me", static=False)


@pytest.fixture
def log(make_node, spin_until):
    """Returns the lines on /rosout once there is one with a text; the node that speaks is arm."""
    make_node("arm", namespace="/left")
    got: list[Any] = []
    make_node("listener").create_subscription(
        get_message("rcl_interfaces/msg/Log"), "/rosout", got.append, 10
    )

    def wait_for(text):
        spin_until(lambda: any(text in each.msg for each in got))
        return got

    return wait_for


@pytest.fixture
def set_level():
    """Sets levels for the test alone."""
    changed = []

    def set_level(name, level):
        changed.append(name)
        set_logger_level(name, level)

    yield set_level
    for name in changed:
        set_logger_level(name, LoggingSeverity.UNSET)


def test_a_rejected_transform_is_told_on_rosout_with_its_place(log):
    reject_a_transform()
    (line,) = log("TF_SELF_TRANSFORM")
    assert (line.level, line.name, line.function) == (40, "left.arm.tf.tree", "insert")
    assert line.file.endswith("tree.py")


@pytest.mark.parametrize("name", ["left.arm.tf.tree", "left.arm.tf", "left.arm"])
def test_the_levels_of_ros_apply(log, set_level, name):
    set_level(name, LoggingSeverity.FATAL)
    reject_a_transform()  # an error, so that it is ignored
    set_level(name, LoggingSeverity.DEBUG)
    MODULE.debug("let %s", "through")
    assert [(line.level, line.msg) for line in log("through")] == [(10, "let through")]


def test_every_level_of_python_has_one_in_ros(log, set_level):
    set_level("left.arm", LoggingSeverity.DEBUG)
    for level in (5, 10, 15, 20, 25, 30, 40, 50, 60):
        LIBRARY.log(max(level, 10), "level %d", level)
    lines = log("level 60")
    assert [line.level for line in lines] == [10, 10, 10, 20, 20, 30, 40, 50, 50]
    assert {line.name for line in lines} == {"left.arm"}


def test_an_exception_comes_with_its_traceback(log):
    try:
        raise ValueError("odd")
    except ValueError:
        MODULE.exception("it broke")
    (line,) = log("it broke")
    assert line.msg.startswith("it broke\nTraceback")
    assert line.msg.endswith("ValueError: odd")


def test_warnings_that_a_program_captures_are_told_too(log):
    with warnings.catch_warnings():
        # pytest has a way of its own for warnings, which stands before that of logging.
        warnings.simplefilter("always")
        logging.captureWarnings(True)
        try:
            warnings.warn("worn out", RuntimeWarning, stacklevel=1)
        finally:
            logging.captureWarnings(False)
    (line,) = log("worn out")
    assert (line.level, line.name) == (30, "left.arm.py.warnings")


def test_arguments_that_do_not_fit_their_text_end_nobody(ros):
    program = (
        "import logging\n"
        "from teleopctl.node import Node, init\n"
        "init(args=[])\n"
        "node = Node('arm')\n"
        "logging.getLogger('teleopctl.tf').error('%d frames', 'many')\n"
        "logging.getLogger('teleopctl.tf').error('still here')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=ros.env,
        capture_output=True,
        text=True,
        check=True,
        timeout=30,
    )
    assert "TypeError: %d format" in done.stderr
    assert done.stderr.splitlines()[-1].endswith("[arm.tf]: still here")


def test_it_takes_one_way_only_and_afterwards_that_of_python(context, caplog):
    nodes = [Node(name, context=context) for name in ("first", "second")]
    reject_a_transform()
    assert caplog.text == ""
    nodes[0].destroy_node()
    reject_a_transform()
    assert caplog.text == ""
    nodes[1].destroy_node()
    reject_a_transform()
    assert caplog.text == ""
    context.shutdown()
    reject_a_transform()
    assert "TF_SELF_TRANSFORM" in caplog.text
    assert (LIBRARY.level, LIBRARY.handlers) == (logging.NOTSET, [])


def test_a_context_may_leave_pythons_logging_alone(ros, caplog):
    context = Context()
    context.init([], initialize_logging=False)
    try:
        with Node("quiet", context=context):
            reject_a_transform()
    finally:
        context.shutdown()
    assert "TF_SELF_TRANSFORM" in caplog.text


def test_a_program_prints_it_in_the_format_of_ros_and_obeys_log_level(ros):
    echo = ros.spawn("run tf2_ros tf2_echo world cup")
    echo.wait_for_line("Waiting for transform")
    bad = "{transforms: [{header: {frame_id: cup}, child_frame_id: cup}]}"
    ros.run(["topic", "pub", "--once", "-w", "1", "/tf", "tf2_msgs/msg/TFMessage", bad])
    line = echo.wait_for_line("TF_SELF_TRANSFORM", stream="stderr").string
    assert re.match(r"\[ERROR\] \[\d+\.\d{9}\] \[tf2_echo\w*\.tf\.tree\]: TF_SELF", line), line


def test_of_several_nodes_the_oldest_that_exists_speaks(context, capsys, monkeypatch):
    monkeypatch.setattr("teleopctl.node.values.logging._console", None)
    nodes = [Node(name, context=context) for name in ("first", "second")]
    for node in nodes:
        reject_a_transform()
        node.destroy_node()
    reject_a_transform()
    names = [line.split("[")[3].partition("]")[0] for line in capsys.readouterr().err.splitlines()]
    assert names == ["first.tf.tree", "second.tf.tree", "teleopctl.tf.tree"]
