"""Executors under load: fairness, bounds, destruction, exceptions, shutdown."""

import asyncio
import concurrent.futures
import contextlib
import threading
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.node import (
    Context,
    MultiThreadedExecutor,
    MutuallyExclusiveCallbackGroup,
    Node,
    SingleThreadedExecutor,
    get_default_context,
    spin,
)
from teleopctl.node.values.exceptions import (
    ExternalShutdownException,
    RCLError,
    ROSInterruptException,
)
from teleopctl.node.values.future import Future

STRING = get_message("std_msgs/msg/String")
ADD = get_service("example_interfaces/srv/AddTwoInts")


def test_a_timer_that_is_always_due_leaves_room_for_messages(make_node, spin_until):
    node = make_node()
    got: list[Any] = []
    node.create_timer(0.0, lambda: None)
    node.create_subscription(STRING, "chatter", got.append, 10)
    node.create_publisher(STRING, "chatter", 10).publish(STRING())
    spin_until(lambda: got)


def test_timers_that_are_always_due_take_turns(make_node, spin_until):
    node = make_node()
    calls = []
    node.create_timer(0.0, lambda: calls.append(1))
    node.create_timer(0.0, lambda: calls.append(2))
    spin_until(lambda: len(calls) >= 10)
    assert set(calls) == {1, 2}


def test_what_a_slow_callback_of_a_pool_misses_falls_out_of_the_queue(context):
    node = Node("tester", context=context)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    inside, go_on, done = threading.Event(), threading.Event(), Future[Any]()
    got = []

    def slow(message):
        got.append(message.data)
        inside.set()
        go_on.wait(10)
        if len(got) == 4:
            done.set_result(None)

    node.create_subscription(STRING, "chatter", slow, 3)
    publisher = node.create_publisher(STRING, "chatter", 10)
    publisher.publish(STRING(data="0"))
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    assert inside.wait(10)
    for number in range(1, 100):
        publisher.publish(STRING(data=str(number)))
    go_on.set()
    assert done.wait(10)
    executor.shutdown()
    spinner.join(10)
    assert got == ["0", "97", "98", "99"]
    node.destroy_node()


def test_a_late_timer_of_a_pool_does_not_pile_up(context):
    node = Node("tester", context=context)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    group = MutuallyExclusiveCallbackGroup()
    inside, go_on, ticked = threading.Event(), threading.Event(), Future[Any]()
    calls = []

    def block(_):
        inside.set()
        go_on.wait(10)

    def tick():
        calls.append(1)
        if len(calls) == 2:
            ticked.set_result(None)

    node.create_subscription(STRING, "chatter", block, 10, callback_group=group)
    node.create_publisher(STRING, "chatter", 10).publish(STRING())
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    assert inside.wait(10)
    node.create_timer(0.0, tick, group)
    executor.wake()
    assert not ticked.wait(0.05)
    assert not calls
    go_on.set()
    assert ticked.wait(10)
    executor.shutdown()
    spinner.join(10)
    node.destroy_node()


def test_the_queue_of_an_executor_stays_short_when_nodes_come_and_go(context):
    nodes = [Node(name, context=context) for name in ("one", "two")]
    executor = SingleThreadedExecutor(context=context)
    got: list[Any] = []
    for node in nodes:
        node.create_subscription(STRING, "chatter", got.append, 1000)
        node.create_subscription(STRING, "chatter", got.append, 1000)
    publisher = nodes[0].create_publisher(STRING, "chatter", 10)
    for _ in range(20):
        publisher.publish(STRING())
    for _ in range(20):
        for node in nodes:
            executor.add_node(node)
            executor.spin_once(0)
            executor.remove_node(node)
    assert len(got) == 40
    assert executor._queue.qsize() <= 5
    for node in nodes:
        node.destroy_node()


def test_only_the_node_that_is_served_is_called_back(context):
    one, two = (Node(name, context=context) for name in ("one", "two"))
    executor = SingleThreadedExecutor(context=context)
    got = []
    one.create_subscription(STRING, "chatter", lambda _: got.append("one"), 10)
    two.create_subscription(STRING, "chatter", lambda _: got.append("two"), 10)
    executor.add_node(one)
    one.create_publisher(STRING, "chatter", 10).publish(STRING())
    executor.remove_node(one)
    executor.add_node(two)
    executor.spin_once(0)
    executor.spin_once(0)
    assert got == ["two"]
    one.destroy_node()
    two.destroy_node()


def test_a_node_moves_to_the_executor_that_gets_it_last(make_node, context, executor):
    node = make_node()
    other = SingleThreadedExecutor(context=context)
    other.add_node(node)
    assert node.executor is other
    assert node not in executor.get_nodes()
    other.shutdown()


def test_an_object_that_forwards_to_a_node_is_served_as_the_node(context):
    class Forwarding:
        def __init__(self) -> None:
            self.inner = Node("inner", context=context)
            self.inner.create_timer(0.001, self.tick)

        def tick(self) -> None:
            context.try_shutdown()

        def __getattr__(self, name: str) -> Any:
            return getattr(self.inner, name)

    forwarding: Any = Forwarding()
    spin(forwarding, SingleThreadedExecutor(context=context))
    assert not context.ok()


def test_a_node_that_is_given_an_executor_is_served_by_it_alone(make_node, context, executor):
    node = make_node()
    other = SingleThreadedExecutor(context=context)
    node.executor = other
    assert (executor.get_nodes(), other.get_nodes()) == ([], [node])
    node.executor = None
    assert (node.executor, other.get_nodes()) == (None, [])


def test_an_ended_future_does_not_cut_the_next_wait_short(make_node, executor):
    node = make_node()
    future: Future[Any] = Future()
    node.create_guard_condition(lambda: future.set_result(1)).trigger()
    executor.spin_until_future_complete(future, 10)
    node.create_subscription(STRING, "chatter", lambda m: got.append(m), 10)
    got: list[Any] = []
    publisher = node.create_publisher(STRING, "chatter", 10)
    threading.Timer(0.02, lambda: publisher.publish(STRING())).start()
    executor.spin_once(10)
    assert got


def test_a_destroyed_subscription_calls_back_no_more(make_node, executor):
    node = make_node()
    got = []

    def receive(message):
        got.append(message)
        node.destroy_subscription(subscription)

    subscription = node.create_subscription(STRING, "chatter", receive, 10)
    publisher = node.create_publisher(STRING, "chatter", 10)
    publisher.publish(STRING())
    publisher.publish(STRING())
    executor.spin_once(10)
    executor.spin_once(0)
    assert len(got) == 1


def test_a_node_may_destroy_itself_while_it_is_spun(make_node, executor):
    node = make_node()
    ended: Future[Any] = Future()

    def leave(_):
        node.destroy_node()
        ended.set_result(None)

    node.create_subscription(STRING, "chatter", leave, 10)
    node.create_publisher(STRING, "chatter", 10).publish(STRING())
    executor.spin_until_future_complete(ended, 10)
    assert executor.get_nodes() == []


def test_leaving_the_program_in_a_callback_of_a_pool_ends_the_spinning(context):
    node = Node("tester", context=context)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)

    def leave():
        raise SystemExit(3)

    node.create_timer(0.0, leave)
    with pytest.raises(SystemExit):
        executor.spin()
    executor.shutdown()
    node.destroy_node()


def test_callbacks_of_an_answer_run_where_the_node_is_spun(make_node, spin_until):
    node = make_node()

    def add(request, response):
        response.sum = request.a + request.b
        return response

    node.create_service(ADD, "add", add, immediate=True)
    client = node.create_client(ADD, "add")
    assert client.wait_for_service(10)
    threads = []
    future = client.call_async(ADD.Request())
    future.add_done_callback(lambda _: threads.append(threading.current_thread()))
    assert future.wait(10)
    assert not threads
    spin_until(lambda: threads)
    assert threads == [threading.current_thread()]


def test_a_coroutine_task_takes_keywords_and_ends_with_its_value(executor):
    async def work(first, *, second):
        return first + second

    task = executor.create_task(work, 1, second=2)
    executor.spin_until_future_complete(task, 10)
    assert task.result() == 3


def test_a_timer_goes_on_when_simulated_time_starts_over(make_node, spin_until):
    node = make_node()
    clock = node.get_clock()
    clock.set_simulated(True)
    clock.set_simulated_time(100 * 10**9)
    calls = []
    node.create_timer(1.0, lambda: calls.append(clock.now().nanoseconds))
    clock.set_simulated_time(0)
    clock.set_simulated_time(10**9)
    spin_until(lambda: calls)
    assert calls == [10**9]


def test_shutdown_wakes_a_wait_for_a_service(context):
    node = Node("tester", context=context)
    client = node.create_client(ADD, "nobody")
    answers = []
    waiting = threading.Thread(target=lambda: answers.append(client.wait_for_service()))
    waiting.start()
    context.end_by_signal()
    waiting.join(10)
    assert answers == [False]


def test_a_signal_ends_a_call_that_waits(context):
    node = Node("tester", context=context)
    asked = threading.Event()

    def never(request, response):
        raise AssertionError

    # Nobody spins this node: the request stays unanswered.
    node.create_service(ADD, "add", never)
    client = node.create_client(ADD, "add")
    assert client.wait_for_service(10)
    raised = []

    def call():
        asked.set()
        try:
            client.call(ADD.Request())
        except ExternalShutdownException as error:
            raised.append(error)

    waiting = threading.Thread(target=call)
    waiting.start()
    assert asked.wait(10)
    context.end_by_signal()
    waiting.join(10)
    assert raised


def test_a_rate_says_when_it_was_cut_short(context):
    node = Node("tester", context=context)
    rate = node.create_rate(0.001)
    raised = []

    def sleep():
        try:
            rate.sleep()
        except ROSInterruptException as error:
            raised.append(error)

    sleeping = threading.Thread(target=sleep)
    sleeping.start()
    context.end_by_signal()
    sleeping.join(10)
    assert raised


def test_shutdown_after_a_signal_completes_it(ros):
    context = Context()
    context.init([])
    Node("tester", context=context)
    context.end_by_signal()
    assert not context.ok()
    context.shutdown()
    with pytest.raises(RuntimeError):
        context.shutdown()


def test_logging_and_setting_parameters_outlive_shutdown(context):
    node = Node("tester", context=context)
    publisher = node.create_publisher(STRING, "chatter", 10)
    context.shutdown()
    assert node.get_logger().info("still here")
    node.declare_parameter("late", 1)
    with pytest.raises(RCLError, match="Failed to publish: publisher's context is invalid") as info:
        publisher.publish(STRING())
    assert not isinstance(info.value, ExternalShutdownException)
    node.destroy_node()


def test_a_node_that_cannot_be_made_leaves_nothing_in_the_graph(context):
    with pytest.raises(Exception, match="use_sim_time"):
        Node("broken", context=context, cli_args=["--ros-args", "-p", "use_sim_time:=5"])
    assert "/broken" not in context.watcher.snapshot().node_names()


def test_the_first_look_at_the_graph_is_complete(ros, context):
    other = Context()
    other.init([])
    node = Node("there", context=other)
    Node("looker", context=context)
    assert "/there" in context.watcher.snapshot().node_names()
    node.destroy_node()
    other.shutdown()


@pytest.mark.parametrize("spins_already", [True, False])
def test_what_a_thread_of_a_node_met_is_raised_by_whoever_spins_it(
    make_node, context, spins_already
):
    node = make_node("broken")
    executor = SingleThreadedExecutor(context=context)
    if spins_already:
        executor.add_node(node)
    thread = threading.Thread(target=node.fail, args=(ArithmeticError("physics broke down"),))
    thread.start()
    thread.join()
    if not spins_already:
        executor.add_node(node)
    with pytest.raises(ArithmeticError, match="physics broke down"):
        executor.spin_once(10)


def test_the_threads_of_a_pool_run_before_anything_is_interrupted(context):
    before = set(threading.enumerate())
    executor = MultiThreadedExecutor(3, context=context)
    try:
        assert len(set(threading.enumerate()) - before) == 3
    finally:
        executor.shutdown()


def test_shutdown_waits_for_callbacks_that_run_as_long_as_it_is_told(context):
    executor = MultiThreadedExecutor(2, context=context)
    runs, may_end, ended = threading.Event(), threading.Event(), threading.Event()

    def work():
        runs.set()
        assert may_end.wait(20)
        ended.set()

    executor.create_task(work)
    spinning = threading.Thread(target=executor.spin)
    spinning.start()
    assert runs.wait(20)
    assert not executor.shutdown(0.01)
    may_end.set()
    assert executor.shutdown(20)
    assert ended.is_set()
    spinning.join(20)


@pytest.mark.parametrize("make", [asyncio.new_event_loop, concurrent.futures.Future, Future])
def test_an_executor_spins_until_a_future_of_any_kind_ends(make_node, executor, make):
    node = make_node()
    with contextlib.ExitStack() as stack:
        made = make()
        if isinstance(made, asyncio.AbstractEventLoop):
            # Its loop does not run: what ends it is a callback of the executor.
            stack.callback(made.close)
            made = made.create_future()
        node.create_timer(0.001, lambda: made.done() or made.set_result(3))
        executor.spin_until_future_complete(made, 10.0)
        assert made.result() == 3


def test_a_future_that_a_pool_of_another_thread_ends_wakes_the_executor(make_node, executor):
    make_node()
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        begun = threading.Event()
        future = pool.submit(begun.wait, 10.0)
        executor.enqueue(begun.set)
        executor.spin_until_future_complete(future, 10.0)
        assert future.result()
    cancelled: concurrent.futures.Future[None] = concurrent.futures.Future()
    cancelled.cancel()
    executor.spin_until_future_complete(cancelled, 10.0)


def test_the_default_context_that_is_shut_down_makes_room_for_a_new_one():
    first = get_default_context(shutting_down=True)
    second = get_default_context()
    assert second is not first
    assert get_default_context() is second


def test_the_parameters_of_a_node_are_a_mapping(make_node):
    node = make_node(allow_undeclared_parameters=True)
    node.declare_parameter("teleop.walk.type", "topic")
    assert sorted(node._parameters.keys()) == [
        "start_type_description_service",
        "teleop.walk.type",
        "use_sim_time",
    ]
    assert node._parameters["teleop.walk.type"].value == "topic"
    assert node._parameters.get("unknown") is None


def test_a_request_is_found_by_its_number_until_its_response(make_node, spin_until):
    node = make_node()
    node.create_service(ADD, "add", lambda _, response: response)
    client = node.create_client(ADD, "add")
    assert client.wait_for_service(10.0)
    number, future = client.send(ADD.Request())
    assert client.get_pending_request(number) is future
    spin_until(future.done)
    with pytest.raises(KeyError):
        client.get_pending_request(number)
