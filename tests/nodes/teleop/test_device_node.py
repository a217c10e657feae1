"""A device's node: a mapping that names inputs which the device lacks."""

import os

import pytest

from teleopctl.node import Parameter, RcutilsLogger, init, try_shutdown
from teleopctl.nodes.teleop.device_node import DeviceNode
from teleopctl.teleop import DeviceError
from teleopctl.testing import eventually
from tests.emulated_gamepad import EmulatedGamepad

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a named pipe")


@pytest.fixture
def check(ros, tmp_path):
    """Function that makes the node of a gamepad, and checks a mapping that has some lines more."""
    del ros
    pad = EmulatedGamepad(tmp_path / "js0")
    nodes = []

    def check_inputs(lines):
        mapping = tmp_path / "mine.yaml"
        mapping.write_text(f"device: gamepad\nenable_button: left_bumper\n{lines}\n")
        init()
        given = {"device": "gamepad", "mapping": str(mapping), "dev": str(pad.path)}
        node = DeviceNode([Parameter(name, value=value) for name, value in given.items()])
        nodes.append(node)
        # A pipe says its inputs one by one; the node checks again once it knows the robot.
        eventually(lambda: "right_stick" in node.device.inputs())
        node._check_inputs()

    yield check_inputs
    for node in nodes:
        node.close()
        node.destroy_node()
    try_shutdown()


@pytest.mark.parametrize(
    ("lines", "lacked"),
    [
        ("axis_linear: {x: left_z}", "left_z"),
        ("actions: {stop: bb}", "bb"),
        ("actions: {stop: bb, slower: cc}", "bb, cc"),
    ],
)
def test_a_gamepad_without_an_axis_or_the_stop_button_of_its_mapping_is_refused(
    check, lines, lacked
):
    with pytest.raises(DeviceError, match=f"The gamepad has no {lacked}, which its mapping uses;"):
        check(lines)


def test_a_gamepad_without_other_buttons_of_its_mapping_is_used_and_they_are_named(
    check, monkeypatch
):
    warned: list[str] = []
    monkeypatch.setattr(RcutilsLogger, "warning", lambda _, text, **__: warned.append(text))
    check("actions: {stop: b, slower: cc}\ngripper: {toggle: dd}")
    (text,) = (text for text in warned if text.startswith("The gamepad"))
    assert text.startswith("The gamepad has no cc, dd, which its mapping uses; it has a, b, back")
