"""The device of the topic joy gives the inputs of each message."""

from types import SimpleNamespace
from typing import Any

from teleopctl.interfaces import get_message, serialize
from teleopctl.teleop import HandSample
from teleopctl.teleop.devices.joy import JoyTopic

Joy = get_message("sensor_msgs/msg/Joy")


def test_inputs_are_those_of_the_newest_message_whatever_its_stamp():
    samples: list[HandSample] = []
    callbacks: list[Any] = []
    node: Any = SimpleNamespace(
        create_subscription=lambda _kind, _topic, callback, *_, **__: callbacks.append(callback)
    )
    JoyTopic(node, samples.append).start()
    message = Joy(axes=[0.5, 0.0], buttons=[0, 1])
    for stamp_s, axis in ((1, 0.5), (2, 0.5), (3, -0.5)):
        message.header.stamp.sec, message.axes[0] = stamp_s, axis
        callbacks[0](bytes(serialize(message)))
    assert [sample.axes["0"] for sample in samples] == [0.5, 0.5, -0.5]
    assert samples[1] is samples[0], "inputs that stay as they are cost nothing"
    assert [sample.sequence for sample in samples] == [1, 1, 2]
    assert all(sample.buttons == {"1"} for sample in samples)
