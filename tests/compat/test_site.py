"""The packages of ``compat/site``: what there is, and where programs find it."""

import ast
import pkgutil
import sys
from pathlib import Path

import pytest

from teleopctl.compat.activation import SITE
from tests.compat.activated import output
from tests.samples import sample

PACKAGES = """
ament_index_python cv_bridge launch launch_ros launch_xml launch_yaml message_filters rclpy
rclpy_components ros2_numpy rosidl_parser rosidl_runtime_py sensor_msgs_py
tf2_geometry_msgs tf2_py tf2_ros tf2_sensor_msgs tf_transformations
controller_manager launch_param_builder moveit_configs_utils nav2_common ros_gz_bridge ros_gz_sim
launch_pytest launch_testing launch_testing_ros
domain_coordinator ament_copyright ament_flake8 ament_lint ament_mypy ament_pep257 ament_xmllint
ros2action ros2cli ros2lifecycle ros2node ros2param ros2pkg ros2service ros2topic
rosbag2_py rosidl_adapter generate_parameter_library_py image_geometry interactive_markers
"""

RCLPY = """
rclpy.action rclpy.action.client rclpy.action.graph rclpy.action.server rclpy.callback_groups
rclpy.client rclpy.clock rclpy.clock_type rclpy.constants rclpy.context rclpy.destroyable
rclpy.duration rclpy.event_handler rclpy.exceptions rclpy.executors rclpy.expand_topic_name
rclpy.experimental rclpy.experimental.events_executor rclpy.guard_condition rclpy.impl
rclpy.impl.implementation_singleton rclpy.impl.logging_severity rclpy.impl.rcutils_logger
rclpy.lifecycle rclpy.lifecycle.managed_entity rclpy.lifecycle.node rclpy.lifecycle.publisher
rclpy.logging rclpy.logging_service rclpy.node rclpy.parameter rclpy.parameter_client
rclpy.parameter_event_handler rclpy.parameter_service
rclpy.publisher rclpy.qos rclpy.qos_event rclpy.qos_overriding_options rclpy.serialization
rclpy.service rclpy.service_introspection rclpy.signals rclpy.subscription
rclpy.subscription_content_filter_options rclpy.task rclpy.time rclpy.time_source rclpy.timer
rclpy.topic_endpoint_info rclpy.topic_or_service_is_hidden rclpy.type_description_service
rclpy.type_hash rclpy.type_support rclpy.utilities rclpy.validate_full_topic_name
rclpy.validate_namespace rclpy.validate_node_name rclpy.validate_parameter_name
rclpy.validate_topic_name rclpy.wait_for_message rclpy.waitable
"""


def test_the_packages_are_those_of_the_list():
    found = {module.name for module in pkgutil.iter_modules([SITE]) if module.ispkg}
    assert found == set(PACKAGES.split())


def test_the_public_modules_of_rclpy_are_those_of_the_list():
    modules = pkgutil.walk_packages([str(Path(SITE, "rclpy"))], "rclpy.")
    public = {module.name for module in modules if "._" not in module.name}
    assert public == set(RCLPY.split())


def test_the_packages_know_each_other_by_their_public_names():
    # OpenCV is optional.
    others = {"cv2", "lxml", "numpy", "pytest", "teleopctl", "yaml"}
    allowed = {*PACKAGES.split(), *sys.stdlib_module_names, *others}
    for file in Path(SITE).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                # One that begins with a dot stays in its package.
                names = [] if node.level else [node.module or ""]
            for name in names:
                package = name.partition(".")[0]
                assert package in allowed or package.endswith(("_msgs", "_interfaces")), file
                assert not name.startswith("teleopctl.compat"), file


@pytest.mark.parametrize(
    "code",
    [
        "from tf2_ros.buffer import Buffer",
        "from tf2_ros.buffer_interface import BufferInterface, TypeException",
        "from tf2_ros.transform_listener import DEFAULT_TF_TOPIC, TransformListener",
        "from tf2_ros.transform_broadcaster import TransformBroadcaster",
        "from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster",
        "from tf2_geometry_msgs import do_transform_pose_stamped, do_transform_point",
        "from tf2_geometry_msgs.tf2_geometry_msgs import do_transform_vector3",
        "from tf2_geometry_msgs import Point, do_transform_wrench, from_msg_msg, to_msg_msg",
        "from tf2_py import BufferCore, LookupException",
        "from rclpy.event_handler import QoSPublisherMatchedInfo, PublisherEventCallbacks",
        "from rclpy.qos_event import QoSMessageLostInfo, QoSLivelinessChangedInfo",
        "from rclpy.event_handler import QoSLivelinessLostInfo, QoSRequestedDeadlineMissedInfo",
        "from rclpy.event_handler import QoSOfferedDeadlineMissedInfo, IncompatibleTypeInfo",
        "from rclpy.event_handler import QoSOfferedIncompatibleQoSInfo as I; I(1, 1, 2)",
        "from rclpy.parameter_client import AsyncParameterClient",
        "from rclpy.parameter_event_handler import ParameterEventHandler",
        "from rclpy.parameter import parameter_dict_from_yaml_file, get_parameter_value",
        "from rclpy.qos_overriding_options import QosCallbackResult, QoSOverridingOptions",
        "from rclpy.exceptions import NoTypeSupportImportedException",
        "from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden",
        "from rclpy.lifecycle import Node, NodeMixin, Publisher, State, TransitionCallbackReturn",
        "from rclpy.logging import get_logging_directory",
        "from rclpy.clock import ClockChange, JumpHandle, JumpThreshold, TimeJump",
        "from rclpy.time_source import TimeSource",
        "from rclpy.signals import install_signal_handlers, uninstall_signal_handlers",
        "from rclpy.executors import WaitableEntityType, TaskData, TimeoutObject, await_or_execute",
        "from rclpy.qos import qos_policy_name_from_kind as name; assert name(4) == 'DEADLINE'",
        "from rclpy.qos import QoSPolicyEnum, qos_profile_default",
        "from rclpy.parameter_service import ParameterService",
        "from rclpy.logging_service import LoggingService",
        "from rclpy.type_description_service import TypeDescriptionService",
        "from rclpy.topic_or_service_is_hidden import HIDDEN_TOPIC_PREFIX",
        "from rclpy.clock import JumpHandlePreCallbackType, TimeJumpDictionary",
        "from rclpy.qos_overriding_options import QosCallbackType, QoSProfileAttributes",
        "from ros2cli.node.strategy import NodeStrategy, add_arguments",
        "from ros2lifecycle.api import call_change_states, call_get_states, get_node_names",
        "from message_filters import ApproximateTimeSynchronizer, Cache, Subscriber",
        "from message_filters import TimeSynchronizer",
        "from rosidl_parser.definition import NamespacedType, UnboundedSequence",
        "from rosidl_runtime_py import message_to_yaml, set_message_fields",
        "from rosidl_runtime_py.utilities import get_action, get_message, get_service",
        "from tf2_sensor_msgs import do_transform_cloud",
        "from tf2_sensor_msgs.tf2_sensor_msgs import transform_points",
        "from cv_bridge import CvBridge, CvBridgeError",
        "from cv_bridge.core import CvBridge",
        "from ament_index_python import get_package_share_directory",
        "from ament_index_python.packages import PackageNotFoundError, get_package_share_path",
        "from sensor_msgs_py import point_cloud2",
        "import sensor_msgs_py.point_cloud2 as pc2",
        "from tf_transformations import euler_from_quaternion, quaternion_from_euler",
    ],
)
def test_programs_find_the_names_where_ros_2_has_them(code):
    exec(code, {})


def test_a_package_that_is_really_installed_is_used_as_a_whole(tmp_path):
    (tmp_path / "rclpy").mkdir()
    (tmp_path / "rclpy" / "__init__.py").write_text("ok = 'the real one'\n")
    code = """
import rclpy, tf2_ros
try:
    import rclpy.node
except ModuleNotFoundError as error:
    print(rclpy.ok, error.name, tf2_ros.Buffer.__module__)
"""
    assert output(code, tmp_path) == "the real one rclpy.node teleopctl.tf.buffer"


def test_a_folder_of_sources_does_not_hide_what_is_served(tmp_path):
    (tmp_path / "tf2_ros" / "src").mkdir(parents=True)
    (tmp_path / "rclpy" / "rclpy").mkdir(parents=True)
    assert output(
        "import rclpy, tf2_ros\nprint(rclpy.ok(), tf2_ros.Buffer.__name__)", tmp_path
    ) == ("False Buffer")


@pytest.mark.parametrize(
    ("call", "error", "text"),
    sample(
        [
            ("parameter.parameter_value_to_python(ParameterValue(type=42))", "RuntimeError", "42"),
            (
                "parameter.parameter_dict_from_yaml_file('nowhere.yaml')",
                "FileNotFoundError",
                "nowhere",
            ),
            (
                "parameter.parameter_dict_from_yaml_file(BAD)",
                "RuntimeError",
                "a mapping of node names",
            ),
            ("expand_topic_name('a', 'b?', '/')", "ValueError", "node name 'b?' is invalid"),
            ("expand_topic_name('a', 'b', '')", "ValueError", "node namespace '' is invalid"),
            ("expand_topic_name('a?', 'b', '/')", "ValueError", "topic name 'a?' is invalid"),
            ("validate_parameter_name('')", "InvalidParameterException", "Invalid parameter name"),
            ("validate_namespace('')", "InvalidNamespaceException", "must not be empty"),
        ],
        2,
    ),
)
def test_functions_raise_what_rclpy_raises(call, error, text, tmp_path):
    (tmp_path / "bad.yaml").write_text("- 1")
    code = f"""
BAD = {str(tmp_path / "bad.yaml")!r}
from rcl_interfaces.msg import ParameterValue
from rclpy import exceptions, parameter
from rclpy.expand_topic_name import expand_topic_name
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_parameter_name import validate_parameter_name
try:
    {call}
except Exception as error:
    print(type(error).__name__, error)
"""
    printed = output(code)
    assert printed.split()[0] == error
    assert text in printed
