"""The broadcaster of poses: its message, its transform, and what it makes of no pose; 100 Hz."""

import math

import pytest

from teleopctl.testing import ControlStack, serial_robot

TYPE = "pose_broadcaster/PoseBroadcaster"
NAMES = [
    *(f"position.{axis}" for axis in "xyz"),
    *(f"orientation.{axis}" for axis in "xyzw"),
]
POSE = [1.1, 2.2, 3.3, 0.0, 0.0, 1.0, 0.0]


class Broadcaster:
    """A broadcaster of the pose of ``mocap`` in ``map``."""

    def __init__(self, **parameters):
        states = "".join(f'<state_interface name="{name}"/>' for name in NAMES)
        robot = serial_robot(1, extra_control=f'<sensor name="mocap">{states}</sensor>')
        self.stack = ControlStack(robot)
        self.measure(POSE)
        options = {"pose_name": "mocap", "frame_id": "map", **parameters}
        dotted = {name.replace("__", "."): value for name, value in options.items()}
        self.stack.load_controller("pose", TYPE, dotted)
        self.node = self.stack.nodes["pose"]

    def measure(self, values):
        for name, value in zip(NAMES, values, strict=True):
            self.stack.resources.state_interfaces[f"mocap/{name}"].value = value

    def step(self, count=1):
        self.stack.activate("pose")
        self.stack.step(count)
        return self.node.published("~/pose")[-1]

    @property
    def transforms(self):
        return [message.transforms[0] for message in self.node.published("/tf")]


def values_of(pose):
    position, turn = pose.position, pose.orientation
    return [position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w]


def test_the_pose_is_published_as_it_is_measured_and_as_a_transform():
    broadcaster = Broadcaster()
    message = broadcaster.step()
    assert values_of(message.pose) == POSE
    assert (message.header.frame_id, message.header.stamp.nanosec) == ("map", 10_000_000)
    (transform,) = broadcaster.transforms
    assert transform.header == message.header
    assert transform.child_frame_id == "mocap"
    assert transform.transform.translation.y == 2.2
    assert transform.transform.rotation.z == 1.0


def test_the_transform_has_a_name_of_its_own_a_rate_or_is_left_out():
    broadcaster = Broadcaster(tf__child_frame_id="base", tf__publish_rate=50.0)
    broadcaster.step(10)
    assert len(broadcaster.node.published("~/pose")) == 10
    assert [transform.child_frame_id for transform in broadcaster.transforms] == ["base"] * 5
    assert "tf.publish_rate parameter is deprecated" in broadcaster.node.log.texts("warning")[0]
    broadcaster = Broadcaster(tf__enable=False)
    broadcaster.step()
    assert "/tf" not in broadcaster.node.endpoints


@pytest.mark.parametrize("broken", [[math.nan, *POSE[1:]], [*POSE[:5], 1.1, 0.0], [0.0] * 7])
def test_what_is_no_pose_is_no_transform_and_told_once_a_second(broken):
    broadcaster = Broadcaster()
    broadcaster.measure(broken)
    assert values_of(broadcaster.step(150).pose) == pytest.approx(broken, nan_ok=True)
    assert not broadcaster.node.published("/tf")
    told = broadcaster.node.log.texts("error")
    assert len(told) == 2
    assert told[0].startswith("Invalid pose [")


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"pose_name": ""}, "Parameter 'pose_name' cannot be empty"),
        ({"frame_id": ""}, "Parameter 'frame_id' cannot be empty"),
        ({"tf__publish_rate": -1.0}, "Parameter 'tf.publish_rate' with the value -1 must be"),
    ],
)
def test_what_is_missing_is_told_when_it_is_configured(parameters, told):
    broadcaster = Broadcaster(**parameters)
    assert not broadcaster.stack.manager.configure_controller("pose")
    assert told in broadcaster.node.log.texts("error")[0]
