"""The force-torque broadcaster's filters, exported states and changing parameters."""

import math

import pytest

from teleopctl.control.controllers.chainable import ChainableControllerInterface
from teleopctl.interfaces import get_message
from teleopctl.node import Parameter
from teleopctl.testing import ControlStack, serial_robot
from tests.control.controllers.test_filters import LOW_PASS, chain_of

TYPE = "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"
NAMES = [f"{part}.{axis}" for part in ("force", "torque") for axis in "xyz"]
TRANSFORM = get_message("geometry_msgs/msg/TransformStamped")
TRANSFORMS = get_message("tf2_msgs/msg/TFMessage")
LOW_PASS_TYPE = "control_filters/LowPassFilterWrench"
GRAVITY = "control_filters/GravityCompensationWrench"
HALF = math.sqrt(0.5)
TOOL = {
    "world_frame": "world",
    "sensor_frame": "sensor",
    "tool.mass": 2.0,
    "tool.CoG": [0.0, 0.0, 0.1],
}


class Broadcaster:
    """A force-torque broadcaster in the frame ``flange``."""

    def __init__(self, *filters, **parameters):
        states = "".join(f'<state_interface name="{name}"/>' for name in NAMES)
        robot = serial_robot(1, extra_control=f'<sensor name="ft">{states}</sensor>')
        self.stack = ControlStack(robot)
        options = {name.replace("__", "."): value for name, value in parameters.items()}
        controller = self.stack.load_controller(
            "wrench",
            TYPE,
            {
                "sensor_name": "ft",
                "frame_id": "flange",
                **chain_of(*filters, prefix="sensor_filter_chain"),
                **options,
            },
        )
        assert isinstance(controller, ChainableControllerInterface)
        self.controller = controller
        self.node = self.stack.nodes["wrench"]
        self.stack.activate("wrench")

    def connect(
        self,
        parent,
        child,
        rotation=(0.0, 0.0, 0.0, 1.0),
        translation=(0.0, 0.0, 0.0),
        stamp_s=None,
    ):
        transform = TRANSFORM(child_frame_id=child)
        transform.header.frame_id = parent
        position, turn = transform.transform.translation, transform.transform.rotation
        position.x, position.y, position.z = translation
        turn.x, turn.y, turn.z, turn.w = rotation
        topic = "/tf_static"
        if stamp_s is not None:
            topic, transform.header.stamp.sec = "/tf", stamp_s
        self.node.receive(topic, TRANSFORMS(transforms=[transform]))

    def filtered(self, *wrenches):
        for wrench in wrenches:
            for name, value in zip(NAMES, wrench, strict=True):
                self.stack.resources.state_interfaces[f"ft/{name}"].value = value
            self.stack.step()
        return [
            [getattr(getattr(message.wrench, name[:-2]), name[-1]) for name in NAMES]
            for message in self.node.published("~/wrench_filtered")
        ]


def test_a_low_pass_filter_is_that_of_each_component():
    broadcaster = Broadcaster((LOW_PASS_TYPE, LOW_PASS))
    a = math.exp(-2 * math.pi * 20.5 / (1000.0 * 10 ** (1.25 / -10)))
    step = [1.0, -2.0, 3.0, 0.0, 0.5, 6.0]
    found = broadcaster.filtered([0.0] * 6, step, step)
    assert found[1] == [0.0] * 6
    assert found[2] == pytest.approx([(1 - a) * value for value in step])
    assert "Filter active with 1 filters!" in broadcaster.node.log.texts("info")


def test_without_filters_nothing_is_published_as_filtered():
    broadcaster = Broadcaster()
    assert broadcaster.filtered([1.0] * 6) == []
    assert len(broadcaster.node.published("~/wrench")) == 1


def test_an_invalid_filter_leaves_the_raw_wrench():
    broadcaster = Broadcaster(("filters/MeanFilterDouble", {"number_of_observations": 2}))
    assert broadcaster.filtered([1.0] * 6) == []
    assert len(broadcaster.node.published("~/wrench")) == 1
    assert (
        "Declared types are control_filters/GravityCompensationWrench"
        in (broadcaster.node.log.texts("fatal")[0])
    )


def test_the_weight_of_the_tool_is_subtracted_in_the_sensors_frame():
    broadcaster = Broadcaster((GRAVITY, TOOL))
    # The sensor is on its side, its z axis along the world's x; the flange is 0.2 m before it.
    broadcaster.connect("world", "sensor", rotation=(0.0, HALF, 0.0, HALF))
    broadcaster.connect("sensor", "flange", translation=(0.0, 0.0, 0.2))
    weight = 2.0 * 9.81
    # Downwards is the sensor's x: the weight at 0.1 m turns about y, from the flange backwards.
    still = [weight, 0.0, 0.0, 0.0, -0.1 * weight, 0.0]
    (found,) = broadcaster.filtered([value + 1.0 for value in still])
    assert found == pytest.approx([1.0] * 6)


def test_transforms_from_before_a_simulation_reset_are_forgotten():
    broadcaster = Broadcaster((GRAVITY, TOOL))
    broadcaster.connect("world", "flange")
    broadcaster.connect("flange", "sensor", stamp_s=5000)
    assert len(broadcaster.filtered([0.0] * 6)) == 1
    broadcaster.controller.on_restart()
    broadcaster.filtered([0.0] * 6)
    assert len(broadcaster.node.published("~/wrench_filtered")) == 1
    broadcaster.connect("flange", "sensor", stamp_s=1000)
    broadcaster.filtered([0.0] * 6)
    assert len(broadcaster.node.published("~/wrench_filtered")) == 2


def test_without_transforms_nothing_is_published_and_the_log_says_so_once():
    broadcaster = Broadcaster((GRAVITY, TOOL))
    assert broadcaster.filtered([1.0] * 6, [1.0] * 6) == []
    (text,) = broadcaster.node.log.texts("error")
    assert text.startswith("GravityCompensation update failed:")
    assert text.endswith("given frames are datain:flange dataout:flange world:world sensor:sensor")


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"world_frame": ""}, "world_frame' cannot be empty"),
        ({"tool.CoG": [0.0, 0.0]}, "tool.CoG' has the length 2 but must have the length 3"),
        ({"tool.mass": math.nan}, "tool.mass' has no value"),
    ],
)
def test_a_tool_that_is_not_described_is_refused(change, text):
    assert text in Broadcaster((GRAVITY, TOOL | change)).node.log.texts("fatal")[0]


def test_offsets_and_filters_change_while_the_broadcaster_runs():
    broadcaster = Broadcaster((GRAVITY, TOOL | {"tool.CoG": [0.0] * 3}))
    for child in ("sensor", "flange"):
        broadcaster.connect("world", child)
    names = ("offset.force.x", "sensor_filter_chain.filter1.params.tool.mass")
    broadcaster.node.set_parameters(
        [Parameter(name, value=value) for name, value in zip(names, (5.0, 1.0), strict=True)]
    )
    (found,) = broadcaster.filtered([0.0] * 6)
    assert found == pytest.approx([5.0, 0.0, 9.81, 0.0, 0.0, 0.0])


def test_the_corrected_wrench_is_exported_for_other_controllers():
    broadcaster = Broadcaster(multiplier__force__y=-1.0)
    broadcaster.filtered([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    exported = broadcaster.controller.exported_state_interfaces
    assert [state.name for state in exported] == [f"wrench/ft/{name}" for name in NAMES]
    assert [state.value for state in exported] == [1.0, -2.0, 3.0, 4.0, 5.0, 6.0]


def test_a_cleanup_unsubscribes_from_transforms():
    broadcaster = Broadcaster((GRAVITY, TOOL))
    broadcaster.stack.deactivate("wrench")
    broadcaster.stack.manager.cleanup_controller("wrench")
    assert broadcaster.node.endpoints == {}
