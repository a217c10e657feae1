"""What sensors cost, beside MuJoCo alone.

The camera's floor is MuJoCo's own renderer and the sending of as many bytes. Other sensors are
given as shares of a processor core at a usual rate, reading and sending, with a subscriber.
"""

import contextlib
import functools
import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from teleopctl.interfaces.store import get_message
from teleopctl.mujoco_model.model import build_model
from teleopctl.node import Context, Node
from teleopctl.packages import package_share
from teleopctl.robot.description import RobotDescription
from teleopctl.robot.xacro.expansion import expand_xacro
from teleopctl.sim.cameras.channel import CameraPublishers
from teleopctl.sim.cameras.renderer import FAST, CameraRenderer
from teleopctl.sim.sensors.publishing import SensorPublisher, add_sensors, make_sensors
from teleopctl.sim.simulation import Simulation
from tests.benchmarks.figure import Figure
from tests.sim.robots import box, joint, link, robot

ROUNDS = 15
FRAMES = 3
LIMIT = 1.1

RING = """<ray><scan><horizontal><samples>{}</samples><min_angle>-3.14</min_angle>
  <max_angle>3.14</max_angle></horizontal><vertical><samples>{}</samples>
  <min_angle>-0.26</min_angle><max_angle>0.26</max_angle></vertical></scan>
  <range><min>0.1</min><max>30</max></range></ray>"""
NOISE = "<noise type='gaussian'><stddev>0.01</stddev></noise>"
GYRO = f"<imu><angular_velocity><x>{NOISE}</x><y>{NOISE}</y><z>{NOISE}</z></angular_velocity></imu>"
# Type, content and rate in Hz; the first topic is listened to.
SENSORS = {
    "IMU": ("imu", "", 200),
    "IMU with noise": ("imu", GYRO, 200),
    "force and torque": ("force_torque", "", 200),
    "contact": ("contact", "", 50),
    "magnetometer": ("magnetometer", "", 100),
    "GPS": ("navsat", "", 10),
    "lidar, 360 rays": ("gpu_lidar", RING.format(360, 1), 10),
    "lidar, 16 x 1800 rays": ("ray", RING.format(1800, 16), 10),
}
CLOUD = '<plugin name="p" filename="libgazebo_ros_ray_sensor.so"/>'


@contextlib.contextmanager
def nodes(*names: str) -> Iterator[list[Node]]:
    """Nodes of a context of their own."""
    context = Context()
    context.init([])
    made = [Node(name, context=context, start_parameter_services=False) for name in names]
    try:
        yield made
    finally:
        context.try_shutdown()


def processor_seconds(work: Callable[[], object], times: int) -> float:
    start = time.process_time()
    for _ in range(times):
        work()
    return (time.process_time() - start) / times


def sample(publisher: SensorPublisher, times: Iterator[int]) -> None:
    publisher.sample(next(times))


@pytest.mark.timeout(600)
def test_the_tutorials_camera_costs_little_more_than_mujocos_renderer(
    shared_ros, figures: list[Figure]
) -> None:
    import mujoco

    urdf = expand_xacro(package_share("teleop_description") / "urdf" / "teleop.urdf.xacro", {})
    model = build_model(RobotDescription.from_urdf(urdf))
    camera = model.cameras[0]
    renderer = CameraRenderer(model, [camera], FAST)
    renderer.place({})
    image = get_message("sensor_msgs/msg/Image")
    arrived: list[bytes] = []
    with nodes("camera_benchmark", "viewer_benchmark") as (node, viewer):
        for topic in ("/image_raw", "/floor"):
            viewer.create_subscription(
                image, topic, lambda data: arrived.__setitem__(slice(None), [data]), 1,
                raw=True, immediate=True,
            )  # fmt: skip
        channel = CameraPublishers(node, camera, (), lambda name: None)
        floor_publisher = node.create_publisher(image, "/floor", 1)
        while channel.wanted != {"image"} or not floor_publisher.get_subscription_count():
            channel.on_graph_change()
        raw = mujoco.Renderer(model.mj_model, camera.height, camera.width)
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            raw.scene.flags[flag] = False
        data = mujoco.MjData(model.mj_model)
        mujoco.mj_forward(model.mj_model, data)
        picture = np.zeros((camera.height, camera.width, 3), np.uint8)
        bytes_of_one = bytes(200) + picture.tobytes()

        def floor() -> None:
            raw.update_scene(data, camera.name)
            raw.render(out=picture)
            floor_publisher.publish(bytes_of_one)

        def ours() -> None:
            renderer.place({})
            channel.publish(renderer, 0)

        ratios = []
        for _ in range(ROUNDS):
            before = processor_seconds(floor, FRAMES)
            ratios.append(processor_seconds(ours, FRAMES) / before)
        raw.close()
    renderer.close()
    ratio = statistics.median(ratios[1:])
    figures.append(
        Figure("camera 2304x1296", "", "MuJoCo's renderer and sending the bytes", ratio, LIMIT)
    )
    assert ratio < LIMIT


def test_what_each_sensor_costs(shared_ros, figures: list[Figure]) -> None:
    tags = "".join(
        f'<gazebo reference="eye"><sensor name="s{number}" type="{kind}">'
        f"<update_rate>{rate}</update_rate><topic>/s{number}</topic>{content}"
        f"{CLOUD if kind == 'ray' else ''}</sensor></gazebo>"
        for number, (kind, content, rate) in enumerate(SENSORS.values())
    )
    walls = "".join(
        link(f"w{n}", box("visual", size) + box("collision", size))
        + joint(f"j{n}", "base", f"w{n}", kind="fixed", xyz=place)
        for n, (size, place) in enumerate(
            [
                ("0.2 9 3", "4 0 1"),
                ("0.2 9 3", "-4 0 1"),
                ("9 0.2 3", "0 4 1"),
                ("9 0.2 3", "0 -4 1"),
            ]
        )
    )
    description = robot(
        link("base", ""), link("eye"), walls, tags,
        joint("turn", "base", "eye", kind="continuous", axis="0 0 1", limit=""),
    )  # fmt: skip
    warnings: list[str] = []
    sensors = make_sensors(description.gazebo.sensors, warnings.append)
    model = build_model(description, lambda spec: add_sensors(spec, sensors, warnings.append))
    simulation = Simulation(model, control_period_ns=10_000_000)
    sensors = [sensor for sensor in sensors if not sensor.topic.endswith("/points")]
    assert len(sensors) == len(SENSORS), warnings
    with nodes("sensor_benchmark", "reader_benchmark") as (node, reader):
        for (name, (_, _, rate)), sensor in zip(SENSORS.items(), sensors, strict=True):
            publisher = SensorPublisher(node, simulation, [sensor])
            message = get_message(sensor.message_type)
            listening = reader.create_subscription(
                message, sensor.topic, lambda data: None, 1, raw=True, immediate=True
            )
            while publisher.next_ns() is None:
                publisher.on_graph_change()
                publisher.sample(0)
            times = iter(range(10**9, 10**15, 10**9))
            seconds = processor_seconds(functools.partial(sample, publisher, times), 100)
            share = f"{1e2 * seconds * rate:.2f} % of a core at {rate} Hz"
            figures.append(Figure(name, f"{seconds * 1e6:.0f} us a message, {share}"))
            reader.destroy_subscription(listening)
        step = processor_seconds(lambda: simulation.step(1), 2000)
    figures.append(Figure("one step of the model with these sensors", f"{step * 1e6:.0f} us"))
