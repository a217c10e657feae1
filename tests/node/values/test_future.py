"""Ends of futures."""

import threading

import pytest

from teleopctl.node import Future, SingleThreadedExecutor


def test_a_cancelled_future_has_ended_and_is_not_done():
    future, called = Future[int](), list[object]()
    future.add_done_callback(called.append)
    future.cancel()
    assert (future.cancelled(), future.done(), future.ended()) == (True, False, True)
    assert called == [future]
    future.set_result(3)
    assert (future.cancelled(), future.done(), future.result()) == (False, True, 3)
    assert called == [future], "nobody is called back twice"


def test_an_exception_that_is_set_late_still_counts():
    future = Future[None]()
    future.set_result(None)
    future.set_exception(ValueError("late"))
    with pytest.raises(ValueError, match="late"):
        future.result()


def test_what_awaits_a_future_goes_on_after_its_callbacks(context):
    executor, future, order = SingleThreadedExecutor(context=context), Future[None](), list[str]()

    async def wait():
        await future
        order.append("awaited")

    executor.create_task(wait)
    executor.spin_once(0.0)

    def called(_: object) -> None:
        executor.spin_once(0.0)  # nothing is to come yet
        order.append("called")

    future.add_done_callback(called)
    future.set_result(None)
    executor.spin_once(0.0)
    assert order == ["called", "awaited"]


def test_an_executor_spins_in_one_thread_at_a_time(context):
    executor = SingleThreadedExecutor(context=context)
    inside, leave = threading.Event(), threading.Event()

    def stay() -> None:
        inside.set()
        leave.wait(10)

    executor.create_task(stay)
    spinning = threading.Thread(target=executor.spin_once)
    spinning.start()
    assert inside.wait(10)
    assert executor.is_spinning
    with pytest.raises(RuntimeError, match="already spinning"):
        executor.spin_once(0.0)
    leave.set()
    spinning.join()
    assert not executor.is_spinning
    executor.spin_once(0.0)
