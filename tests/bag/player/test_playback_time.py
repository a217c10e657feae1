"""Playback time runs, stands still and jumps as it is told, and nothing is lost meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable

from hypothesis import given, strategies as st

from teleopctl.bag.player.playback_time import PlaybackTime

MS = 1_000_000


class ScriptedTime:
    """A clock on which things happen at given times, while somebody waits."""

    def __init__(self) -> None:
        self.time_ns = 0
        self.script: list[tuple[int, Callable[[], object]]] = []

    def now_ns(self) -> int:
        return self.time_ns

    def wait(self, changed: threading.Condition, longest_ns: int | None) -> None:
        """Pass the time until the wait is over or something happens."""
        until_ns = None if longest_ns is None else self.time_ns + longest_ns
        if self.script and (until_ns is None or self.script[0][0] <= until_ns):
            at_ns, happen = self.script.pop(0)
            self.time_ns = max(self.time_ns, at_ns)
            happen()
        else:
            assert until_ns is not None, "nothing would ever end this wait"
            self.time_ns = until_ns


def play(line: PlaybackTime, due_ns: list[int], steady: ScriptedTime) -> list[tuple[int, int]]:
    """Wait for each time in turn; return each with the instant at which it came."""
    came = []
    for time_ns in due_ns:
        while not line.wait_until(time_ns):
            pass
        came.append((time_ns, steady.time_ns))
    return came


def test_time_runs_at_the_rate():
    steady = ScriptedTime()
    line = PlaybackTime(1000 * MS, 2.0, steady=steady)
    assert play(line, [1000 * MS, 1010 * MS, 1030 * MS], steady) == [
        (1000 * MS, 0),
        (1010 * MS, 5 * MS),
        (1030 * MS, 15 * MS),
    ]


def test_a_pause_puts_off_all_that_follows_by_its_length():
    steady = ScriptedTime()
    line = PlaybackTime(0, steady=steady)
    steady.script = [(4 * MS, line.pause), (104 * MS, line.resume)]
    assert play(line, [MS, 5 * MS, 9 * MS], steady) == [
        (MS, MS),
        (5 * MS, 105 * MS),
        (9 * MS, 109 * MS),
    ]


def test_a_time_that_has_passed_comes_at_once_but_not_while_paused():
    steady = ScriptedTime()
    line = PlaybackTime(10 * MS, is_paused=True, steady=steady)
    steady.script = [(7 * MS, line.resume)]
    assert play(line, [MS], steady) == [(MS, 7 * MS)]


def test_a_rate_of_nothing_changes_nothing():
    line = PlaybackTime(0, 3.0, steady=ScriptedTime())
    assert not line.set_rate(0)
    assert not line.set_rate(-1)
    assert not line.set_rate(float("nan"))
    assert line.rate == 3.0


def test_waking_before_the_wait_is_not_lost():
    steady = ScriptedTime()
    line = PlaybackTime(0, steady=steady)
    assert line.wait_until(0)
    line.wake()
    assert not line.wait_until(MS)
    assert line.wait_until(MS)
    assert steady.time_ns == MS


CHANGES = st.lists(
    st.tuples(
        st.integers(0, 3000),
        st.one_of(
            st.just("pause"),
            st.just("resume"),
            st.sampled_from([0.1, 0.5, 1.0, 3.0, 1000.0]),
            st.just("wake"),
        ),
    ),
    max_size=12,
)


@given(due=st.lists(st.integers(0, 1000), max_size=30), changes=CHANGES, rate=st.floats(0.1, 10))
def test_whatever_is_changed_meanwhile_no_time_comes_early_and_each_comes_in_its_order(
    due, changes, rate
):
    """The oracle adds up the playback time piece by piece."""
    steady = ScriptedTime()
    line = PlaybackTime(0, rate, steady=steady)
    calls = {"pause": line.pause, "resume": line.resume, "wake": line.wake}

    def change(what: str | float) -> Callable[[], object]:
        return calls[what] if isinstance(what, str) else lambda: line.set_rate(what)

    script = sorted(changes, key=lambda each: each[0])
    steady.script = [(at * MS, change(what)) for at, what in script]
    # Somebody presses resume at last, else what is due would never come.
    steady.script.append((4000 * MS, line.resume))
    came = play(line, [time * MS for time in sorted(due)], steady)
    assert [time for time, _ in came] == [time * MS for time in sorted(due)]

    def playback_ns(at_ns: int) -> float:
        total, since, speed, is_paused = 0.0, 0, rate, False
        for when, what in [*((at * MS, what) for at, what in script), (4000 * MS, "resume")]:
            if when > at_ns:
                break
            total += 0 if is_paused else (when - since) * speed
            since = when
            is_paused = what == "pause" or (is_paused and what != "resume")
            speed = what if isinstance(what, float) else speed
        return total + (0 if is_paused else (at_ns - since) * speed)

    for time_ns, at_ns in came:
        # Nanoseconds are rounded once for each change.
        assert playback_ns(at_ns) >= time_ns - 1000 * (len(changes) + 2)


def test_a_change_by_another_thread_ends_a_wait():
    line = PlaybackTime(0, is_paused=True)
    waits = threading.Event()
    ended: list[bool] = []

    def wait() -> None:
        waits.set()
        while not line.wait_until(0):
            pass
        ended.append(True)

    thread = threading.Thread(target=wait)
    thread.start()
    assert waits.wait(20)
    line.resume()
    thread.join(20)
    assert ended == [True]
