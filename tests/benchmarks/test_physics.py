"""The simulator's loop without controllers, as fast as it can, against MuJoCo alone.

Both take the same physics steps of the same robot in one process, in turns. What the loop adds is
paid each time that it goes round, and it goes round less often while nobody takes part: the ratio
should not depend on the rate of the control ticks. With somebody at each tick it does, and that is
shown beside it.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import mujoco
import pytest

from teleopctl.mujoco_model.model import RobotModel, build_model
from teleopctl.packages import package_share
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro_file import expand_xacro
from teleopctl.sim.lockstep import LockstepLoop
from teleopctl.sim.simulation import Simulation
from tests.sim.robots import control, joint, link, model

ARM = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
SIMULATED_NS = 2_000_000_000
ROUNDS = 5


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


class End:
    """A sampler that stops the loop at the end."""

    loop: LockstepLoop

    def next_ns(self) -> int:
        return SIMULATED_NS

    def sample(self, time_ns: int) -> None:
        if time_ns >= SIMULATED_NS:
            self.loop.stop()


def loop_seconds(robot: RobotModel, period_ns: int, *, ticks: bool) -> float:
    """Processor time of our loop."""
    end = End()
    simulation = Simulation(robot, control_period_ns=period_ns)
    end.loop = LockstepLoop(simulation, Silence(), real_time_factor=0.0, sampler=end)
    end.loop.set_heard(clock=ticks, ticks=ticks)
    start = time.process_time()
    end.loop.run()
    return time.process_time() - start


def bare_seconds(robot: RobotModel, period_ns: int) -> float:
    """Processor time of MuJoCo, called once for each tick."""
    steps = -(-period_ns // 1_000_000)
    robot.mj_model.opt.timestep = period_ns * 1e-9 / steps
    data = mujoco.MjData(robot.mj_model)
    start = time.process_time()
    for _ in range(SIMULATED_NS // period_ns):
        mujoco.mj_step(robot.mj_model, data, steps)
    return time.process_time() - start


@pytest.mark.parametrize("make", [arm, walker])
def test_physics_without_controllers(make: Callable[[], RobotModel], capsys) -> None:
    robot = make()
    for rate in (10, 100, 500, 1000):
        period_ns = 1_000_000_000 // rate
        # In turns, and the least of each: what else the machine does disturbs neither.
        bare, alone, attended = [], [], []
        for _ in range(ROUNDS):
            alone.append(loop_seconds(robot, period_ns, ticks=False))
            bare.append(bare_seconds(robot, period_ns))
            attended.append(loop_seconds(robot, period_ns, ticks=True))
        ratio = min(alone) / min(bare)
        with capsys.disabled():
            print(
                f"\n{make.__name__:6} {rate:5d} Hz: {ratio:.2f} times bare mj_step, "
                f"{min(attended) / min(bare):.2f} with somebody at each tick"
            )
        assert ratio < 1.2
