"""Control ticks in which nobody takes part are passed over in one go, with the same bits."""

from __future__ import annotations

import threading

import pytest
from hypothesis import given, settings, strategies as st

from teleopctl.mujoco_model.model import build_model
from teleopctl.sim.lockstep import LockstepLoop
from teleopctl.sim.simulation import Simulation
from teleopctl.testing import LONGEST_WAIT_S
from tests.sim.robots import INERTIAL, box, control, joint, link, robot
from tests.sim.test_lockstep import Recorder

SHAPE = INERTIAL + box("collision", "0.2 0.2 0.2")

# A slider that overlaps its neighbour at the start, a hinge that hangs from it, and a free cube.
ROBOT = build_model(
    robot(
        link("world", ""),
        link("post", SHAPE),
        joint("fixed", "world", "post", kind="fixed"),
        link("near", SHAPE),
        joint(
            "slide", "world", "near",
            kind="prismatic", xyz="0.1 0 0.5",
            limit='lower="-1" upper="1" effort="20" velocity="2"',
        ),
        link("rod"),
        joint("hinge", "near", "rod"),
        link("disc"),
        joint("wheel", "world", "disc", kind="continuous", xyz="0 5 0", axis="0 0 1", limit=""),
        link("cube", SHAPE),
        joint("loose", "world", "cube", kind="floating", xyz="5 0 2"),
        control(slide="position velocity", hinge="position effort", wheel="effort"),
    ),
    fixed_base=True,
)  # fmt: skip


def everything(simulation: Simulation) -> tuple[bytes, ...]:
    model, data = simulation.observe()
    state = (data.qpos, data.qvel, data.act, data.ctrl, data.qacc_warmstart)
    return (*(array.tobytes() for array in state), model.exclude_signature.tobytes())


values = st.sampled_from([float("nan"), 0.0, 0.3, -0.7, 5.0])
commands = st.tuples(
    st.sampled_from([("slide",), ("hinge",), ("slide", "hinge")]),
    st.tuples(values, values),
    st.tuples(values, values),
    st.tuples(values, values),
)


@settings(max_examples=25, deadline=None)
@given(
    ticks=st.integers(1, 12),
    stretches=st.lists(st.tuples(st.none() | commands, st.integers(1, 60)), max_size=12),
)
def test_coasting_has_the_bits_of_going_from_tick_to_tick(ticks: int, stretches: list) -> None:
    fast, slow = (Simulation(ROBOT, control_period_ns=ticks * 1_000_000) for _ in range(2))
    end = 0
    for command, count in stretches:
        end += count
        for simulation in (fast, slow):
            if command is not None:
                simulation.step(simulation.steps_to_tick % simulation.steps_per_period)
                names, *wanted = command
                simulation.apply(names, *(value[: len(names)] for value in wanted))
        while remaining := fast.steps_until(end * 1_000_000):
            fast.coast(remaining)
        slow.step_to(end * 1_000_000)
        assert fast.time_ns == slow.time_ns
        assert everything(fast) == everything(slow)


@pytest.mark.parametrize("ticks", [1, 3])
def test_coasting_ends_at_the_tick_that_finds_physics_broken_down(ticks: int) -> None:
    ends = []
    for coast in (False, True):
        simulation = Simulation(ROBOT, control_period_ns=ticks * 1_000_000)
        simulation.step(ticks)
        # MuJoCo bears speeds up to 1e10: it gets there some steps from here.
        simulation.reset_state(velocities={"wheel": 9.9e9})
        simulation.apply(["wheel"], effort=[5e6])
        while not simulation.diverged:
            if coast:
                simulation.coast(60 * ticks)
            else:
                simulation.step(simulation.steps_to_tick)
        ends.append(simulation.time_ns)
    assert ends[0] == ends[1]
    assert ends[0] > 10_000_000


def test_a_loop_without_listeners_tells_nothing_and_goes_the_same_way() -> None:
    ports, simulation = Recorder(), Simulation(ROBOT, control_period_ns=1_000_000)
    loop = LockstepLoop(simulation, ports, real_time_factor=0.0)
    loop.set_heard(clock=False, ticks=False)
    thread = threading.Thread(target=loop.run)
    thread.start()
    try:
        loop.set_viewed(True)
        ports.wait_for("view", 60)
        loop.set_viewed(False)
        assert not ports.times("clock")
        assert not ports.times("state")

        loop.set_heard(clock=True, ticks=False)
        first, second = ports.wait_for("clock", 2)
        assert second - first == 10_000_000
        assert not ports.times("state")

        loop.set_heard(clock=True, ticks=True)
        first, second = ports.wait_for("state", 2)
        assert second - first == 1_000_000
        assert loop.set_paused(True, LONGEST_WAIT_S)
        other = Simulation(ROBOT, control_period_ns=1_000_000)
        other.step_to(simulation.time_ns)
        assert everything(other) == everything(simulation)
    finally:
        loop.stop()
        thread.join(LONGEST_WAIT_S)
