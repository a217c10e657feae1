"""The event loop of a launch: queued and timed functions, one after the other."""

from functools import partial

from teleopctl.launch.execution.event_loop import EventLoop


def test_queued_functions_are_called_in_their_order():
    called: list[int] = []
    loop = EventLoop()
    for number in range(3):
        loop.put(partial(called.append, number))
    for _ in range(3):
        loop.handle_next()
    assert called == [0, 1, 2]
    assert loop.is_empty


def test_timed_functions_are_called_by_their_time_when_nothing_is_queued():
    loop, called = EventLoop(), []
    loop.after(0.02, lambda: called.append("late"))
    loop.after(0.0, lambda: called.append("early"))
    while len(called) < 2:
        loop.handle_next()
    assert called == ["early", "late"]


def test_endless_events_do_not_hold_up_what_is_due():
    loop, called = EventLoop(), []

    def write_again():
        loop.put(write_again)

    write_again()
    loop.after(0.0, lambda: called.append("kill"))
    loop.handle_next()
    assert called == ["kill"]


def test_a_function_that_is_due_again_at_once_does_not_hold_up_the_queue():
    loop, called = EventLoop(), []

    def look_again():
        loop.after(0.0, look_again)

    look_again()
    loop.put(lambda: called.append("output"))
    loop.handle_next()
    assert called == ["output"]
