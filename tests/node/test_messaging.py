"""Topics and services between nodes."""

import threading
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import (
    DurabilityPolicy,
    Future,
    MultiThreadedExecutor,
    NewestMessage,
    Node,
    Parameter,
    QoSProfile,
    ServiceUnavailableError,
)
from teleopctl.node.endpoints import client as clients
from teleopctl.node.values.exceptions import InvalidHandle
from teleopctl.testing import eventually

STRING = get_message("std_msgs/msg/String")
CLOCK = get_message("rosgraph_msgs/msg/Clock")
ADD = get_service("example_interfaces/srv/AddTwoInts")
LATCHED = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_a_subscription_gets_what_is_published_in_order(make_node, spin_until):
    node = make_node()
    got = []
    node.create_subscription(STRING, "chatter", lambda message: got.append(message.data), 10)
    publisher = node.create_publisher(STRING, "chatter", 10)
    for number in range(10):
        publisher.publish(STRING(data=str(number)))
    spin_until(lambda: len(got) == 10)
    assert got == [str(number) for number in range(10)]


def test_a_clock_that_is_read_on_demand_has_the_newest_time(make_node):
    publisher = make_node().create_publisher(CLOCK, "/clock", 10)
    given = [Parameter("use_sim_time", value=True)]
    node = make_node("reader", parameter_overrides=given)
    node._time_source.read_on_demand()
    for sec in (100, 7):
        message = CLOCK()
        message.clock.sec = sec

        def has_come(message=message):
            publisher.publish(message)
            return node.get_clock().now().nanoseconds == message.clock.sec * 10**9

        eventually(has_come)


def test_a_publisher_knows_by_event_whether_it_has_subscribers(make_node):
    node = make_node()
    publisher = node.create_publisher(STRING, "chatter", 10)
    assert not publisher.has_subscribers
    subscription = node.create_subscription(STRING, "chatter", lambda _: None, 10)
    eventually(lambda: publisher.has_subscribers)
    node.destroy_subscription(subscription)
    eventually(lambda: not publisher.has_subscribers)


def test_a_full_queue_loses_its_oldest(make_node, spin_until):
    node = make_node()
    got: list[Any] = []
    subscription = node.create_subscription(STRING, "chatter", got.append, 3)
    publisher = node.create_publisher(STRING, "chatter", 10)
    for number in range(9):
        publisher.publish(STRING(data=str(number)))
    assert subscription.pending() == 3
    spin_until(lambda: len(got) == 3)
    assert [message.data for message in got] == ["6", "7", "8"]


def test_the_second_argument_of_a_callback_tells_of_the_message(make_node, spin_until):
    node = make_node()
    got = []
    node.create_subscription(STRING, "chatter", lambda message, info: got.append(info), 10)
    publisher = node.create_publisher(STRING, "chatter", 10)
    publisher.publish(STRING(data="x"))
    publisher.publish(STRING(data="y"))
    spin_until(lambda: len(got) == 2)
    assert [info["publication_sequence_number"] for info in got] == [1, 2]
    assert got[0]["publisher_gid"] == publisher.gid
    assert 0 < got[0]["source_timestamp"] <= got[0]["received_timestamp"]


def test_a_late_subscriber_gets_the_latched_messages(make_node, spin_until):
    node = make_node()
    publisher = node.create_publisher(STRING, "description", LATCHED)
    for text in ("old", "newer", "newest"):
        publisher.publish(STRING(data=text))
    got = []
    node.create_subscription(STRING, "description", lambda m: got.append(m.data), LATCHED)
    spin_until(lambda: len(got) == 2)
    assert got == ["newer", "newest"]


def test_a_raw_subscription_gets_the_cdr_bytes(make_node, spin_until):
    node = make_node()
    got: list[Any] = []
    node.create_subscription(STRING, "chatter", got.append, 10, raw=True)
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="hi"))
    spin_until(lambda: got)
    assert got == [bytes.fromhex("0001000003000000686900")]


def test_an_immediate_subscription_needs_no_executor(context):
    import threading

    node = Node("tester", context=context)
    arrived = threading.Event()
    node.create_subscription(STRING, "chatter", lambda _: arrived.set(), 10, immediate=True)
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="x"))
    assert arrived.wait(10)
    node.destroy_node()


def test_the_newest_message_is_kept_until_it_is_read(make_node):
    node, talker = make_node("reader"), make_node("talker")
    newest = NewestMessage(node, STRING, "chatter")
    assert newest.read() is None
    publisher = talker.create_publisher(STRING, "chatter", 10)
    for number in range(3):
        publisher.publish(STRING(data=str(number)))
    read: list[str] = []

    def look():
        if (message := newest.read()) is not None:
            read.append(message.data)
        return read and read[-1] == "2"

    eventually(look)
    assert newest.read() is None
    newest.pause()
    publisher.publish(STRING(data="3"))
    assert newest.read() is None
    publisher.publish(STRING(data="2"))
    read.clear()
    eventually(look)
    node.destroy_subscription(newest)
    eventually(lambda: not node.graph().subscriptions("/chatter"))


def test_a_message_of_another_type_is_refused(make_node):
    publisher = make_node().create_publisher(STRING, "chatter", 10)
    with pytest.raises(TypeError):
        publisher.publish(get_message("std_msgs/msg/Bool")())


@pytest.mark.parametrize("qos", [10, LATCHED], ids=["volatile", "latched"])
def test_a_publisher_may_be_destroyed_while_another_thread_publishes(make_node, qos):
    """Zenoh refuses to undeclare a publisher of which a `put` is under way."""
    node, listener = make_node("talker"), make_node("listener")
    listener.create_subscription(STRING, "chatter", lambda _: None, qos)
    for _ in range(20):
        publisher = node.create_publisher(STRING, "chatter", qos)
        published, ends = threading.Event(), list[InvalidHandle]()

        def publish(publisher=publisher, published=published, ends=ends):
            try:
                while True:
                    publisher.publish(STRING(data="x" * 1000))
                    published.set()
            except InvalidHandle as error:
                ends.append(error)

        thread = threading.Thread(target=publish)
        thread.start()
        assert published.wait(10)
        node.destroy_publisher(publisher)
        thread.join()
        assert len(ends) == 1
        del publisher, publish
    assert node.count_publishers("chatter") == 0


def test_a_destroyed_publisher_says_so(make_node):
    node = make_node()
    publisher = node.create_publisher(STRING, "chatter", 10)
    assert node.destroy_publisher(publisher)
    with pytest.raises(InvalidHandle):
        publisher.publish(STRING())


def test_names_are_remapped(make_node):
    node = make_node(cli_args=["--ros-args", "-r", "chatter:=speech", "-r", "__ns:=/left"])
    assert node.get_fully_qualified_name() == "/left/tester"
    assert node.create_publisher(STRING, "chatter", 10).topic_name == "/left/speech"


def test_a_garbage_sample_is_dropped_and_the_next_one_arrives(make_node, context, spin_until):
    node = make_node()
    got: list[Any] = []
    subscription = node.create_subscription(STRING, "chatter", got.append, 10)
    context.session.put(subscription.key, b"\x00\x01\x00\x00\xff\xff\xff\xff")
    node.create_publisher(STRING, "chatter", 10).publish(STRING(data="x"))
    spin_until(lambda: got)
    assert (subscription.refusals.count, got[0].data) == (1, "x")


def test_a_service_answers(make_node, executor):
    node = make_node()

    def add(request, response):
        response.sum = request.a + request.b
        return response

    node.create_service(ADD, "add", add)
    client = node.create_client(ADD, "add")
    assert client.wait_for_service(timeout_sec=10)
    future = client.call_async(ADD.Request(a=20, b=22))
    executor.spin_until_future_complete(future, 10)
    assert future.result().sum == 42


def test_a_coroutine_may_serve_and_await_another_service(make_node, executor):
    node = make_node()

    def add(request, response):
        response.sum = request.a + request.b
        return response

    inner = node.create_client(ADD, "inner")

    async def outer(request, response):
        answer = await inner.call_async(request)
        response.sum = 10 * answer.sum
        return response

    node.create_service(ADD, "inner", add)
    node.create_service(ADD, "outer", outer)
    client = node.create_client(ADD, "outer")
    assert inner.wait_for_service(timeout_sec=10)
    assert client.wait_for_service(timeout_sec=10)
    future = client.call_async(ADD.Request(a=1, b=2))
    executor.spin_until_future_complete(future, 10)
    assert future.result().sum == 30


def test_a_program_may_send_the_response_of_a_service_itself(make_node, executor):
    node = make_node()
    service = node.create_service(ADD, "add", lambda _, response: response)
    send = service.send_response

    def send_more(response, header):
        response.sum += 40
        send(response, header)

    service.send_response = send_more
    future = node.create_client(ADD, "add").call_async(ADD.Request())
    executor.spin_until_future_complete(future, 10)
    assert future.result().sum == 40


def test_a_service_may_be_called_inside_a_callback(make_node, spin_until, context):
    node = make_node()
    server = Node("server", context=context)

    def add(request, response):
        response.sum = request.a + request.b
        return response

    server.create_service(ADD, "add", add, immediate=True)
    client = node.create_client(ADD, "add")
    assert client.wait_for_service(timeout_sec=10)
    sums = []
    node.create_timer(0.001, lambda: sums.append(client.call(ADD.Request(a=1, b=1), 10).sum))
    spin_until(lambda: sums)
    assert sums[0] == 2
    server.destroy_node()


def test_a_request_that_nobody_serves_stays_pending(make_node, executor):
    client = make_node().create_client(ADD, "nobody")
    future = client.call_async(ADD.Request())
    # It is known by now that nobody is there: who asks for that hears of it …
    with pytest.raises(ServiceUnavailableError, match="/nobody"):
        client.call_async(ADD.Request()).wait_for_response()
    # … and who awaits the answer goes on waiting.
    executor.spin_until_future_complete(future, 0.05)
    assert not future.done()
    assert client.call(ADD.Request(), timeout_sec=0.05) is None
    client.remove_pending_request(future)


def test_an_answer_that_comes_after_its_request_was_given_up_is_reported(
    make_node, executor, monkeypatch, capsys
):
    # The console keeps the stream of its first line, which is that of another test.
    monkeypatch.setattr("teleopctl.node.values.logging._console", None)
    node = make_node()
    asked: list[Any] = []
    # A server that spins, and answers nothing.
    service = node.create_service(ADD, "slow", lambda request, response: response)
    service.send_response = lambda response, header: asked.append(header)
    client = node.create_client(ADD, "slow")
    assert client.wait_for_service(timeout_sec=10)
    monkeypatch.setattr(clients, "TIME_LIMITS", ShortLimits())
    future = client.call_async(ADD.Request())
    given_up: Future[None] = Future(executor=executor)
    future.on_unanswered(lambda: given_up.set_result(None))
    executor.spin_until_future_complete(given_up, 10)
    assert given_up.done()
    assert not future.done()
    assert "dropped an answer of '/slow': it did not come while" in capsys.readouterr().err


class ShortLimits:
    def next_s(self, service: str) -> float:
        return 0.2


def test_a_node_that_awaits_an_answer_outlives_a_missing_server(make_node, spin_until):
    node = make_node()
    client = node.create_client(ADD, "nobody")
    asked, ticks = [], []

    async def ask():
        asked.append(client.call_async(ADD.Request()))
        await asked[-1]

    node.create_timer(0.001, ask)
    node.create_timer(0.001, lambda: ticks.append(1))
    spin_until(lambda: len(asked) >= 5 and len(ticks) >= 5)
    assert not any(future.done() for future in asked)


def test_a_callback_that_raises_ends_the_spinning(make_node, executor):
    node = make_node()

    def fail(_):
        raise ValueError("mine")

    node.create_subscription(STRING, "chatter", fail, 10)
    node.create_publisher(STRING, "chatter", 10).publish(STRING())
    with pytest.raises(ValueError, match="mine"):
        executor.spin_once(10)


def test_callbacks_of_a_reentrant_group_run_side_by_side(context):
    import threading

    from teleopctl.node import ReentrantCallbackGroup

    node = Node("tester", context=context)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    both_inside = threading.Barrier(2)
    done = []

    def wait_for_the_other(_):
        both_inside.wait(10)
        done.append(1)
        if len(done) == 2:
            ended.set_result(None)

    ended: Future[Any] = Future()
    group = ReentrantCallbackGroup()
    node.create_subscription(STRING, "chatter", wait_for_the_other, 10, callback_group=group)
    publisher = node.create_publisher(STRING, "chatter", 10)
    publisher.publish(STRING())
    publisher.publish(STRING())
    executor.spin_until_future_complete(ended, 10)
    executor.shutdown()
    node.destroy_node()


def test_a_node_shows_and_leaves_the_graph(make_node, context):
    watcher = make_node("watcher")
    node = Node("shown", context=context, namespace="/deep")
    node.create_publisher(STRING, "chatter", 10)
    seen = context.watcher.wait_for(lambda g: "/deep/shown" in g.node_names(), 10)
    assert seen
    assert watcher.wait_for_match.__self__ is watcher
    assert context.watcher.wait_for(lambda g: len(g.publishers("/deep/chatter")) == 1, 10)
    node.destroy_node()
    assert context.watcher.wait_for(lambda g: "/deep/shown" not in g.node_names(), 10)
    assert context.watcher.wait_for(lambda g: not g.publishers("/deep/chatter"), 10)


def test_log_lines_are_published_on_rosout(make_node, spin_until):
    node = make_node("speaker")
    got: list[Any] = []
    make_node("listener").create_subscription(
        get_message("rcl_interfaces/msg/Log"), "/rosout", got.append, 10
    )
    node.get_logger().warning("careful")
    spin_until(lambda: any(log.msg == "careful" for log in got))
    log = next(log for log in got if log.msg == "careful")
    assert (log.level, log.name) == (30, "speaker")
    assert log.file.endswith("test_messaging.py")


def test_a_type_is_described_on_request(make_node, executor):
    make_node("knower")
    describe = get_service("type_description_interfaces/srv/GetTypeDescription")
    client = make_node("asker").create_client(describe, "/knower/get_type_description")
    assert client.wait_for_service(timeout_sec=10)
    future = client.call_async(
        describe.Request(type_name="std_msgs/msg/Header", include_type_sources=True)
    )
    executor.spin_until_future_complete(future, 10)
    answer = future.result()
    assert answer.successful
    described = answer.type_description
    assert [f.name for f in described.type_description.fields] == ["stamp", "frame_id"]
    assert [r.type_name for r in described.referenced_type_descriptions] == [
        "builtin_interfaces/msg/Time"
    ]


def test_spinning_once_gets_on_when_an_answer_has_come(make_node, executor):
    server = make_node("server")
    server.create_service(ADD, "add", lambda request, response: response)
    asker = make_node("asker")
    client = asker.create_client(ADD, "add")
    assert client.wait_for_service(10.0)
    executor.remove_node(server)
    serving = MultiThreadedExecutor(2, context=server.context)
    serving.add_node(server)
    thread = threading.Thread(target=serving.spin)
    thread.start()
    try:
        future = client.call_async(ADD.Request())
        # Without a timeout: nothing but the answer can end it.
        executor.spin_once()
        assert future.done()
    finally:
        serving.shutdown()
        thread.join()


def test_an_answer_that_came_before_the_spinning_is_noticed_once(make_node, executor):
    node = make_node()
    node.create_service(ADD, "add", lambda request, response: response, immediate=True)
    client = node.create_client(ADD, "add")
    assert client.wait_for_service(10.0)
    executor.remove_node(node)
    assert client.call_async(ADD.Request()).wait(10.0)
    assert client.pending() == 1
    executor.add_node(node)
    executor.spin_once()
    assert client.pending() == 0


def test_a_coroutine_begins_within_the_call_that_made_it(make_node, executor):
    node, steps = make_node(), []
    go_on: Future[Any] = Future()

    async def work():
        steps.append("begun")
        await go_on
        steps.append("ended")

    guard = node.create_guard_condition(work)
    guard.trigger()
    executor.spin_once(10.0)
    assert steps == ["begun"]
    go_on.set_result(None)
    executor.spin_once(10.0)
    assert steps == ["begun", "ended"]


def test_a_guard_condition_that_its_node_destroys_calls_nothing_more(make_node, executor):
    node, calls = make_node(), []
    guard = node.create_guard_condition(lambda: calls.append("destroyed"))
    guard.trigger()
    assert node.destroy_guard_condition(guard)
    guard.trigger()
    assert not node.destroy_guard_condition(guard)
    node.create_guard_condition(lambda: calls.append("kept")).trigger()
    executor.spin_once(10.0)
    assert calls == ["kept"]


def test_what_ends_the_making_of_a_node_is_not_hidden_by_its_own_clean_up(context, monkeypatch):
    class Owner(Node):
        def __init__(self):
            super().__init__("owner", context=context)
            self.loop = object()

        def destroy_node(self):
            del self.loop
            super().destroy_node()

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Node, "_start_parameters", interrupted)
        with pytest.raises(KeyboardInterrupt):
            Owner()
    assert "owner" not in Node("observer", context=context).get_node_names()


def test_the_graph_is_asked_by_names_and_nothing_else(make_node):
    node = make_node()
    for ask in (node.count_publishers, node.count_clients, node.get_subscriptions_info_by_topic):
        with pytest.raises(ValueError, match="'42' is invalid"):
            ask("42")
        with pytest.raises(TypeError):
            ask(42)


def test_the_log_is_no_publisher_of_the_programs_own(make_node):
    node = make_node()
    assert [publisher.topic for publisher in node.publishers] == ["/parameter_events"]
    assert node.count_publishers("/rosout") == 1
    node.destroy_node()
