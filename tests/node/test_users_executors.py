"""Executors and callback groups of users, as ROS 2's own examples write them."""

import contextlib
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.node import (
    CallbackGroup,
    ConditionReachedException,
    Executor,
    MultiThreadedExecutor,
    MutuallyExclusiveCallbackGroup,
    SingleThreadedExecutor,
    TimeoutException,
)

STRING = get_message("std_msgs/msg/String")


class PriorityExecutor(Executor):
    """Runs the callbacks of some nodes in a pool of their own."""

    def __init__(self, *, context):
        super().__init__(context=context)
        self.preferred: set[object] = set()
        self.fast, self.slow = ThreadPoolExecutor(2), ThreadPoolExecutor(1)

    def spin_once(self, timeout_sec=None):
        try:
            handler, _, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
        except TimeoutException:
            return
        (self.fast if node in self.preferred else self.slow).submit(handler)

    def close(self):
        self.shutdown()
        self.fast.shutdown()
        self.slow.shutdown()


class ThrottledGroup(CallbackGroup):
    """Lets so many callbacks run until it gets more tokens."""

    def __init__(self, tokens):
        super().__init__()
        self.tokens = tokens

    def can_execute(self, entity):
        assert self.has_entity(entity)
        return self.tokens > 0

    def beginning_execution(self, entity):
        self.tokens -= 1
        return True

    def ending_execution(self, entity):
        """Nothing waits for it."""


def test_an_executor_of_a_users_calls_what_is_ready_where_it_likes(make_node, context):
    node, slow = make_node("fast"), make_node("slow")
    executor = PriorityExecutor(context=context)
    executor.preferred.add(node)
    for each in (node, slow):
        executor.add_node(each)
    threads: dict[str, threading.Thread] = {}
    slow.create_subscription(
        STRING, "words", lambda m: threads.setdefault(m.data, threading.current_thread()), 10
    )
    node.create_timer(0.01, lambda: threads.setdefault("timer", threading.current_thread()))
    publisher = node.create_publisher(STRING, "words", 10)
    publisher.publish(STRING(data="word"))
    while len(threads) < 2:
        executor.spin_once(10.0)
    executor.close()
    assert threads["word"] is not threads["timer"]
    assert threading.main_thread() not in threads.values()


def test_nothing_ready_is_told(context):
    made = PriorityExecutor(context=context)
    with contextlib.closing(made) as executor, pytest.raises(TimeoutException):
        executor.wait_for_ready_callbacks(timeout_sec=0.0)


@pytest.mark.parametrize("kind", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_a_group_of_a_users_decides_when_its_callbacks_run(make_node, context, kind):
    node = make_node("throttled")
    group = ThrottledGroup(2)
    got: list[Any] = []
    ticks: list[int] = []
    node.create_subscription(STRING, "words", got.append, 10, callback_group=group)
    publisher = node.create_publisher(STRING, "words", 10)
    for number in range(5):
        publisher.publish(STRING(data=str(number)))
    node.create_timer(0.01, lambda: ticks.append(1), MutuallyExclusiveCallbackGroup())
    with kind(context=context) as executor:
        executor.add_node(node)
        while len(got) < 2 or len(ticks) < 5:
            executor.spin_once(10.0)
        assert len(got) == 2
        group.tokens = 3
        while len(got) < 5:
            executor.spin_once(10.0)
    assert [message.data for message in got] == ["0", "1", "2", "3", "4"]


class OneByOneGroup(CallbackGroup):
    """Lets one callback run at a time; a refusal lasts until that callback has ended."""

    def __init__(self):
        super().__init__()
        self.running: object = None
        self.refused = threading.Event()
        self.reported = threading.Event()

    def can_execute(self, entity):
        if self.running is None:
            return True
        self.refused.set()
        assert self.reported.wait(10.0)
        return False

    def beginning_execution(self, entity):
        self.running = entity
        return True

    def ending_execution(self, entity):
        self.running = None


def test_a_callback_refused_at_the_moment_in_which_another_one_ends_still_runs(make_node, context):
    group = OneByOneGroup()

    class Reporting(MultiThreadedExecutor):
        def wake(self):
            super().wake()
            if group.refused.is_set():
                group.reported.set()

    node = make_node("refused")
    ran: list[str] = []

    def first() -> None:
        second.trigger()
        assert group.refused.wait(10.0)
        ran.append("first")

    with Reporting(context=context) as executor:
        executor.add_node(node)
        guard = node.create_guard_condition(first, group)
        second = node.create_guard_condition(lambda: ran.append("second"), group)
        guard.trigger()
        ended = executor.create_future()
        deadline = time.monotonic() + 10.0
        while len(ran) < 2:
            assert time.monotonic() < deadline, "the refused callback did not run"
            executor.spin_once_until_future_complete(ended, 0.1)
    assert ran == ["first", "second"]


def test_a_pool_calls_a_timer_once_for_one_period(make_node, context):
    looked = threading.Event()

    class Looking(MultiThreadedExecutor):
        def _next_timer(self):
            found = super()._next_timer()
            looked.set()
            return found

    node = make_node("timed")
    calls: list[int] = []
    timer = node.create_timer(3600.0, None)
    timer._next_call_ns = 0  # due now, and then in an hour
    take = timer.take

    def take_after_a_look():
        looked.clear()
        executor.wake()
        assert looked.wait(10.0)
        return take()

    timer.take = take_after_a_look
    with Looking(context=context) as executor:
        executor.add_node(node)
        done = executor.create_future()

        def call() -> None:
            calls.append(1)
            done.set_result(None)

        timer.callback = call
        executor.spin_until_future_complete(done, 10.0)
        executor.spin_once(0.0)
        executor.shutdown(10.0)
    assert calls == [1]


def test_a_users_executor_spins_until_a_future_ends_by_its_own_method(make_node, context):
    node = make_node("asked")
    executor = PriorityExecutor(context=context)
    executor.add_node(node)
    done = executor.create_future()
    node.create_timer(0.001, lambda: done.set_result(3))
    executor.spin_until_future_complete(done, 10.0)
    assert done.result() == 3
    with pytest.raises(ConditionReachedException):
        executor.wait_for_ready_callbacks(timeout_sec=10.0, condition=done.done)
    executor.close()
