"""Waitables of a program's own, which executors serve beside the entities of the node."""

import time
from typing import Any

import pytest

from teleopctl.node import (
    Clock,
    ClockType,
    GuardHandle,
    MultiThreadedExecutor,
    Node,
    NumberOfEntities,
    ReentrantCallbackGroup,
    SingleThreadedExecutor,
    Waitable,
    WaitSet,
    create_polled_timer,
)
from teleopctl.testing import LONGEST_WAIT_S


class Bell(Waitable):
    """Calls back with how often it has rung."""

    def __init__(self, node, callback) -> None:
        super().__init__(ReentrantCallbackGroup())
        self.guard = GuardHandle(node.context.handle)
        self.callback = callback
        self.rung = 0
        self.index = 0
        self.looks = 0

    def ring(self) -> None:
        self.rung += 1
        self.guard.trigger_guard_condition()

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        self.looks += 1
        self.index = wait_set.add_guard_condition(self.guard)

    def is_ready(self, wait_set: WaitSet) -> bool:
        return wait_set.is_ready("guard_condition", self.index)

    def take_data(self) -> int:
        return self.rung

    async def execute(self, taken_data: int) -> None:
        self.callback(taken_data)

    def get_num_entities(self) -> NumberOfEntities:
        return NumberOfEntities(num_gcs=1)


@pytest.fixture(params=[SingleThreadedExecutor, MultiThreadedExecutor])
def executor(context, request):
    executor = request.param(context=context)
    yield executor
    executor.shutdown()


@pytest.fixture
def spin_until(executor):
    """Spin in short turns: to look at one that is not ready is no callback, and ends no turn."""

    def spin(condition) -> None:
        deadline = time.monotonic() + LONGEST_WAIT_S
        while not condition():
            assert time.monotonic() < deadline, "the condition did not come true in time"
            executor.spin_once(0.02)

    return spin


def test_it_is_looked_at_when_it_is_added_and_executed_each_time_it_is_ready(make_node, spin_until):
    node, got = make_node(), list[Any]()
    bell = Bell(node, got.append)
    node.add_waitable(bell)
    assert node.waitables == [bell]
    spin_until(lambda: bell.looks)
    bell.ring()
    spin_until(lambda: got == [1])
    bell.ring()
    spin_until(lambda: got == [1, 2])


def test_what_was_ready_before_the_node_had_an_executor_is_not_missed(
    context, executor, spin_until
):
    with Node("tester", context=context) as node:
        got = list[Any]()
        bell = Bell(node, got.append)
        node.add_waitable(bell)
        bell.ring()
        executor.add_node(node)
        spin_until(lambda: got)
        assert got == [1]


def test_one_that_was_removed_is_not_executed(make_node, spin_until):
    node, got = make_node(), list[Any]()
    removed, kept = Bell(node, got.append), Bell(node, got.append)
    for bell in (removed, kept):
        node.add_waitable(bell)
    spin_until(lambda: removed.looks and kept.looks)
    node.remove_waitable(removed)
    removed.ring()
    kept.rung = 10
    kept.ring()
    spin_until(lambda: got)
    assert got == [11]
    assert node.waitables == [kept]


class Ticks(Waitable):
    """Calls back each time that a timer of its own is due."""

    period_ns = 1_000_000

    def __init__(self, callback) -> None:
        super().__init__(ReentrantCallbackGroup())
        self.timer = create_polled_timer(Clock(clock_type=ClockType.STEADY_TIME), self.period_ns)
        self.callback = callback
        self.index = 0

    def add_to_wait_set(self, wait_set: WaitSet) -> None:
        self.index = wait_set.add_timer(self.timer)

    def is_ready(self, wait_set: WaitSet) -> bool:
        return wait_set.is_ready("timer", self.index)

    def take_data(self) -> str:
        self.timer.call_timer()
        return "tick"

    async def execute(self, taken_data: str) -> None:
        self.callback(taken_data)


def test_it_is_executed_each_time_that_a_timer_of_its_own_is_due(make_node, executor, spin_until):
    node, got = make_node(), list[Any]()
    ticks = Ticks(got.append)
    node.add_waitable(ticks)
    spin_until(lambda: len(got) > 2)
    node.remove_waitable(ticks)
    assert not node.timers


class Late(Ticks):
    """Its timer becomes due after the wait set was checked and before the check ends."""

    waited = False
    # So long that a check finds it not due, however slow the machine is.
    period_ns = 100_000_000

    def is_ready(self, wait_set: WaitSet) -> bool:
        ready = super().is_ready(wait_set)
        while not ready and not self.timer.is_timer_ready():
            self.waited = True
        return ready


def test_a_timer_that_becomes_due_during_the_check_is_not_missed(make_node, executor, spin_until):
    node, got = make_node(), list[Any]()
    late = Late(got.append)
    node.add_waitable(late)
    # Wakes the executor while no timer is due.
    waker = node.create_guard_condition(lambda: None)
    spin_until(lambda: late.waited or waker.trigger())
    before = len(got)
    spin_until(lambda: len(got) > before)
    node.remove_waitable(late)


class Choosy(Ticks):
    """Is ready at the third time that its timer is due, and the timer stays due until then."""

    refused = 0

    def is_ready(self, wait_set: WaitSet) -> bool:
        if not super().is_ready(wait_set):
            return False
        self.refused += 1
        return self.refused > 2


def test_one_that_is_not_ready_though_its_timer_is_due_is_checked_again(make_node, spin_until):
    node, got = make_node(), list[Any]()
    node.add_waitable(Choosy(got.append))
    spin_until(lambda: got)


def test_an_arrival_just_after_the_last_look_is_not_missed(make_node, spin_until, monkeypatch):
    node, got = make_node(), list[Any]()
    bell = Bell(node, got.append)
    look = WaitSet.has_arrivals

    def look_and_ring(wait_set: WaitSet) -> bool:
        found = look(wait_set)
        if bell.rung < 2:
            bell.ring()
        return found

    node.add_waitable(bell)
    monkeypatch.setattr(WaitSet, "has_arrivals", look_and_ring)
    bell.ring()
    spin_until(lambda: got == [1, 2])


def test_one_that_removes_itself_in_its_check_leaves_no_timer(make_node, spin_until):
    node = make_node()

    class Once(Ticks):
        def take_data(self) -> str:
            node.remove_waitable(self)
            return super().take_data()

    once = Once(list[Any]().append)
    node.add_waitable(once)
    spin_until(lambda: not node.waitables)
    assert not node.timers


class Overlapping(Bell):
    """Rings during its own check, and counts the checks that run at one time."""

    def __init__(self, node, callback) -> None:
        super().__init__(node, callback)
        self.at_once = 0
        self.most_at_once = 0

    def is_ready(self, wait_set: WaitSet) -> bool:
        self.at_once += 1
        self.most_at_once = max(self.most_at_once, self.at_once)
        if self.rung < 20:
            self.ring()
            time.sleep(0)  # to another thread of the pool, which the ring has woken
        ready = super().is_ready(wait_set)
        self.at_once -= 1
        return ready


def test_checks_of_one_waitable_do_not_overlap(make_node, spin_until):
    node, got = make_node(), list[Any]()
    bell = Overlapping(node, got.append)
    node.add_waitable(bell)
    spin_until(lambda: 20 in got)
    assert bell.most_at_once == 1


def test_numbers_of_entities_add_up():
    total = NumberOfEntities(1, 2, 3, 4, 5, 6) + NumberOfEntities(num_gcs=1, num_events=2)
    assert repr(total) == "NumberOfEntities(1, 3, 3, 4, 5, 8)"
