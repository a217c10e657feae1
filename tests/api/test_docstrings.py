"""The examples in the docstrings of the public names run, and print what they show."""

import doctest
import os
from collections.abc import Iterator

import pytest

import teleopctl
from teleopctl.bag import BagMessage, BagTopic, BagWriter
from teleopctl.interfaces import get_message, serialize
from teleopctl.testing import RosGraph
from tests.api.test_face import PUBLIC

NEEDS_A_GRAPH = {"Graph", "Node", "open_node", "watch_graph"}
# Run where an arm is running: tests/system/test_move.py.
NEEDS_A_ROBOT = {"ExecutionError", "MotionResult", "RunningArm"}
JOINT_STATE = "sensor_msgs/msg/JointState"


@pytest.fixture
def session(tmp_path, monkeypatch):
    """The bag ``session`` of three joint states in the current folder."""
    monkeypatch.chdir(tmp_path)
    type_ = get_message(JOINT_STATE)
    with BagWriter("session") as bag:
        bag.add_topic(BagTopic("/joint_states", JOINT_STATE))
        for number, position in enumerate(([0.1, 0.2], [0.3, 0.4], [0.5, 0.6]), 1):
            time_ns = 1000 * number
            data = bytes(serialize(type_(name=["a", "b"], position=position)))
            bag.write(BagMessage("/joint_states", time_ns, time_ns, data))


def examples(value: object, name: str) -> Iterator[doctest.DocTest]:
    globs = {public: getattr(teleopctl, public) for public in PUBLIC}
    found = doctest.DocTestParser().get_doctest(
        getattr(value, "__doc__", "") or "", globs, name, None, None
    )
    if found.examples:
        yield found


def failures(value: object, name: str) -> str:
    (example,) = examples(value, name)
    said: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=said.append)
    return "".join(said)


def test_the_example_of_the_module_runs():
    assert not failures(teleopctl, "teleopctl")


@pytest.mark.usefixtures("session")
@pytest.mark.parametrize(
    "name", [name for name in PUBLIC if name not in NEEDS_A_GRAPH | NEEDS_A_ROBOT]
)
def test_the_example_of_a_name_runs(name):
    assert not failures(getattr(teleopctl, name), name)


@pytest.mark.parametrize("name", sorted(NEEDS_A_GRAPH))
def test_the_example_of_a_name_runs_in_a_graph(name, ros: RosGraph, monkeypatch):
    for key, value in ros.env.items():
        if os.environ.get(key) != value:
            monkeypatch.setenv(key, value)
    if name in {"Graph", "watch_graph"}:
        ros.spawn("run demo_nodes_py talker").wait_for_line("Publishing")
    assert not failures(getattr(teleopctl, name), name)
