"""The programs of examples_rclpy do what those of ROS 2 do, goal after goal too."""

import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl import plugins
from teleopctl.interfaces import get_action, get_message
from teleopctl.node import ActionClient, MultiThreadedExecutor, Node, init
from teleopctl.nodes.demos import minimal, minimal_actions
from teleopctl.testing import RosGraph, eventually

Fibonacci = get_action("example_interfaces/action/Fibonacci")
SUCCEEDED, ABORTED = 4, 6


class Session:
    """A user's node and an executor of several threads."""

    def __init__(self) -> None:
        self.user = Node("user")
        self.executor = MultiThreadedExecutor(4)
        self.executor.add_node(self.user)
        self.thread = threading.Thread(target=self.executor.spin, daemon=True)
        self.thread.start()
        self.nodes: list[Any] = [self.user]

    def add(self, node: Any) -> Any:
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def send(self, client: Any, order: int) -> Any:
        """Send a goal, and return the future of its result."""
        sent = client.send_goal_async(Fibonacci.Goal(order=order))
        eventually(sent.done)
        return sent.result().get_result_async()


@pytest.fixture
def session(ros: RosGraph) -> Iterator[Session]:
    del ros
    with init(args=[]):
        session = Session()
        yield session
        session.executor.shutdown()
        session.thread.join()
        for node in session.nodes:
            node.destroy_node()


def test_texts_are_published_and_heard(session):
    received: list[str] = []
    subscriber: Any = minimal.MinimalSubscriber()
    subscriber.get_logger = lambda: SimpleNamespace(info=received.append)
    session.add(subscriber)
    session.add(minimal.MinimalPublisher(periods_s=(0.01,)))
    eventually(lambda: len(received) > 2)
    assert received[0].startswith('I heard: "Hello World: ')


def test_a_cloud_has_the_points_of_a_grid(session):
    clouds: list[Any] = []
    session.user.create_subscription(
        get_message("sensor_msgs/msg/PointCloud2"), "test_cloud", clouds.append, 10
    )
    session.add(minimal.PointCloudPublisher())
    eventually(lambda: clouds)
    assert clouds[0].width * clouds[0].height == 2500
    assert len(clouds[0].data) == 2500 * 16


def test_goals_are_executed_one_after_the_other(session, monkeypatch):
    running: list[int] = []
    most: list[int] = []

    def step(_: float) -> None:
        running.append(1)
        most.append(len(running))
        running.pop()

    monkeypatch.setattr(minimal_actions, "time", SimpleNamespace(sleep=step))
    session.add(minimal_actions.QueueingActionServer())
    client: Any = ActionClient(session.user, Fibonacci, "fibonacci")
    assert client.wait_for_server(10.0)
    results = [session.send(client, order) for order in (5, 3)]
    for result, numbers in zip(results, ([0, 1, 1, 2, 3, 5], [0, 1, 1, 2]), strict=True):
        eventually(result.done)
        assert result.result().status == SUCCEEDED
        assert list(result.result().result.sequence) == numbers
    assert max(most) == 1


def test_a_new_goal_aborts_the_one_before(session, monkeypatch):
    began, go_on = threading.Event(), threading.Event()

    def sleep(_: float) -> None:
        began.set()
        go_on.wait(20.0)

    monkeypatch.setattr(minimal_actions, "time", SimpleNamespace(sleep=sleep))
    session.add(minimal_actions.SingleGoalActionServer())
    client: Any = ActionClient(session.user, Fibonacci, "fibonacci")
    assert client.wait_for_server(10.0)
    first = session.send(client, 5)
    # A goal that is not executed yet cannot be aborted.
    assert began.wait(20.0)
    second = session.send(client, 2)
    go_on.set()
    for result, status in ((first, ABORTED), (second, SUCCEEDED)):
        eventually(result.done)
        assert result.result().status == status


def test_every_program_is_there():
    for name in plugins.NODES.builtin:
        if name.startswith("examples_rclpy_"):
            assert callable(plugins.load(plugins.NODES, name))
