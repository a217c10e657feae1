"""The import names of ROS 2, each case in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

HEAD = "from teleopctl.compat import finder\nfinder.install()\n"


def run(code: str, *path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", HEAD + code],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path)), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def output(code: str, *path: Path, **environment: str) -> str:
    done = run(code, *path, **environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_every_way_of_importing_a_message_gives_the_same_class():
    assert output(
        "import std_msgs.msg\n"
        "import std_msgs.msg as m\n"
        "from std_msgs.msg import String\n"
        "from std_msgs.msg._string import String as Direct\n"
        "from teleopctl.interfaces.store import get_message\n"
        "print(std_msgs.msg.String is m.String is String is Direct"
        " is get_message('std_msgs/msg/String'))\n"
        "print(String(data='x'))"
    ).splitlines() == ["True", "std_msgs.msg.String(data='x')"]


def test_all_names_of_a_package_can_be_imported():
    assert output(
        "from geometry_msgs.msg import *\n"
        "print(Twist().linear.x, PoseStamped.TYPE_NAME, 'Quaternion' in dir())"
    ) == ("0.0 geometry_msgs/msg/PoseStamped True")


def test_services_and_actions_can_be_imported():
    assert output(
        "from example_interfaces.srv import AddTwoInts\n"
        "from example_interfaces.action import Fibonacci\n"
        "print(AddTwoInts.Request(a=1, b=2), Fibonacci.Goal(order=5).order)"
    ) == ("example_interfaces.srv.AddTwoInts_Request(a=1, b=2) 5")


def test_classes_can_be_pickled():
    assert (
        output(
            "import pickle\n"
            "from std_msgs.msg import String\n"
            "from std_srvs.srv import Trigger\n"
            "for c in (String, Trigger, Trigger.Request):\n"
            "    assert pickle.loads(pickle.dumps(c)) is c"
        )
        == ""
    )


@pytest.mark.parametrize(
    ("code", "error"),
    [
        ("from std_msgs.msg import Strin", "did you mean String?"),
        ("import foo_msgs.msg", "ModuleNotFoundError: No module named 'foo_msgs'"),
        ("import std_msgs.srv", "ModuleNotFoundError: No module named 'std_msgs.srv'"),
        ("import std_msgs.msg.foo", "ModuleNotFoundError: No module named 'std_msgs.msg.foo'"),
        ("from std_srvs.srv import Triger", "did you mean Trigger?"),
        ("import std_msgs.foo", "ModuleNotFoundError: No module named 'std_msgs.foo'"),
        ("import rclpy.foo", "ModuleNotFoundError: No module named 'rclpy.foo'"),
        ("import std_msgs.msg\nstd_msgs.msg.foo", "AttributeError"),
    ],
)
def test_what_does_not_exist_is_an_ordinary_import_error(code, error):
    done = run(code)
    assert done.returncode == 1
    assert error in done.stderr.splitlines()[-1]


def test_installing_twice_changes_nothing():
    assert (
        output(
            "import sys\nn = len(sys.meta_path)\nfinder.install()\nprint(len(sys.meta_path) - n)"
        )
        == "0"
    )


def test_what_is_really_installed_wins(tmp_path):
    package = tmp_path / "std_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "msg" / "__init__.py").write_text("String = 'the real one'\n")
    (tmp_path / "rclpy.py").write_text("ok = 'the real one'\n")
    assert output(
        "import rclpy\nfrom std_msgs.msg import String\nprint(String, rclpy.ok)", tmp_path
    ) == ("the real one the real one")


def test_a_source_package_does_not_hide_its_own_interfaces(tmp_path):
    package = tmp_path / "gadget_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>gadget_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text("string label\n")
    assert output(
        "from gadget_msgs.msg import Gadget\nprint(Gadget(label='a'))",
        tmp_path,
        TELEOPCTL_PACKAGE_PATH=str(tmp_path),
    ) == ("gadget_msgs.msg.Gadget(label='a')")


def test_a_package_of_the_user_adds_to_one_that_is_known(tmp_path):
    package = tmp_path / "std_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "srv").mkdir()
    (package / "package.xml").write_text("<package><name>std_msgs</name></package>")
    (package / "msg" / "Gadget.msg").write_text("string label\n")
    (package / "srv" / "Turn.srv").write_text("float64 angle\n---\n")
    assert output(
        "from std_msgs.msg import Gadget, String\nfrom std_msgs.srv import Turn\n"
        "print(Gadget(label='a'), String(data='b'), Turn.Request(angle=1.0).angle)",
        tmp_path,
        TELEOPCTL_PACKAGE_PATH=str(tmp_path),
    ) == ("std_msgs.msg.Gadget(label='a') std_msgs.msg.String(data='b') 1.0")


def test_a_folder_of_sources_does_not_hide_what_is_served(tmp_path):
    (tmp_path / "tf2_ros" / "src").mkdir(parents=True)
    (tmp_path / "rclpy" / "rclpy").mkdir(parents=True)
    assert output(
        "import rclpy, tf2_ros\nprint(rclpy.ok(), tf2_ros.Buffer.__name__)", tmp_path
    ) == ("False Buffer")


@pytest.mark.parametrize(
    "code",
    [
        "from tf2_ros.buffer import Buffer",
        "from tf2_ros.buffer_interface import BufferInterface, TypeException",
        "from tf2_ros.transform_listener import TransformListener",
        "from tf2_ros.transform_broadcaster import TransformBroadcaster",
        "from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster",
        "from tf2_geometry_msgs import do_transform_pose_stamped, do_transform_point",
        "from tf2_geometry_msgs.tf2_geometry_msgs import do_transform_vector3",
        "from tf2_py import BufferCore, LookupException",
        "from rclpy.event_handler import QoSPublisherMatchedInfo, PublisherEventCallbacks",
        "from rclpy.qos_event import QoSMessageLostInfo",
        "from rclpy.parameter_client import AsyncParameterClient",
        "from rclpy.parameter_event_handler import ParameterEventHandler",
        "from rclpy.parameter import parameter_dict_from_yaml_file, get_parameter_value",
        "from rclpy.qos_overriding_options import QosCallbackResult, QoSOverridingOptions",
        "from rclpy.exceptions import NoTypeSupportImportedException",
        "from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden",
        "from rclpy.logging import get_logging_directory",
        "from cv_bridge import CvBridge, CvBridgeError",
        "from sensor_msgs_py import point_cloud2",
        "import sensor_msgs_py.point_cloud2 as pc2",
        "from tf_transformations import euler_from_quaternion, quaternion_from_euler",
    ],
)
def test_programs_find_the_names_where_ros_2_has_them(code):
    assert output(code) == ""


def test_submodules_of_an_alias_are_loaded_once():
    assert output(
        "import rclpy.node\n"
        "from rclpy.node import Node\n"
        "import teleopctl.compat.rclpy.node as ours\n"
        "print(rclpy.node is ours, Node is ours.Node)"
    ) == ("True True")


def test_other_imports_are_left_alone():
    code = "import json, xml.dom.minidom\ntry: import org.python\nexcept ImportError: print('no')"
    assert output(code) == "no"


def test_asking_for_a_missing_attribute_is_an_ordinary_question():
    assert output("import std_msgs.msg\nprint(hasattr(std_msgs.msg, 'Strin'))") == "False"


def test_modules_list_their_classes():
    assert output("import std_srvs.srv\nprint(dir(std_srvs.srv))") == (
        "['Empty', 'SetBool', 'Trigger']"
    )
    assert "SetBool_Request" in output("import std_srvs.srv._set_bool as m\nprint(dir(m))")
