"""Fixtures: server and client of an action in one process."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from teleopctl.interfaces import get_action
from teleopctl.node import ActionClient, ActionServer, Node

FIBONACCI = get_action("example_interfaces/action/Fibonacci")


@pytest.fixture
def node(make_node: Callable[..., Node]) -> Node:
    return make_node()


@pytest.fixture
def serve(node: Node) -> Callable[..., ActionServer[Any, Any, Any]]:
    """Fixture: function that makes a server of /fib; by default its goals succeed at once."""

    def make(
        execute: Callable[..., object] | None = None, **options: Any
    ) -> ActionServer[Any, Any, Any]:
        def succeed(goal: Any) -> Any:
            goal.succeed()
            return FIBONACCI.Result(sequence=range(goal.request.order))

        return ActionServer(node, FIBONACCI, "fib", execute or succeed, **options)

    return make


@pytest.fixture
def client(node: Node) -> Iterator[ActionClient[Any, Any, Any]]:
    with ActionClient(node, FIBONACCI, "fib") as client:
        yield client


@pytest.fixture
def send(
    client: ActionClient[Any, Any, Any], spin_until: Callable[..., None]
) -> Callable[..., Any]:
    """Fixture: function that sends a goal, waits for the response and returns the goal handle."""

    def send_and_wait(order: int = 3, **options: Any) -> Any:
        assert client.wait_for_server(10)
        future = client.send_goal_async(FIBONACCI.Goal(order=order), **options)
        spin_until(future.done)
        return future.result()

    return send_and_wait


@pytest.fixture
def result_of(spin_until: Callable[..., None]) -> Callable[[Any], Any]:
    """Fixture: function that requests the result of a goal and returns the response."""

    def wait(handle: Any) -> Any:
        future = handle.get_result_async()
        spin_until(future.done)
        return future.result()

    return wait


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[[], str]:
    """Fixture: function that returns new output on stderr since its last call, with logs."""
    # The log console keeps the stream of its first use.
    monkeypatch.setattr("teleopctl.node.values.logging._console", None)
    return lambda: capsys.readouterr().err
