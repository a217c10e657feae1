"""The control loop on the wall clock at 1 kHz, against a loop that does nothing.

Both sleep until the multiples of a millisecond; what differs is a cycle with three controllers on
mock hardware. The stamps of ``/joint_states`` are the times at which the cycles began.
"""

import itertools
import threading
import time

from teleopctl.interfaces.store import get_message
from teleopctl.node import Context, Node, QoSProfile
from teleopctl.packages import package_share
from tests.benchmarks.figure import Figure

CONTROLLERS = package_share("teleop_controller") / "teleop_controllers.yaml"
PERIOD_S = 0.001
CYCLES = 5000

JointState = get_message("sensor_msgs/msg/JointState")


def empty_loop() -> list[float]:
    """Times in seconds at which a loop without work comes round."""
    tick = threading.Event()
    times = []
    deadline = time.monotonic()
    for _ in range(CYCLES):
        times.append(time.monotonic())
        deadline += PERIOD_S
        tick.wait(max(0.0, deadline - time.monotonic()))
    return times


def control_loop() -> list[float]:
    """Times in seconds at which the cycles of the controller manager began."""
    context = Context()
    context.init([])
    node = Node("cycle_watch", context=context, start_parameter_services=False)
    times: list[float] = []
    enough = threading.Event()

    def note(message) -> None:
        times.append(message.header.stamp.sec + message.header.stamp.nanosec * 1e-9)
        if len(times) >= CYCLES:
            enough.set()

    node.create_subscription(
        JointState, "/joint_states", note, QoSProfile(depth=100), immediate=True
    )
    assert enough.wait(30.0)
    context.try_shutdown()
    return times[:CYCLES]


def describe(times: list[float]) -> str:
    gaps = sorted(later - earlier for earlier, later in itertools.pairwise(times))
    rate = (len(times) - 1) / (times[-1] - times[0])
    median, worst = gaps[len(gaps) // 2], gaps[int(len(gaps) * 0.99)]
    return f"{rate:6.1f} Hz, gap median {median * 1e3:.3f} ms, 99 % below {worst * 1e3:.3f} ms"


def test_a_kilohertz_on_the_wall_clock(ros, tmp_path, figures: list[Figure]):
    controllers = tmp_path / "controllers.yaml"
    controllers.write_text(
        CONTROLLERS.read_text().replace("update_rate: 10 ", f"update_rate: {round(1 / PERIOD_S)} ")
    )
    up = ros.run(f"launch controller.yaml hardware:=mock controllers_file:={controllers} --detach")
    assert up.returncode == 0, up.stderr
    ours = describe(control_loop())
    assert ros.run("stop --all").returncode == 0
    bare = describe(empty_loop())
    figures.append(Figure("control loop at 1 kHz", ours, f"empty loop: {bare}"))
