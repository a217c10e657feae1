"""``parameter_bridge`` and the names that Gazebo gives to sensors without a ``<topic>``."""

import pytest

from teleopctl.nodes.gazebo.bridges import simulated_topics

LONG = "/world/depot/model/robot/link/base_link/sensor"


@pytest.mark.parametrize(
    ("gazebos", "ours"),
    [
        (f"{LONG}/rplidar/scan", ("/rplidar",)),
        (f"{LONG}/rplidar/scan/points", ("/rplidar/points",)),
        (f"{LONG}/chip imu/imu", ("/chip_imu",)),
        (f"{LONG}/eye/image", ("/eye/image", "/eye/image_raw", "/image_raw")),
        (f"{LONG}/eye/depth_image", ("/eye/depth_image",)),
        ("/world/depot/model/robot/model/arm/link/l/sensor/wrist/forcetorque", ("/wrist",)),
        ("/scan", ("/scan",)),
        ("/world/depot/clock", ("/world/depot/clock",)),
    ],
)
def test_a_sensors_long_name_is_the_simulators(gazebos: str, ours: tuple[str, ...]) -> None:
    assert simulated_topics(gazebos) == ours


def test_what_a_bridge_calls_by_its_long_name_is_passed_on(ros) -> None:
    name = f"{LONG}/rplidar/scan"
    bridge = ros.spawn(
        [
            *("run", "ros_gz_bridge", "parameter_bridge"),
            f"{name}@sensor_msgs/msg/LaserScan[gz.msgs.LaserScan",
            *("--ros-args", "-r", f"{name}:=/scan"),
        ]
    )
    bridge.wait_for_line("Passing on /rplidar as /scan")
    ros.spawn("topic pub -r 20 /rplidar sensor_msgs/msg/LaserScan '{range_max: 7.0}'")

    echoed = ros.run("topic echo --once --no-arr /scan sensor_msgs/msg/LaserScan")
    assert "range_max: 7.0" in echoed.stdout
