"""Bytes that are no message, request, answer, token or time are refused, and life goes on."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import pytest
import zenoh

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import Context, Node, Parameter, SingleThreadedExecutor
from teleopctl.node.endpoints.subscription import Subscription
from teleopctl.node.values import logging
from teleopctl.node.values.exceptions import ContextEndedError
from teleopctl.testing import eventually
from teleopctl.wire import GraphWatcher, encode_attachment

STRING = get_message("std_msgs/msg/String")
CLOCK = get_message("rosgraph_msgs/msg/Clock")
TRIGGER = get_service("std_srvs/srv/Trigger")

GARBAGE = [b"", b"\x00", b"\x00\x01\x00\x00", b"\xff" * 64, b"\x00\x01\x00\x00\xff\xff\xff\xff"]
ATTACHMENTS = [None, b"", b"\x00" * 33, b"\xff" * 32, b"\xff" * 77]


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the nodes of this process log."""
    received: list[str] = []
    emit = logging.emit_log

    def listen(severity: Any, name: str, text: str, caller: Any, time_ns: int) -> None:
        received.append(text)
        emit(severity, name, text, caller, time_ns)

    monkeypatch.setattr(logging, "emit_log", listen)
    return received


def _clock(sec: int, nanosec: int, order: str = "<") -> bytes:
    return bytes([0, order == "<", 0, 0]) + struct.pack(f"{order}iI", sec, nanosec)


@pytest.mark.parametrize(
    "data",
    [
        *GARBAGE,
        _clock(-1, 0),
        _clock(-(2**31), 999_999_999),
        _clock(1, 1_000_000_000),
        _clock(1, 2**32 - 1),
        _clock(5, 0)[:-1],
        b"\x00\x07\x00\x00" + bytes(8),
        b"\x01\x01\x00\x00" + bytes(8),
    ],
)
def test_a_clock_that_tells_no_time_is_dropped_and_the_next_one_counts(
    make_node: Callable[..., Node],
    context: Context,
    spin_until: Callable[..., None],
    lines: list[str],
    data: bytes,
):
    node = make_node(parameter_overrides=[Parameter("use_sim_time", value=True)])
    ticks: list[int] = []
    node.create_timer(0.5, lambda: ticks.append(node.get_clock().now().nanoseconds))
    good = node.create_publisher(CLOCK, "/clock", 10)
    for _ in range(50):
        context.session.put(good.key, data)
    assert node.get_clock().now().nanoseconds == 0
    context.session.put(good.key, _clock(3, 0, ">"))
    spin_until(lambda: ticks)
    assert ticks[0] == 3_000_000_000
    assert len([line for line in lines if "/clock" in line]) == 1


@pytest.mark.parametrize("attachment", ATTACHMENTS)
def test_a_message_without_readable_attachment_is_dropped_where_it_is_asked_for(
    make_node: Callable[..., Node],
    context: Context,
    spin_until: Callable[..., None],
    attachment: bytes | None,
):
    node = make_node()
    got: list[Any] = []
    subscription: Subscription[Any] = node.create_subscription(
        STRING, "chatter", lambda message, info: got.append((message, info)), 10
    )
    context.session.put(subscription.key, b"\x00\x01\x00\x00\1\0\0\0\0", attachment=attachment)
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="x"))
    spin_until(lambda: got)
    assert (subscription.refusals.count, got[0][0].data) == (1, "x")


def test_a_callback_on_the_transports_thread_that_fails_each_time_reports_once_a_second(
    make_node: Callable[..., Node], lines: list[str]
):
    node = make_node()

    def fail(message: Any) -> None:
        raise ValueError(message.data)

    subscription: Subscription[Any] = node.create_subscription(
        STRING, "chatter", fail, 10, immediate=True
    )
    publisher = node.create_publisher(STRING, "chatter", 10)
    for _ in range(100):
        publisher.publish(STRING(data="x"))
    assert subscription.refusals.count == 100
    assert len([line for line in lines if "Traceback" in line]) <= 2


def test_a_callback_on_the_transports_thread_that_publishes_after_a_signal_does_not_fail(
    make_node: Callable[..., Node], lines: list[str]
):
    node = make_node()

    def publish(message: Any) -> None:
        raise ContextEndedError

    subscription: Subscription[Any] = node.create_subscription(
        STRING, "chatter", publish, 10, immediate=True
    )
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="x"))
    assert (subscription.refusals.count, lines) == (0, [])


@pytest.mark.parametrize("payload", [None, *GARBAGE])
@pytest.mark.parametrize("attachment", [None, b"\xff" * 32, encode_attachment(1, 2, bytes(16))])
def test_a_request_that_is_none_is_dropped_and_the_next_one_is_answered(
    make_node: Callable[..., Node],
    context: Context,
    executor: SingleThreadedExecutor,
    payload: bytes | None,
    attachment: bytes | None,
):
    node = make_node()
    adder = get_service("example_interfaces/srv/AddTwoInts")

    def add(request: Any, response: Any) -> Any:
        response.sum = request.a + request.b
        return response

    service = node.create_service(adder, "add", add)
    context.session.get(service.key, payload=payload, attachment=attachment)
    client = node.create_client(adder, "add")
    future = client.call_async(adder.Request(a=1, b=2))
    executor.spin_until_future_complete(future, 10)
    result = future.result()
    assert result is not None
    assert (result.sum, service.refusals.count) == (3, 1)


def test_an_answer_that_is_none_is_dropped_and_another_servers_counts(
    make_node: Callable[..., Node], context: Context, executor: SingleThreadedExecutor
):
    node = make_node()
    client = node.create_client(TRIGGER, "go")

    def answer_badly(query: zenoh.Query) -> None:
        assert query.attachment is not None
        query.reply(client.key, b"\xff", attachment=query.attachment)
        query.reply(client.key, b"\xff", attachment=b"")
        query.reply(client.key, b"\xff")

    hostile = context.session.declare_queryable(
        client.key, zenoh.handlers.Callback(answer_badly, indirect=False), complete=True
    )
    node.create_service(TRIGGER, "go", lambda _, response: response)
    future = client.call_async(TRIGGER.Request())
    executor.spin_until_future_complete(future, 10)
    assert future.exception() is None
    assert client.refusals.count == 3
    hostile.undeclare()


def test_tokens_that_cannot_be_read_are_counted_and_the_graph_goes_on(
    make_node: Callable[..., Node], context: Context
):
    prefix = f"@ros2_lv/{context.domain_id}"
    hostile = [
        context.session.liveliness().declare_token(f"{prefix}/{text}")
        for text in ("x", "0/0/0/NN", "z/1/1/MP/%/%/n/%t/T/RIHS01_0/::,::,,,", "z/a/b/NN/%/%/n")
    ]
    watcher = GraphWatcher(context.session, context.domain_id)
    make_node("honest")
    assert watcher.wait_for(lambda graph: graph.find_node("/honest"), 10)
    # What others say is received on another thread than one's own nodes.
    eventually(lambda: watcher.refusals.count == len(hostile), what="each refusal")
    watcher.close()


def test_requests_that_nobody_takes_fill_a_bounded_queue(
    make_node: Callable[..., Node], context: Context
):
    node = make_node()
    service = node.create_service(TRIGGER, "go", lambda _, response: response)
    for _ in range(1500):
        context.session.get(service.key, payload=b"\x00\x01\x00\x00\x00")
    assert service.pending() == 1000
    assert service.refusals.count == 500
