"""What is published in a type that this machine lacks is received all the same."""

import threading
from collections import deque
from typing import Any

import pytest

from teleopctl.interfaces import get_message
from teleopctl.node import Context, Node, SingleThreadedExecutor
from teleopctl.testing import eventually
from teleopctl.viewer.subscriptions import UnknownTypes
from tests import ROOT

GOALS = "strange_msgs/msg/Goals"


@pytest.fixture
def node(ros):
    del ros  # this process is in it
    context = Context()
    context.init([])
    node: Any
    with Node("page", context=context) as node:
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        node.spin = lambda: executor.spin_once(0.1)
        yield node
        executor.shutdown()
    context.try_shutdown()


def start_stranger(ros, folder):
    package = folder / "strange_msgs"
    for kind, name, text in (
        ("msg", "Goals", "string[] names\nstrange_msgs/Place where\n"),
        ("msg", "Place", "float64 x\n"),
        ("srv", "Pick", "Goals goals\n---\nint32 number\n"),
    ):
        (package / kind).mkdir(parents=True, exist_ok=True)
        (package / kind / f"{name}.{kind}").write_text(text)
    (package / "package.xml").write_text("<package><name>strange_msgs</name></package>")
    ros.env["TELEOPCTL_PACKAGE_PATH"] = str(folder)
    process = ros.spawn_module("tests.system.stranger", (), cwd=ROOT)
    del ros.env["TELEOPCTL_PACKAGE_PATH"]
    process.wait_for_line("up")


def test_a_type_is_learned_when_somebody_comes_who_knows_it(ros, node, tmp_path):
    errands: deque[Any] = deque()

    def run_in_background(task, then):
        def run():
            task()
            errands.append(lambda: then(None))

        threading.Thread(target=run).start()

    def turn():
        node.spin()
        while errands:
            errands.popleft()()

    types = UnknownTypes(node, run_in_background)
    node.add_graph_callback(lambda: errands.append(types.request_missing))
    heard: list[Any] = []
    ended = []

    def begin():
        subscription = node.create_subscription(get_message(GOALS), "/goals", heard.append, 1)
        return lambda: ended.append(node.destroy_subscription(subscription))

    end = types.call_when_known(GOALS, begin)
    given_up = types.call_when_known(GOALS, lambda: pytest.fail("nobody waits for it any more"))
    given_up()
    start_stranger(ros, tmp_path)
    eventually(lambda: turn() or heard)
    assert heard[0].names == ["here", "there"]
    end()
    end()
    assert ended == [True]
