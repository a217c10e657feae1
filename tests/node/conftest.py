"""A context of its own for each test, joined to the test's router and domain."""

import pytest

from teleopctl.node import Context, Node, SingleThreadedExecutor


@pytest.fixture
def context(ros, monkeypatch):
    for name, value in ros.env.items():
        monkeypatch.setenv(name, value)
    context = Context()
    context.init([])
    yield context
    context.try_shutdown()


@pytest.fixture
def executor(context):
    executor = SingleThreadedExecutor(context=context)
    yield executor
    executor.shutdown()


@pytest.fixture
def make_node(context, executor):
    """Make nodes that the executor serves."""
    nodes = []

    def make(name="tester", **options):
        node = Node(name, context=context, **options)
        executor.add_node(node)
        nodes.append(node)
        return node

    yield make
    for node in nodes:
        node.destroy_node()


@pytest.fixture
def spin_until(executor):
    """Run callbacks until a condition holds; fail when it does not within the deadline."""

    def spin(condition, timeout_s=10.0):
        import time

        deadline = time.monotonic() + timeout_s
        while not condition():
            left = deadline - time.monotonic()
            assert left > 0, "the condition did not come true in time"
            executor.spin_once(left)

    return spin
