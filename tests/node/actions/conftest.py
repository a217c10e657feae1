"""A server and a client of one action, in one process."""

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
    """Make a server of /fib; its goals succeed at once unless told otherwise."""

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
    """Send a goal and return its handle when the server has answered."""

    def send_and_wait(order: int = 3, **options: Any) -> Any:
        assert client.wait_for_server(10)
        future = client.send_goal_async(FIBONACCI.Goal(order=order), **options)
        spin_until(future.done)
        return future.result()

    return send_and_wait


@pytest.fixture
def result_of(spin_until: Callable[..., None]) -> Callable[[Any], Any]:
    """Return the answer to a request for the result of a goal."""

    def wait(handle: Any) -> Any:
        future = handle.get_result_async()
        spin_until(future.done)
        return future.result()

    return wait


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[[], str]:
    """Return what has been written to stderr since the last time, logs included."""
    # The console of the logs keeps the stream that it found when it was first used.
    monkeypatch.setattr("teleopctl.node.values.logging._console", None)
    return lambda: capsys.readouterr().err
