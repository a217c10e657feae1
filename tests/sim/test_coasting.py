"""Control ticks in which nobody takes part are passed over in one go, with the same bits."""

from __future__ import annotations

import threading

import mujoco
import pytest
from hypothesis import given, strategies as st

from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.sim.lockstep import LockstepLoop
from teleopctl.sim.simulation import Simulation
from teleopctl.sim.state.saved_state import SavedState
from teleopctl.testing import LONGEST_WAIT_S
from tests.sim.robots import INERTIAL, box, control, joint, link, robot
from tests.sim.test_driving import sliding_base
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


@pytest.fixture(scope="module")
def base() -> RobotModel:
    """A base on four wheels that turns by sliding them."""
    return sliding_base().simulation.model


def turning(base: RobotModel) -> Simulation:
    """It begins to turn, in the middle of a control period."""
    simulation = Simulation(base, control_period_ns=10_000_000)
    simulation.step(200)
    wheels = [joint.name for joint in base.joints]
    simulation.apply(wheels, velocity=[3.0 if "left" in wheel else -3.0 for wheel in wheels])
    simulation.step(105)
    return simulation


def test_a_base_that_slides_has_the_same_bits_however_its_steps_are_cut(base: RobotModel) -> None:
    fast, slow = turning(base), turning(base)
    for simulation in (fast, slow):
        simulation.hold()
    slow.step(701)
    while remaining := fast.steps_until(slow.time_ns):
        fast.coast(min(remaining, 90))
    assert everything(fast) == everything(slow)


@pytest.mark.parametrize("steps", [0, 300])
def test_a_base_that_slides_goes_on_from_a_saved_state_with_the_same_bits(
    base: RobotModel, steps: int
) -> None:
    first, other = turning(base), Simulation(base, control_period_ns=10_000_000)
    if steps:
        first.hold()
        first.step(steps)
    SavedState.of(first).put(other)
    for simulation in (first, other):
        simulation.step(200)
    assert everything(first) == everything(other)


def test_a_base_at_rest_takes_the_steps_of_mujoco_alone(
    base: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = Simulation(base, control_period_ns=10_000_000)
    simulation.step(500)
    looks = 0
    step = mujoco.mj_step1

    def look(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        nonlocal looks
        looks += 1
        step(model, data)

    monkeypatch.setattr(mujoco, "mj_step1", look)
    simulation.step(160)
    assert 0 < looks <= 160 // 16 + 1


def test_a_loop_without_listeners_tells_nothing_and_goes_the_same_way() -> None:
    ports, simulation = Recorder(), Simulation(ROBOT, control_period_ns=1_000_000)
    loop = LockstepLoop(simulation, ports, real_time_factor=0.0)
    loop.set_subscribed(clock=False, ticks=False)
    thread = threading.Thread(target=loop.run)
    thread.start()
    try:
        loop.set_viewed(True)
        ports.wait_for("view", 60)
        loop.set_viewed(False)
        assert not ports.times("clock")
        assert not ports.times("state")

        loop.set_subscribed(clock=True, ticks=False)
        # The first one may come between two of its times: the loop was on its way.
        _, first, second = ports.wait_for("clock", 3)
        assert second - first == 10_000_000
        assert not ports.times("state")

        loop.set_subscribed(clock=True, ticks=True)
        first, second = ports.wait_for("state", 2)
        assert second - first == 1_000_000
        assert loop.set_paused(True, LONGEST_WAIT_S)
        other = Simulation(ROBOT, control_period_ns=1_000_000)
        other.step_to(simulation.time_ns)
        assert everything(other) == everything(simulation)
    finally:
        loop.stop()
        thread.join(LONGEST_WAIT_S)
