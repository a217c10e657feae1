"""The simulator in lockstep with the controller manager, against MuJoCo alone.

Both step the same model by the same number of physics steps. The rest is the price of the two
processes that wait for each other at each control tick; it is paid per tick, so the ratio depends
on the update rate.
"""

import statistics
import threading
import time

import pytest

from teleopctl.interfaces.store import get_message, get_service
from teleopctl.mujoco_model.model import build_model
from teleopctl.node import Context, Node
from teleopctl.packages import package_share
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.sim.simulation import Simulation
from tests.benchmarks.figure import Figure

CONTROLLERS = package_share("teleop_controller") / "teleop_controllers.yaml"
MODEL = package_share("teleop_description") / "urdf" / "teleop.urdf.xacro"
NANOSECONDS = 1_000_000_000
TICKS = 1000

Clock = get_message("rosgraph_msgs/msg/Clock")
JointState = get_message("sensor_msgs/msg/JointState")
SetPause = get_service("mujoco_ros2_control_msgs/srv/SetPause")


def raw_seconds_per_tick(rate: int) -> float:
    """Wall time in which MuJoCo alone takes the physics steps of one control tick."""
    import mujoco

    model = build_model(RobotDescription.from_urdf(expand_xacro(MODEL, {}))).mj_model
    period_ns = NANOSECONDS // rate
    simulation = Simulation(
        build_model(RobotDescription.from_urdf(expand_xacro(MODEL, {}))),
        control_period_ns=period_ns,
    )
    steps = simulation.steps_per_period
    model.opt.timestep = period_ns * 1e-9 / steps
    data = mujoco.MjData(model)
    start = time.perf_counter()
    for _ in range(TICKS):
        mujoco.mj_step(model, data, steps)
    return (time.perf_counter() - start) / TICKS


class TickWatch(Node):
    """Notes when the state of each tick arrives."""

    def __init__(self, context: Context) -> None:
        super().__init__("tick_watch", context=context, start_parameter_services=False)
        self._enough = threading.Event()
        self.arrivals: list[float] = []
        self.create_subscription(
            JointState, "/robot_joint_states", self._arrived, 10, raw=True, immediate=True
        )

    def _arrived(self, _: bytes) -> None:
        self.arrivals.append(time.perf_counter())
        if len(self.arrivals) > TICKS:
            self._enough.set()

    def run(self) -> float:
        """Let time run for the ticks; the median of the wall time between two of them."""
        client = self.create_client(SetPause, "/mujoco_sim/set_pause")
        assert client.wait_for_service(20.0)
        response = client.call(SetPause.Request(paused=False), 20.0)
        assert response is not None
        assert response.success
        assert self._enough.wait(60.0)
        pairs = zip(self.arrivals, self.arrivals[1:], strict=False)
        return statistics.median(later - earlier for earlier, later in pairs)


@pytest.mark.parametrize("rate", [10, 100, 1000])
def test_a_control_tick_in_lockstep(ros, tmp_path, rate, figures: list[Figure]):
    controllers = tmp_path / "controllers.yaml"
    controllers.write_text(
        CONTROLLERS.read_text().replace("update_rate: 10 ", f"update_rate: {rate} ")
    )
    up = ros.run(
        f"launch sim.yaml world:= camera:=false paused:=true real_time_factor:=0 "
        f"controllers_file:={controllers} --detach"
    )
    assert up.returncode == 0, up.stderr
    context = Context()
    context.init([])
    ours = TickWatch(context).run()
    context.try_shutdown()
    assert ros.run("stop --all").returncode == 0
    raw = raw_seconds_per_tick(rate)
    figures.append(
        Figure(
            f"control tick in lockstep at {rate} Hz",
            f"{ours * 1e6:.0f} us, {1 / (rate * ours):.1f} times real time",
            f"mj_step alone: {raw * 1e6:.0f} us",
            ours / raw,
        )
    )
