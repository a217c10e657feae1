"""Fixtures: context, executor and nodes of each test, in the test's graph."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from teleopctl.node import Context, Node, SingleThreadedExecutor
from teleopctl.testing import RosGraph


@pytest.fixture
def context(ros: RosGraph) -> Iterator[Context]:
    del ros  # the fixture makes this process join the graph
    context = Context()
    context.init([])
    yield context
    context.try_shutdown()


@pytest.fixture
def executor(context: Context) -> Iterator[SingleThreadedExecutor]:
    executor = SingleThreadedExecutor(context=context)
    yield executor
    executor.shutdown()


@pytest.fixture
def make_node(context: Context, executor: SingleThreadedExecutor) -> Iterator[Callable[..., Node]]:
    """Fixture: function that makes nodes and adds them to the executor."""
    nodes = []

    def make(name: str = "tester", **options: Any) -> Node:
        node = Node(name, context=context, **options)
        executor.add_node(node)
        nodes.append(node)
        return node

    yield make
    for node in nodes:
        node.destroy_node()


@pytest.fixture
def spin_until(executor: SingleThreadedExecutor) -> Callable[..., None]:
    """Fixture: function that spins until a condition is true, and fails after a timeout."""

    def spin(condition: Callable[[], object], timeout_s: float = 10.0) -> None:
        deadline = time.monotonic() + timeout_s
        while not condition():
            left = deadline - time.monotonic()
            assert left > 0, "the condition did not come true in time"
            executor.spin_once(left)

    return spin
