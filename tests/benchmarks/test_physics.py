"""The simulator's loop without controllers, as fast as it can, against MuJoCo alone.

Both take the same physics steps of the same robot in one process, in turns. What the loop adds is
paid each time that it goes round, and it goes round less often while nobody takes part: the ratio
should not depend on the rate of the control ticks.

With somebody who listens to each tick it does. The floor is then MuJoCo, called once for each
tick, and Zenoh, which sends as many bytes to the same process.
"""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import mujoco
import pytest

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.node import Node, init
from teleopctl.packages import package_share
from teleopctl.robot import STATES_TOPIC, simulated
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.sim.lockstep import LockstepLoop, Ports
from teleopctl.sim.ports import TopicPorts
from teleopctl.sim.simulation import Simulation
from teleopctl.testing import LONGEST_WAIT_S, RosGraph
from tests.benchmarks import tick_peer
from tests.benchmarks.figure import Figure
from tests.sim import test_driving
from tests.sim.robots import control, joint, link, model

ARM = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
SIMULATED_NS = 300_000_000
ROUNDS = 25


def arm() -> RobotModel:
    return build_model(RobotDescription.from_urdf(expand_xacro(ARM, {})))


def walker() -> RobotModel:
    """Five limbs of six joints."""
    parts = [link("base", "")]
    for limb in range(5):
        parent = "base"
        for number in range(6):
            name, axis = f"{limb}_{number}", "1 0 0" if number % 2 else "0 1 0"
            xyz = f"{limb} 0 0" if number == 0 else "0 0 0.5"
            parts += [link(name), joint(f"joint_{name}", parent, name, xyz=xyz, axis=axis)]
            parent = name
    commands = {f"joint_{limb}_{number}": "position" for limb in range(5) for number in range(6)}
    return model(*parts, control(**commands))


def six_axes() -> RobotModel:
    """Links of 0.5 kg whose axes alternate."""
    parts, parent = [link("base", "")], "base"
    for number in range(6):
        name, axis = f"link_{number}", "0 1 0" if number % 2 else "0 0 1"
        parts += [link(name), joint(f"joint_{number}", parent, name, axis=axis)]
        parent = name
    return model(*parts, control(**{f"joint_{number}": "position" for number in range(6)}))


def two_wheels() -> RobotModel:
    return build_model(RobotDescription.from_urdf(simulated(test_driving.CART).urdf))


def four_wheels() -> RobotModel:
    """A base that turns by sliding its wheels, on the ground."""
    return test_driving.sliding_base().simulation.model


ROBOTS = [arm, six_axes, two_wheels, four_wheels, walker]


class Silence:
    """Ports that nobody listens to."""

    def publish_clock(self, time_ns: int) -> None:
        pass

    def publish_state(self, time_ns: int) -> None:
        pass

    def publish_view(self, time_ns: int) -> None:
        pass

    def controller_lost(self, time_ns: int, waited_s: float) -> None:
        pass

    def controller_back(self, time_ns: int) -> None:
        pass

    def fell_behind(self, seconds: float, factor: float) -> None:
        pass

    def diverged(self, time_ns: int) -> None:
        raise AssertionError(time_ns)

    def commands_cut(self, sentences: Sequence[str]) -> None:
        raise AssertionError(sentences)

    def objects_reset(self, time_ns: int, things: Sequence[str]) -> None:
        raise AssertionError(things)


class End:
    """A sampler that stops the loop at the end."""

    loop: LockstepLoop

    def next_ns(self) -> int:
        return SIMULATED_NS

    def sample(self, time_ns: int) -> None:
        if time_ns >= SIMULATED_NS:
            self.loop.stop()

    def show(self, time_ns: int) -> None:
        pass


def loop_seconds(
    simulation: Simulation, *, ticks: bool = False, ports: Ports | None = None
) -> float:
    """Processor time of our loop, from its start or from where it is."""
    end = End()
    simulation.reset_time()
    end.loop = LockstepLoop(simulation, ports or Silence(), real_time_factor=0.0, sampler=end)
    end.loop.set_subscribed(clock=ticks, ticks=ticks)
    start = time.process_time()
    end.loop.run()
    return time.process_time() - start


def bare_seconds(simulation: Simulation, *, send: Callable[[], object] | None = None) -> float:
    """Processor time of MuJoCo from the same state, called once for each tick."""
    m, _ = simulation.observe()
    data = mujoco.MjData(m)
    state = mujoco.mjtState.mjSTATE_INTEGRATION
    mujoco.mj_setState(m, data, simulation.save()["physics"], state)
    steps, periods = simulation.steps_per_period, SIMULATED_NS // simulation.control_period_ns
    start = time.process_time()
    for _ in range(periods):
        mujoco.mj_step(m, data, steps)
        if send is not None:
            send()
    return time.process_time() - start


def at_rest(robot: RobotModel, rate_hz: int) -> Simulation:
    simulation = Simulation(robot, control_period_ns=1_000_000_000 // rate_hz)
    simulation.step_to(500_000_000)
    return simulation


@pytest.mark.parametrize("make", ROBOTS)
def test_physics_without_controllers(make: Callable[[], RobotModel], figures: list[Figure]) -> None:
    robot = make()
    for rate in (10, 100, 500, 1000):
        simulation = at_rest(robot, rate)
        # In turns, and the least of each: what else the machine does disturbs neither.
        bare, alone, attended = [], [], []
        for _ in range(ROUNDS):
            alone.append(loop_seconds(simulation))
            bare.append(bare_seconds(simulation))
            attended.append(loop_seconds(simulation, ticks=True))
        ratio = min(alone) / min(bare)
        figures.append(
            Figure(
                f"{make.__name__} at {rate} Hz, without controllers",
                f"{min(attended) / min(bare):.2f} times mj_step with a loop at each tick",
                "mj_step",
                ratio,
                1.2,
            )
        )
        assert ratio < 1.2


def driven_seconds(simulation: Simulation, commands: Callable[[float], dict]) -> tuple[list, list]:
    """Processor time of each control period: with a command, and of MuJoCo from the same state."""
    m, _ = simulation.observe()
    data, kind = mujoco.MjData(m), mujoco.mjtState.mjSTATE_INTEGRATION
    ours, bare, steps = [], [], simulation.steps_per_period
    for tick in range(2 * SIMULATED_NS // simulation.control_period_ns):
        command = commands(tick * simulation.control_period_ns * 1e-9)
        start = time.process_time()
        simulation.apply(simulation.joint_names, **command)
        simulation.step(steps)
        simulation.read()
        ours.append(time.process_time() - start)
        mujoco.mj_setState(m, data, simulation.save()["physics"], kind)
        start = time.process_time()
        mujoco.mj_step(m, data, steps)
        bare.append(time.process_time() - start)
    return ours, bare


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("make", ROBOTS)
def test_physics_while_driven(
    make: Callable[[], RobotModel], turning: bool, figures: list[Figure]
) -> None:
    """Joints follow a sine; wheels roll, or half of them backwards. A new command at each tick."""
    wheeled = make in (two_wheels, four_wheels)
    if turning and not wheeled:
        pytest.skip("it has no wheels")

    def commands(at_s: float) -> dict:
        if not wheeled:
            return {"position": [0.3 * math.sin(6.0 * at_s)] * len(names)}
        speed = 3.0 * min(1.0, 10.0 * at_s)
        return {"velocity": [-speed if turning and "right" in name else speed for name in names]}

    for rate in (10, 100, 1000):
        simulation = at_rest(make(), rate)
        names, start = simulation.joint_names, simulation.save()
        rounds = []
        for _ in range(ROUNDS // 3):
            simulation.restore(start)
            rounds.append(driven_seconds(simulation, commands))
        ours, bare = (sum(map(min, zip(*one, strict=True))) for one in zip(*rounds, strict=True))
        how = "turning" if turning else "driven"
        figures.append(Figure(f"{make.__name__} at {rate} Hz, {how}", "", "mj_step", ours / bare))


@pytest.fixture
def listener() -> Iterator[None]:
    """A process that takes the states and does nothing with them."""
    script = str(Path(tick_peer.__file__))
    with subprocess.Popen(
        [sys.executable, script, STATES_TOPIC],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as peer:  # fmt: skip
        assert peer.stdout is not None and peer.stdin is not None
        assert peer.stdout.readline() == "ready\n"
        yield
        peer.stdin.close()


@pytest.mark.parametrize("make", ROBOTS)
def test_a_listener_at_each_tick(
    ros: RosGraph, listener: None, make: Callable[[], RobotModel], figures: list[Figure]
) -> None:
    robot, rate = make(), 1000
    state_type = get_message("sensor_msgs/msg/JointState")
    with init(args=[]), Node("benchmark") as node:
        simulation = at_rest(robot, rate)
        ports = TopicPorts(node, simulation, STATES_TOPIC)
        raw = node.create_publisher(state_type, "/raw_states", 10)
        for topic in (STATES_TOPIC, "/raw_states"):
            assert node.wait_for_subscribers(topic, 1, LONGEST_WAIT_S)
        channel, payload, attachment = raw._channel, bytes(64 + 24 * len(robot.joints)), bytes(33)
        bare, floor, ours = [], [], []
        for _ in range(ROUNDS):
            ours.append(loop_seconds(simulation, ticks=True, ports=ports))
            floor.append(
                bare_seconds(simulation, send=lambda: channel.put(payload, attachment=attachment))
            )
            bare.append(bare_seconds(simulation))
    per_tick = 1e6 / (SIMULATED_NS / 1e9 * rate)
    figures.append(
        Figure(
            f"{make.__name__} at {rate} Hz with a listener",
            f"{min(ours) * per_tick:.1f} us a tick, {min(ours) / min(bare):.2f} times mj_step",
            "mj_step and Zenoh",
            min(ours) / min(floor),
        )
    )
