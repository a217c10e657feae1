"""One wrong clock does not poison the tree of what shows where frames are now."""

import logging
from types import SimpleNamespace
from typing import Any

import pytest

from teleopctl.node import ROSClock
from teleopctl.tf import Transform, live_buffer, transform_stamped
from teleopctl.tf.live_buffer import AHEAD_S, STALE_S, LiveBuffer

WALL_S = 1_795_462_000.0
SIM, DISPLAY = "/sim/robot_state_publisher", "/display/robot_state_publisher"


class World:
    """A buffer on a clock that the test moves, and those who publish transforms."""

    def __init__(self, monkeypatch, *, simulated=True):
        self.steady_s = 100.0
        steady = SimpleNamespace(monotonic=lambda: self.steady_s)
        monkeypatch.setattr(live_buffer, "time", steady)
        self.clock = ROSClock()
        self.clock.set_simulated(simulated)
        # Any: no more of a node than the buffer uses.
        node: Any = SimpleNamespace(get_clock=lambda: self.clock, create_service=lambda *_: None)
        self.buffer = LiveBuffer(node=node)

    def set_clock(self, seconds):
        self.clock.set_simulated_time(int(seconds * 1e9))

    def publish(self, stamp_s, x, authority=SIM, child="arm", *, static=False):
        put = self.buffer.set_transform_static if static else self.buffer.set_transform
        put(transform_stamped("base", child, int(stamp_s * 1e9), Transform((x, 0, 0))), authority)

    def x(self, child="arm"):
        """Where a frame stands now, None where that is not known."""
        latest = dict(self.buffer.latest())
        return latest[child].transform.translation[0] if child in latest else None


@pytest.fixture
def world(monkeypatch):
    return World(monkeypatch)


def test_a_publisher_on_the_walls_clock_is_left_out_and_counted(world, caplog):
    world.set_clock(10.0)
    with caplog.at_level(logging.WARNING):
        for step in range(3):
            world.set_clock(10.0 + step)
            world.publish(10.0 + step, 1.2)
            world.publish(WALL_S + step, 0.0, DISPLAY)
            assert world.x() == 1.2
    assert world.buffer.left_out == {DISPLAY: 3}
    (said,) = [record.getMessage() for record in caplog.records]
    assert DISPLAY in said
    assert "arm" in said
    assert "use_sim_time" in said


def test_after_it_has_ended_the_frame_moves_on(world, caplog):
    world.set_clock(10.0)
    world.publish(WALL_S, 0.0, DISPLAY)
    with caplog.at_level(logging.WARNING):
        caplog.clear()
        world.publish(10.1, 1.3)
    assert world.x() == 1.3
    assert not caplog.records


@pytest.mark.parametrize("ahead_s", [-5.0, 0.0, 1.0, AHEAD_S])
def test_what_lies_a_little_ahead_is_taken(world, ahead_s):
    world.set_clock(10.0)
    world.publish(10.0 + ahead_s, 1.0)
    assert world.x() == 1.0
    assert not world.buffer.left_out


def test_static_transforms_are_of_any_time(world):
    world.set_clock(10.0)
    world.publish(WALL_S, 1.0, static=True)
    assert world.x() == 1.0
    assert not world.buffer.left_out


def test_what_came_before_the_first_clock_is_judged_when_it_comes(world):
    world.publish(WALL_S, 0.0, DISPLAY)
    world.publish(WALL_S, 0.0, DISPLAY, "other")
    world.publish(WALL_S, 2.0, child="still", static=True)
    assert world.x() == 0.0  # there is no time to compare with
    world.set_clock(3.0)
    world.publish(3.0, 1.2)
    assert (world.x(), world.x("other"), world.x("still")) == (1.2, None, 2.0)
    assert world.buffer.left_out == {DISPLAY: 2}


def test_time_zero_of_a_simulation_that_was_reset_is_a_time(world):
    world.set_clock(10.0)
    world.publish(10.0, 1.2)
    world.set_clock(0.0)
    world.publish(WALL_S, 0.0, DISPLAY)
    assert world.x() is None
    world.publish(0.0, 0.5)
    assert world.x() == 0.5


def test_a_late_transform_of_the_former_run_does_not_stay(world):
    world.set_clock(30.0)
    world.publish(30.0, 1.2)
    world.set_clock(0.0)
    world.publish(30.0, 1.2)  # was on its way
    for step in range(1, 20):
        world.steady_s += 0.1
        world.set_clock(0.1 * step)
        world.publish(0.1 * step, 0.0)
    assert world.x() == 0.0


def test_on_the_walls_clock_a_frame_follows_the_simulation_again(monkeypatch):
    world = World(monkeypatch, simulated=False)
    for step in range(20):
        world.steady_s += 0.1
        world.publish(5.0 + 0.1 * step, 1.2)
        world.publish(WALL_S + 0.1 * step, 0.0, DISPLAY)
        assert world.x() == 0.0 or step == 0
    for step in range(20, 40):
        world.steady_s += 0.1
        world.publish(5.0 + 0.1 * step, 1.2)
    assert world.x() == 1.2
    assert not world.buffer.left_out


def test_a_clock_that_starts_over_in_a_loop_is_followed_each_time(world):
    for _ in range(3):
        for step in range(20):
            world.steady_s += 0.1
            world.set_clock(WALL_S + 0.1 * step)
            world.publish(WALL_S + 0.1 * step, float(step))
            assert world.x() == float(step)
    assert not world.buffer.left_out


def test_a_publisher_that_is_a_little_late_does_not_take_a_frame_over(world):
    world.set_clock(10.0)
    for step in range(30):
        world.steady_s += 0.1
        world.publish(10.0 + 0.1 * step, 1.0)
        world.publish(9.0 + 0.1 * step, 2.0)
        assert world.x() == 1.0


def test_a_frame_that_was_silent_goes_on_with_its_next_transform(world):
    world.set_clock(10.0)
    world.publish(10.0, 1.0)
    world.steady_s += 100 * STALE_S
    world.publish(10.1, 2.0)
    assert world.x() == 2.0


def test_clearing_begins_the_count_again(world):
    world.set_clock(10.0)
    world.publish(WALL_S, 0.0, DISPLAY)
    world.buffer.clear()
    assert not world.buffer.left_out
