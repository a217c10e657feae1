"""What is loaded when, since every start of a command pays for it."""

import subprocess
import sys

import pytest

HEAVY = ("numpy", "rosbags", "yaml", "difflib", "tempfile", "teleopctl.packages")

# Neither these nor what they are made of have a fixed array of numbers.
WITHOUT_FIXED_ARRAYS = (
    "control_msgs/msg/JointTrajectoryControllerState",
    "controller_manager_msgs/srv/ConfigureController_Request",
    "controller_manager_msgs/srv/ListControllers_Response",
    "controller_manager_msgs/srv/ListHardwareComponents_Response",
    "controller_manager_msgs/srv/ListHardwareInterfaces_Response",
    "controller_manager_msgs/srv/LoadController_Request",
    "controller_manager_msgs/srv/SwitchController_Request",
    "rcl_interfaces/msg/Log",
    "rcl_interfaces/msg/ParameterEvent",
    "rcl_interfaces/msg/ParameterValue",
    "rcl_interfaces/srv/DescribeParameters_Response",
    "rcl_interfaces/srv/GetParameters_Response",
    "rcl_interfaces/srv/ListParameters_Response",
    "rcl_interfaces/srv/SetParameters_Request",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/JointState",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/String",
    "tf2_msgs/msg/TFMessage",
    "trajectory_msgs/msg/JointTrajectory",
)

USE = """
from contextlib import suppress
import sys
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.cdr import deserialize, serialize
from teleopctl.interfaces.definition import Shape
from teleopctl.interfaces.store import get_message
from teleopctl.interfaces.yaml import message_from_yaml, message_to_dict, message_to_yaml

EXAMPLES = {"string": "a", "bool": True, "byte": b"a"}

def filled(cls):
    message = cls()
    for field in cls.__definition__.fields:
        kind = field.type
        value = filled(get_message(kind.base)) if kind.is_nested else EXAMPLES.get(kind.base, 1)
        if kind.shape:
            value = [value] * (kind.capacity or 2)
        setattr(message, field.attribute, value)
    return message

for name in sys.argv[1:]:
    cls = get_message(name)
    for message in (cls(), filled(cls)):
        received = deserialize(bytes(serialize(message)), cls)
        assert received == message
        message_to_yaml(received)
        message_to_dict(received)
        READ_ALL and repr(received)
        big = bytes((0, 0, 0, 0)) + bytes(2000)
        with suppress(TeleopctlError):
            deserialize(big, cls)
    message_from_yaml(cls, "")
"""


def loaded(code: str, *arguments: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys\nprint(*sys.modules)", *arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.split())


def test_names_of_types_need_nothing_heavy():
    modules = loaded("import teleopctl.interfaces.typenames")
    assert not modules.intersection(HEAVY)


def test_sending_a_known_message_reads_no_store_and_no_packages():
    code = (
        "from teleopctl.interfaces.store import get_message, type_hash\n"
        "from teleopctl.interfaces.cdr import serialize\n"
        "serialize(get_message('sensor_msgs/msg/JointState')())\n"
        "type_hash('rcl_interfaces/srv/SetParameters')\n"
    )
    loaded(code)  # leaves the table of the distribution in the cache
    modules = loaded(code)
    assert not modules.intersection({"rosbags", "rosbags.typesys", "yaml", "teleopctl.packages"})


def test_messages_need_no_numpy():
    assert "numpy" not in loaded(f"READ_ALL = True\n{USE}", *WITHOUT_FIXED_ARRAYS)


def test_fixed_arrays_that_are_not_read_need_no_numpy():
    names = ("sensor_msgs/msg/CameraInfo", "unique_identifier_msgs/msg/UUID", "sensor_msgs/msg/Imu")
    assert "numpy" not in loaded(f"READ_ALL = False\n{USE}", *names)


@pytest.mark.parametrize("read", ["k", "__repr__()"])
def test_a_fixed_array_that_is_read_is_a_numpy_array(read):
    code = (
        "from teleopctl.interfaces.store import get_message\n"
        f"get_message('sensor_msgs/msg/CameraInfo')().{read}\n"
    )
    assert "numpy" in loaded(code)


def test_a_node_needs_neither_numpy_nor_rosbags():
    modules = loaded("import teleopctl.node.node")
    assert not modules.intersection({"numpy", "rosbags", "yaml"})
