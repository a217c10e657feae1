"""The simulator's loop against ports and a controller that are plain objects."""

import queue
import threading
from collections.abc import Callable, Iterator, Sequence

import pytest

from teleopctl.mujoco_model import with_world
from teleopctl.robot import read_world_text
from teleopctl.sim.lockstep import Command, LockstepLoop
from teleopctl.sim.simulation import Simulation
from teleopctl.testing import LONGEST_WAIT_S
from tests.sim.robots import pendulum

PERIOD_NS = 100_000_000


class Recorder:
    """Ports that remember, and that may answer a state at once."""

    def __init__(self) -> None:
        self.events: list[tuple[str, int]] = []
        self.changed = threading.Condition()
        self.on_state: Callable[[int], None] = lambda time_ns: None

    def _add(self, event: str, time_ns: int) -> None:
        with self.changed:
            self.events.append((event, time_ns))
            self.changed.notify_all()

    def publish_clock(self, time_ns: int) -> None:
        self._add("clock", time_ns)

    def publish_state(self, time_ns: int) -> None:
        self._add("state", time_ns)
        self.on_state(time_ns)

    def publish_view(self, time_ns: int) -> None:
        self._add("view", time_ns)

    def controller_lost(self, time_ns: int, waited_s: float) -> None:
        self._add("gone" if waited_s == 0.0 else "lost", time_ns)

    def controller_back(self, time_ns: int) -> None:
        self._add("back", time_ns)

    def fell_behind(self, seconds: float, factor: float) -> None:
        self._add("behind", 0)

    def diverged(self, time_ns: int) -> None:
        self._add("diverged", time_ns)

    def commands_cut(self, sentences: Sequence[str]) -> None:
        self.cut = [*sentences]

    def objects_reset(self, time_ns: int, things: Sequence[str]) -> None:
        self._add(f"put back {', '.join(things)}", time_ns)

    def times(self, event: str) -> list[int]:
        with self.changed:
            return [time_ns for name, time_ns in self.events if name == event]

    def wait_for(self, event: str, count: int) -> list[int]:
        with self.changed:
            assert self.changed.wait_for(
                lambda: sum(name == event for name, _ in self.events) >= count, LONGEST_WAIT_S
            ), self.events[-20:]
        return self.times(event)[:count]


class Bench:
    """A pendulum, its loop and the recorder."""

    def __init__(self, *, period_ns: int = PERIOD_NS, **options) -> None:
        self.ports = Recorder()
        self.simulation = Simulation(pendulum("position velocity"), control_period_ns=period_ns)
        options = {"real_time_factor": 0.0, "lockstep_timeout_s": 0.05} | options
        self.loop = LockstepLoop(self.simulation, self.ports, **options)
        self.thread = threading.Thread(target=self.loop.run, daemon=True)

    def start(self) -> None:
        self.thread.start()

    def answer(self, position: float) -> None:
        self.ports.on_state = lambda time_ns: self.loop.receive_command(
            Command(time_ns, ["hinge"], [position])
        )

    def step(self, count: int) -> None:
        ended: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self.loop.step(count, ended.put)
        assert ended.get(timeout=LONGEST_WAIT_S)

    def close(self) -> None:
        self.loop.stop()
        if self.thread.is_alive():
            self.thread.join(LONGEST_WAIT_S)
        assert not self.thread.is_alive()


@pytest.fixture
def make() -> Iterator[Callable[..., Bench]]:
    benches: list[Bench] = []

    def new(**options) -> Bench:
        benches.append(Bench(**options))
        return benches[-1]

    yield new
    for bench in benches:
        bench.close()


def test_every_tick_has_its_state_and_the_clock_runs_between(make) -> None:
    bench = make()
    bench.start()

    assert bench.ports.wait_for("state", 5) == [k * PERIOD_NS for k in range(5)]
    assert bench.ports.wait_for("clock", 40) == [k * 10_000_000 for k in range(40)]


def test_fast_control_does_not_flood_the_clock(make) -> None:
    bench = make(period_ns=1_000_000)
    bench.start()

    assert bench.ports.wait_for("clock", 4) == [k * 10_000_000 for k in range(4)]
    assert bench.ports.wait_for("state", 40) == [k * 1_000_000 for k in range(40)]


def test_a_command_acts_in_the_period_of_the_state_that_it_answers(make) -> None:
    bench = make(paused=True)
    bench.loop.set_controller_present(True)
    bench.answer(0.1)
    bench.start()

    bench.step(100)

    bench.simulation.read()
    assert bench.simulation.positions[0] > 0.05


def test_the_loop_waits_for_the_answer(make) -> None:
    bench = make(lockstep_timeout_s=LONGEST_WAIT_S)
    bench.loop.set_controller_present(True)
    bench.start()
    bench.ports.wait_for("state", 1)

    for tick in range(10):
        assert bench.ports.times("state") == [k * PERIOD_NS for k in range(tick + 1)]
        # Not the command of that state.
        bench.loop.receive_command(Command(tick * PERIOD_NS - 1, ["hinge"], [0.0]))
        bench.loop.receive_command(Command(tick * PERIOD_NS, ["hinge"], [0.0]))
        bench.ports.wait_for("state", tick + 2)


def test_a_silent_controller_is_lost_once_and_comes_back_with_a_right_stamp(make) -> None:
    bench = make()
    bench.loop.set_controller_present(True)
    bench.start()
    assert bench.ports.wait_for("lost", 1) == [0]
    bench.ports.wait_for("state", 30)

    bench.answer(0.0)
    bench.ports.wait_for("back", 1)

    bench.ports.wait_for("state", len(bench.ports.times("state")) + 20)
    assert len(bench.ports.times("lost")) == 1


def test_a_controller_that_leaves_is_missed_at_once_and_the_next_one_is_new(make) -> None:
    bench = make(lockstep_timeout_s=LONGEST_WAIT_S)
    bench.loop.set_controller_present(True)
    bench.answer(0.3)
    bench.start()
    bench.ports.wait_for("state", 10)

    bench.ports.on_state = lambda time_ns: None
    bench.loop.set_controller_present(False)
    bench.ports.wait_for("gone", 1)
    bench.ports.wait_for("state", len(bench.ports.times("state")) + 20)

    bench.answer(0.0)
    bench.loop.set_controller_present(True)
    bench.ports.wait_for("state", len(bench.ports.times("state")) + 20)
    assert [name for name, _ in bench.ports.events if name in ("gone", "lost", "back")] == ["gone"]


def test_a_lost_controller_leaves_no_joint_running(make) -> None:
    bench = make(lockstep_timeout_s=LONGEST_WAIT_S)
    bench.loop.set_controller_present(True)
    bench.ports.on_state = lambda time_ns: bench.loop.receive_command(
        Command(time_ns, ["hinge"], velocity=[0.5])
    )
    bench.start()
    bench.ports.wait_for("state", 5)
    bench.loop.set_controller_present(False)
    bench.ports.on_state = lambda time_ns: None
    bench.ports.wait_for("gone", 1)
    bench.ports.wait_for("state", len(bench.ports.times("state")) + 10)
    bench.loop.set_paused(True, LONGEST_WAIT_S)

    bench.simulation.read()

    assert bench.simulation.velocities[0] == pytest.approx(0.0, abs=1e-6)


def test_a_sender_without_stamps_is_heard_too(make) -> None:
    bench = make(paused=True)
    bench.start()
    bench.step(100)

    bench.loop.receive_command(Command(0, ["hinge"], [0.2]))
    bench.step(500)

    bench.simulation.read()
    assert bench.simulation.positions[0] == pytest.approx(0.2, abs=1e-5)


def test_a_paused_loop_publishes_nothing_and_goes_on_at_its_present_time(make) -> None:
    bench = make(paused=True)
    bench.start()
    assert bench.loop.set_paused(True, LONGEST_WAIT_S)
    assert bench.ports.events == [("clock", 0)]

    assert bench.loop.set_paused(False, LONGEST_WAIT_S)
    bench.ports.wait_for("state", 3)
    assert bench.loop.set_paused(True, LONGEST_WAIT_S)
    seen = len(bench.ports.times("state"))
    assert bench.simulation.time_ns == seen * PERIOD_NS
    assert bench.loop.set_paused(False, LONGEST_WAIT_S)

    assert bench.ports.wait_for("state", seen + 1)[-1] == seen * PERIOD_NS


def test_steps_end_anywhere_and_show_where(make) -> None:
    bench = make(paused=True)
    bench.loop.set_viewed(True)
    bench.start()
    assert bench.loop.set_paused(True, LONGEST_WAIT_S)

    bench.step(7)

    assert bench.simulation.time_ns == 7_000_000
    assert bench.ports.events == [("clock", 0), ("view", 0),
                                  ("clock", 0), ("state", 0), ("view", 0),
                                  ("clock", 7_000_000), ("view", 7_000_000)]  # fmt: skip


def test_a_run_with_the_recorded_steps_and_changes_publishes_the_same(make) -> None:
    paused = make(paused=True)
    paused.loop.set_viewed(True)
    paused.start()
    assert paused.loop.set_paused(True, LONGEST_WAIT_S)
    begun: list[int] = []
    ended: queue.SimpleQueue[bool] = queue.SimpleQueue()
    for count in (150, 57, 93):
        paused.loop.step(count, ended.put, lambda: begun.append(paused.simulation.time_ns))
        assert ended.get(timeout=LONGEST_WAIT_S)
    assert begun == [0, 150_000_000, 207_000_000]

    again = make(end_ns=300_000_000)
    again.loop.set_viewed(True)
    called: list[int] = []
    for time_ns, count in zip(begun, (150, 57, 93), strict=True):
        again.loop.call_at(time_ns, lambda: called.append(again.simulation.time_ns))
        again.loop.call_at(time_ns, lambda count=count: again.loop.step(count, lambda _: None))
    again.start()
    again.thread.join(LONGEST_WAIT_S)

    assert called == begun
    # Without what the other one showed when it came to rest.
    published = paused.ports.events[2:]
    assert again.ports.events[: len(published)] == published


def test_the_pose_is_shown_at_its_rate_and_only_to_viewers(make) -> None:
    bench = make(paused=True, view_rate_hz=50.0)
    bench.start()
    bench.step(1000)
    assert bench.ports.times("view") == []

    bench.loop.set_viewed(True)
    bench.step(1000)

    shown = bench.ports.times("view")
    assert [time_ns for time_ns in shown if time_ns % 20_000_000 == 0] == [
        1_000_000_000 + k * 20_000_000 for k in range(51)
    ]


def test_a_viewer_gets_states_at_the_same_times_whenever_it_comes(make) -> None:
    bench = make(paused=True, view_rate_hz=50.0)
    bench.start()
    bench.step(1007)
    bench.loop.set_viewed(True)
    bench.step(1000)
    # And once where the requested steps end.
    assert bench.ports.times("view") == [
        *(1_000_000_000 + k * 20_000_000 for k in range(1, 51)),
        2_007_000_000,
    ]


def test_requests_run_between_steps(make) -> None:
    bench = make()
    bench.start()
    bench.ports.wait_for("state", 3)
    ran_on = []

    assert bench.loop.call(lambda: ran_on.append(threading.current_thread()), LONGEST_WAIT_S)

    assert ran_on == [bench.thread]


def test_steps_are_made_in_turn_and_given_up_when_time_is_to_stand_still(make) -> None:
    bench = make(paused=True)
    bench.start()
    ended: queue.SimpleQueue[tuple[str, bool]] = queue.SimpleQueue()
    bench.loop.step(7, lambda made: ended.put(("few", made)))
    bench.loop.step(10**18, lambda made: ended.put(("many", made)))

    assert ended.get(timeout=LONGEST_WAIT_S) == ("few", True)
    assert bench.loop.call(lambda: None, LONGEST_WAIT_S), "others are heard meanwhile"
    assert bench.loop.set_paused(True, LONGEST_WAIT_S)
    assert ended.get(timeout=LONGEST_WAIT_S) == ("many", False)
    assert bench.loop.call(lambda: None, LONGEST_WAIT_S), "those that had begun are made"
    stands = bench.simulation.time_ns
    bench.step(3)
    assert bench.simulation.time_ns == stands + 3_000_000


def test_a_request_that_is_not_reached_in_time_is_not_done_later(make) -> None:
    bench = make()
    goes_on, ran = threading.Event(), []
    bench.loop.post(lambda: ran.append(goes_on.wait(LONGEST_WAIT_S)))
    bench.start()

    assert not bench.loop.call(lambda: ran.append(False), 0.0)
    goes_on.set()
    assert bench.loop.call(lambda: None, LONGEST_WAIT_S)
    assert ran == [True]


def test_what_is_changed_while_time_stands_still_is_shown_at_once(make) -> None:
    bench = make(paused=True)
    bench.loop.set_viewed(True)
    bench.start()
    assert bench.loop.set_paused(True, LONGEST_WAIT_S)
    assert bench.ports.events == [("clock", 0), ("view", 0)]
    assert bench.loop.call(bench.loop.show, LONGEST_WAIT_S)
    assert bench.ports.events == [("clock", 0), ("view", 0)] * 2


def test_a_pause_shows_the_state_in_which_time_stands_still(make) -> None:
    bench = make(view_rate_hz=1.0, real_time_factor=0.0)
    bench.loop.set_viewed(True)
    bench.start()
    bench.ports.wait_for("state", 3)
    assert bench.loop.set_paused(True, LONGEST_WAIT_S)
    stands_at = bench.simulation.time_ns
    assert bench.ports.events[-2:] == [("clock", stands_at), ("view", stands_at)]


def test_the_pace_can_be_changed_while_running(make) -> None:
    bench = make(real_time_factor=0.001)
    bench.start()
    bench.ports.wait_for("state", 1)

    bench.loop.set_real_time_factor(0.0)

    bench.ports.wait_for("state", 100)


def test_physics_that_breaks_down_is_reported_and_set_back(make) -> None:
    bench = make(paused=True)
    bench.start()
    bench.step(100)

    def break_it() -> None:
        bench.simulation._d.qvel[:] = float("nan")

    assert bench.loop.call(break_it, LONGEST_WAIT_S)
    bench.step(200)

    assert bench.ports.times("diverged") == [2 * PERIOD_NS]
    bench.simulation.read()
    assert bench.simulation.positions[0] == pytest.approx(0.0, abs=1e-6)


def test_a_thing_that_breaks_down_is_reported_and_set_back_alone(make) -> None:
    bench = make(paused=True)
    ball = read_world_text(
        "things: {ball: {shape: sphere, radius: 0.1, at: [3, 0, 1], mass: 1}}", ""
    )
    bench.simulation.replace_model(with_world(bench.simulation.model, ball))
    bench.start()
    bench.answer(0.5)
    bench.loop.set_controller_present(True)
    bench.step(100)

    def break_it() -> None:
        bench.simulation._d.qvel[1:] = 1e300

    assert bench.loop.call(break_it, LONGEST_WAIT_S)
    bench.step(200)

    assert bench.ports.times("put back ball") == [2 * PERIOD_NS]
    assert not bench.ports.times("diverged")
    bench.simulation.read()
    assert bench.simulation.positions[0] == pytest.approx(0.5, abs=0.1)


def test_a_stop_ends_the_loop_while_it_waits_for_a_command(make) -> None:
    bench = make(lockstep_timeout_s=LONGEST_WAIT_S)
    bench.loop.set_controller_present(True)
    bench.start()
    bench.ports.wait_for("state", 1)

    bench.close()


def test_a_reset_while_time_stands_still_is_exchanged_at_once_and_only_once(make) -> None:
    bench = make(paused=True)
    bench.loop.set_controller_present(True)
    bench.answer(0.1)
    bench.start()
    bench.step(100)
    before = bench.ports.times("state")

    for _ in range(2):  # and once more, at the same time
        assert bench.loop.call(lambda: reset(bench), LONGEST_WAIT_S)
    assert bench.ports.times("state") == [*before, 0, 0]
    assert bench.simulation.time_ns == 0

    bench.step(bench.simulation.steps_per_period + 1)
    assert bench.ports.times("state") == [*before, 0, 0, PERIOD_NS]


def test_what_nobody_answered_at_a_reset_is_exchanged_again(make) -> None:
    bench = make(paused=True)
    bench.start()
    assert bench.loop.call(lambda: reset(bench), LONGEST_WAIT_S)
    bench.loop.set_controller_present(True)
    bench.answer(0.1)

    bench.step(1)

    assert bench.ports.times("state") == [0, 0]


def test_a_reset_between_control_ticks_is_shown_and_commands_wait_for_the_next_one(make) -> None:
    bench = make(paused=True)
    bench.loop.set_controller_present(True)
    bench.answer(0.1)
    bench.start()
    bench.step(3)
    now = bench.simulation.time_ns
    assert 0 < now < PERIOD_NS

    bench.loop.call(lambda: (bench.simulation.reset_state(), bench.loop.show()), LONGEST_WAIT_S)
    bench.step(bench.simulation.steps_to_tick)

    bench.simulation.read()
    assert bench.simulation.positions[0] == pytest.approx(0.0, abs=1e-3)
    bench.step(1)
    assert bench.ports.times("state") == [0, now, PERIOD_NS]


def reset(bench: Bench) -> None:
    """Go back to the start, as `Stage.reset` does; on the loop's thread."""
    bench.simulation.reset()
    bench.loop.restart()
    bench.loop.show()
