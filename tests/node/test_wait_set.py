"""Wait sets: messages, triggers and events that a program waits for by hand."""

import threading
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import (
    Clock,
    ClockType,
    EventHandle,
    GuardHandle,
    QoSProfile,
    ROSClock,
    TimerCancelledError,
    WaitSet,
    create_polled_client,
    create_polled_service,
    create_polled_subscription,
    create_polled_timer,
)

STRING = get_message("std_msgs/msg/String")
ADD = get_service("example_interfaces/srv/AddTwoInts")
QOS = QoSProfile(depth=10)
LONG_NS = 10 * 10**9


@pytest.fixture
def wait_set(context):
    return WaitSet(context)


def test_a_message_is_waited_for_and_taken(make_node, wait_set):
    node = make_node()
    handle = create_polled_subscription(node, STRING, "chatter", QoSProfile(depth=10))
    index = wait_set.add_subscription(handle)
    wait_set.wait(0)
    assert not wait_set.is_ready("subscription", index)
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="one"))
    wait_set.wait(LONG_NS)
    assert wait_set.get_ready_entities("subscription") == [handle.pointer]
    taken = handle.take_message(STRING, raw=False)
    assert taken is not None
    message, info = taken
    assert (message.data, info["publication_sequence_number"]) == ("one", 1)
    assert handle.take_message(STRING, raw=False) is None
    handle.destroy_when_not_in_use()


def test_a_subscription_of_a_node_is_not_served_while_somebody_waits_by_hand(
    make_node, wait_set, executor
):
    node, served = make_node(), list[Any]()
    subscription = node.create_subscription(STRING, "chatter", served.append, 10)
    publisher = node.create_publisher(STRING, "chatter", 10)
    wait_set.add_subscription(subscription.handle)
    publisher.publish(STRING(data="one"))
    wait_set.wait(LONG_NS)
    taken = subscription.handle.take_message(STRING, raw=True)
    assert taken is not None
    assert taken[0].endswith(b"one\0")
    publisher.publish(STRING(data="two"))
    executor.spin_once(10.0)
    while not served:
        executor.spin_once(10.0)
    assert [message.data for message in served] == ["two"]


def test_a_trigger_is_seen_once_and_also_when_it_comes_before_the_wait(context, wait_set):
    guard = GuardHandle(context.handle)
    index = wait_set.add_guard_condition(guard)
    guard.trigger_guard_condition()
    wait_set.wait(LONG_NS)
    assert wait_set.is_ready("guard_condition", index)
    wait_set.wait(0)
    assert not wait_set.is_ready("guard_condition", index)
    threading.Thread(target=guard.trigger_guard_condition).start()
    wait_set.wait(-1)
    assert wait_set.is_ready("guard_condition", index)


def test_the_end_of_the_context_ends_a_wait(context, wait_set):
    wait_set.add_guard_condition(GuardHandle(context.handle))
    threading.Thread(target=context.try_shutdown).start()
    wait_set.wait(-1)


def test_an_event_is_waited_for_and_counted_from_the_last_time(make_node, wait_set):
    node = make_node()
    publisher = node.create_publisher(STRING, "chatter", 10)
    event = EventHandle(publisher, "matched")
    index = wait_set.add_event(event)
    node.create_subscription(STRING, "chatter", print, 10)
    wait_set.wait(LONG_NS)
    assert wait_set.is_ready("event", index)
    assert event.take_event() == (1, 1, 1, 1)
    assert event.take_event() == (1, 0, 1, 0)


def test_a_request_and_its_response_are_waited_for_and_taken(make_node, wait_set):
    node = make_node()
    service = create_polled_service(node, ADD, "add", QOS)
    client = create_polled_client(node, ADD, "add", QOS)
    requests, responses = wait_set.add_service(service), wait_set.add_client(client)
    assert node.create_client(ADD, "add").wait_for_service(10.0)
    assert client.service_server_is_available()
    assert (client.service_name, service.service_take_request(ADD.Request)) == (
        "/add",
        (None, None),
    )
    number = client.send_request(ADD.Request(a=2, b=3))
    wait_set.wait(LONG_NS)
    assert wait_set.is_ready("service", requests)
    assert not wait_set.is_ready("client", responses)
    request, header = service.service_take_request(ADD.Request)
    assert header is not None
    assert header.request_id.sequence_number == number
    assert 0 < header.source_timestamp <= header.received_timestamp
    service.service_send_response(ADD.Response(sum=request.a + request.b), header)
    wait_set.wait(LONG_NS)
    assert wait_set.get_ready_entities("client") == [client.pointer]
    info, response = client.take_response(ADD.Response)
    assert info is not None
    assert (info.request_id, response.sum) == (header.request_id, 5)
    assert client.take_response(ADD.Response) == (None, None)
    for handle in (client, service):
        handle.destroy_when_not_in_use()


def test_a_request_is_taken_by_hand_from_a_service_of_a_node(make_node, wait_set):
    node = make_node()
    service = node.create_service(ADD, "add", lambda _request, response: response)
    client = node.create_client(ADD, "add")
    wait_set.add_service(service.handle)
    answer = client.call_async(ADD.Request(a=1))
    wait_set.wait(LONG_NS)
    request, header = service.handle.service_take_request(ADD.Request)
    assert header is not None
    service.handle.service_send_response(ADD.Response(sum=request.a), header)
    assert answer.wait_until_answered(10.0) == ADD.Response(sum=1)


def test_a_wait_ends_when_a_timer_is_due_and_its_calls_are_counted_by_hand(wait_set):
    timer = create_polled_timer(Clock(clock_type=ClockType.STEADY_TIME), 1_000_000)
    index = wait_set.add_timer(timer)
    wait_set.wait(-1)
    assert wait_set.is_ready("timer", index)
    timer.call_timer()
    left_ns = timer.time_until_next_call()
    assert left_ns is not None
    assert left_ns <= timer.get_timer_period() == 1_000_000
    timer.cancel_timer()
    wait_set.wait(0)
    assert not wait_set.is_ready("timer", index)
    with pytest.raises(TimerCancelledError):
        timer.call_timer()


def test_a_wait_for_a_timer_follows_simulated_time(wait_set):
    clock = ROSClock()
    clock.set_simulated(True)
    timer = create_polled_timer(clock, 10**9)
    wait_set.add_timer(timer)
    wait_set.wait(0)
    assert not timer.is_timer_ready()
    threading.Thread(target=clock.set_simulated_time, args=(10**9,)).start()
    wait_set.wait(-1)
    assert wait_set.get_ready_entities("timer") == [timer.pointer]
    timer.destroy_when_not_in_use()


@pytest.mark.parametrize("autostart", [True, False])
def test_a_timer_starts_at_once_or_by_reset(wait_set, autostart):
    timer = create_polled_timer(Clock(), 1000, autostart=autostart)
    wait_set.add_timer(timer)
    assert timer.is_timer_canceled() is not autostart
    timer.reset_timer()
    wait_set.wait(-1)
    assert timer.is_timer_ready()
