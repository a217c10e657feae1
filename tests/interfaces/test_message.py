"""The surface of message, service and action classes."""

import array
import copy
import pickle

import numpy as np
import pytest

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.store import (
    add_definition_text,
    get_action,
    get_class,
    get_message,
    get_service,
)
from teleopctl.node import Duration, Time

String = get_message("std_msgs/msg/String")
JointState = get_message("sensor_msgs/msg/JointState")
Image = get_message("sensor_msgs/msg/Image")
CameraInfo = get_message("sensor_msgs/msg/CameraInfo")
Point = get_message("geometry_msgs/msg/Point")
STATUS = get_message("sensor_msgs/msg/NavSatStatus")


def test_a_class_is_made_once():
    assert get_message("std_msgs/String") is String
    assert String.TYPE_NAME == "std_msgs/msg/String"
    assert (String.__module__, String.__name__) == ("std_msgs.msg._string", "String")


def test_fields_have_the_defaults_of_the_definition():
    quaternion = get_message("geometry_msgs/msg/Quaternion")()
    assert (quaternion.x, quaternion.w) == (0.0, 1.0)
    assert get_message("sensor_msgs/msg/NavSatStatus")().status == -2
    assert String().data == ""
    assert get_message("std_msgs/msg/Bool")().data is False
    assert JointState().position == array.array("d")
    assert JointState().header.stamp.sec == 0
    assert CameraInfo().k.tolist() == [0.0] * 9
    request = get_service("type_description_interfaces/srv/GetTypeDescription").Request()
    assert request.include_type_sources is True


def test_mutable_defaults_are_not_shared():
    JointState().name.append("a")
    CameraInfo().k[0] = 1.0
    assert JointState().name == []
    assert CameraInfo().k[0] == 0.0


def test_constants_are_attributes_of_the_class():
    assert get_message("rcl_interfaces/msg/ParameterType").PARAMETER_DOUBLE == 3
    assert get_message("diagnostic_msgs/msg/DiagnosticStatus").ERROR == b"\x02"
    result = get_action("control_msgs/action/FollowJointTrajectory").Result
    assert result.PATH_TOLERANCE_VIOLATED == -4


def test_text_form_is_that_of_ros():
    assert repr(String(data="Hello")) == "std_msgs.msg.String(data='Hello')"
    assert repr(get_message("geometry_msgs/msg/Vector3")()) == (
        "geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=0.0)"
    )
    assert repr(get_service("example_interfaces/srv/AddTwoInts").Request(a=1, b=2)) == (
        "example_interfaces.srv.AddTwoInts_Request(a=1, b=2)"
    )
    assert repr(get_message("std_msgs/msg/Byte")()) == r"std_msgs.msg.Byte(data=b'\x00')"
    assert "position=[1.0, 2.5], velocity=[]" in repr(JointState(position=[1, 2.5]))
    assert "k=array([0., 0., 0., 0., 0., 0., 0., 0., 0.])" in repr(CameraInfo())


def test_field_types_are_named_as_in_ros():
    fields = JointState.get_fields_and_field_types()
    assert fields["header"] == "std_msgs/Header"
    assert fields["position"] == "sequence<double>"
    assert CameraInfo.get_fields_and_field_types()["k"] == "double[9]"
    event = get_service("std_srvs/srv/SetBool").Event.get_fields_and_field_types()
    assert event["request"] == "sequence<std_srvs/SetBool_Request, 1>"


@pytest.mark.parametrize(
    "values", [[1, 2], (1.0, 2.0), array.array("d", [1, 2]), np.array([1, 2]), range(1, 3)]
)
def test_a_sequence_of_numbers_takes_every_kind_of_sequence(values):
    assert JointState(position=values).position == array.array("d", [1.0, 2.0])


def test_an_array_of_the_right_type_is_kept():
    values = array.array("d", [1.0])
    message = JointState(position=values)
    values.append(2.0)
    assert message.position is values


def test_bytes_and_pictures_become_uint8_sequences():
    picture = np.arange(12, dtype=np.uint8).reshape(2, 2, 3)
    assert Image(data=picture).data == array.array("B", range(12))
    assert Image(data=b"abc").data.tobytes() == b"abc"
    assert Image(data=bytearray(b"abc")).data.tobytes() == b"abc"


def test_fixed_arrays_are_numpy_arrays_of_their_own():
    values = np.ones(9)
    message = CameraInfo(k=values)
    values[0] = 5.0
    assert message.k[0] == 1.0
    assert message.k.dtype == np.float64
    message.k[1] = 7.0
    assert message.k[1] == 7.0


def test_bytes_and_bools_are_lists():
    message = get_message("std_msgs/msg/ByteMultiArray")(data=b"\x01\x02")
    assert message.data == [b"\x01", b"\x02"]
    value = get_message("rcl_interfaces/msg/ParameterValue")(bool_array_value=np.array([True]))
    assert value.bool_array_value == [True]
    assert get_message("std_msgs/msg/Byte")(data=200).data == b"\xc8"


@pytest.mark.parametrize(
    ("type_name", "field", "value", "error"),
    [
        ("std_msgs/msg/String", "data", 5, "expected string, got 5"),
        ("std_msgs/msg/UInt8", "data", 256, "not in 0…255"),
        ("std_msgs/msg/Int32", "data", 1.5, "expected int32, got 1.5"),
        ("std_msgs/msg/Int32", "data", "1", "expected int32, got '1'"),
        ("std_msgs/msg/Bool", "data", 1, "expected bool, got 1"),
        ("std_msgs/msg/Float64", "data", "x", "expected float64, got 'x'"),
        ("std_msgs/msg/Float32", "data", 1e300, "out of range"),
        ("std_msgs/msg/Byte", "data", b"ab", "expected byte"),
        ("std_msgs/msg/Float64MultiArray", "data", "abc", "expected float64[], got 'abc'"),
        ("std_msgs/msg/Float64MultiArray", "data", [1, "x"], "element 1: expected float64"),
        ("std_msgs/msg/Float32MultiArray", "data", [1, -1e39], "element 1: expected float32"),
        ("std_msgs/msg/UInt8MultiArray", "data", [1, 300], "element 1: expected uint8, got 300"),
        ("std_msgs/msg/UInt8MultiArray", "data", np.array([300]), "outside 0…255"),
        ("std_msgs/msg/Int32MultiArray", "data", np.array([1.5]), "array of float64"),
        ("sensor_msgs/msg/CameraInfo", "k", [1.0], "expected float64[9], got 1 elements"),
        ("sensor_msgs/msg/JointState", "name", "joint", "expected string[], got 'joint'"),
        ("sensor_msgs/msg/JointState", "name", [1], "element 0: expected string"),
        ("sensor_msgs/msg/JointState", "header", String(), "got std_msgs/msg/String"),
        ("geometry_msgs/msg/Polygon", "points", [Point()], "element 0: expected geometry_msgs"),
        ("shape_msgs/msg/SolidPrimitive", "dimensions", [0.0] * 4, "got 4 elements"),
    ],
)
def test_a_wrong_value_is_refused_when_it_is_assigned(type_name, field, value, error):
    message = get_message(type_name)()
    with pytest.raises((TypeError, ValueError)) as caught:
        setattr(message, field, value)
    assert isinstance(caught.value, AssertionError)  # what ROS 2's classes raise
    assert str(caught.value).startswith(f"The {field!r} field must be ")
    assert type_name in str(caught.value)
    assert error in str(caught.value)


def test_an_unknown_field_is_refused():
    for kind in (TypeError, AssertionError):
        with pytest.raises(kind, match=r"^Invalid arguments .*constructor: date.*has: data"):
            String(date="x")
    with pytest.raises(AttributeError):
        String().date = "x"


def test_messages_are_equal_by_value():
    one = JointState(name=["a"], position=[1.0])
    assert one == JointState(name=["a"], position=np.array([1.0]))
    assert one != JointState(name=["a"], position=[2.0])
    assert CameraInfo() == CameraInfo()
    assert one != "something else"


def test_messages_can_be_pickled_and_copied():
    message = JointState(name=["a"], position=[1.0])
    assert pickle.loads(pickle.dumps(message)) == message
    deep = copy.deepcopy(message)
    deep.header.frame_id = "changed"
    assert message.header.frame_id == ""
    assert copy.copy(message) == message


def test_a_service_holds_its_messages():
    service = get_service("example_interfaces/AddTwoInts")
    assert service.Request.TYPE_NAME == "example_interfaces/srv/AddTwoInts_Request"
    assert service.Response(sum=3).sum == 3
    assert service.Event().request == []
    assert get_class("example_interfaces/srv/AddTwoInts") is service
    with pytest.raises(NotImplementedError):
        service()


def test_an_action_holds_its_messages_and_services():
    action = get_action("example_interfaces/action/Fibonacci")
    assert action.Goal(order=5).order == 5
    assert action.Impl.SendGoalService.Request(goal=action.Goal(order=5)).goal.order == 5
    assert action.Impl.SendGoalService.TYPE_NAME.endswith("/Fibonacci_SendGoal")
    assert action.Impl.FeedbackMessage().feedback == action.Feedback()
    assert action.Impl.CancelGoalService is get_service("action_msgs/srv/CancelGoal")


@pytest.mark.parametrize(
    ("get", "name", "hint"),
    [
        (get_message, "std_msgs/msg/Strin", "std_msgs/msg/String"),
        (get_message, "std_msg/msg/String", "std_msgs/msg/String"),
        (get_message, "my_own_msgs/msg/Xyzzy", "TELEOPCTL_PACKAGE_PATH"),
        (get_service, "std_srvs/srv/Triger", "std_srvs/srv/Trigger"),
    ],
)
def test_an_unknown_type_is_an_error_that_says_what_to_do(get, name, hint):
    with pytest.raises(TeleopctlError) as caught:
        get(name)
    assert name in caught.value.message
    assert hint in (caught.value.hint or "")


def test_a_service_is_no_message():
    with pytest.raises(TeleopctlError, match="not a message"):
        get_message("std_srvs/srv/Trigger")
    with pytest.raises(TeleopctlError, match="not a service"):
        get_service("std_srvs/srv/Trigger_Request")
    with pytest.raises(TeleopctlError, match="not an action"):
        get_action("example_interfaces/action/Fibonacci_Goal")


def test_a_field_named_like_a_keyword_gets_an_underscore():
    add_definition_text("keyword_msgs/msg/Route", "string from\nstring to\n")
    route = get_message("keyword_msgs/msg/Route")(from_="a", to="b")
    assert repr(route) == "keyword_msgs.msg.Route(from_='a', to='b')"


def test_a_type_in_use_cannot_be_redefined():
    add_definition_text("redefined_msgs/msg/A", "int8 x\n")
    get_message("redefined_msgs/msg/A")
    add_definition_text("redefined_msgs/msg/A", "int8 x  # the same\n")
    with pytest.raises(TeleopctlError, match="already in use"):
        add_definition_text("redefined_msgs/msg/A", "int16 x\n")


def test_a_time_of_the_client_library_becomes_the_message_that_it_stands_for():
    header = get_message("std_msgs/msg/Header")()
    header.stamp = Time(seconds=3)
    assert header.stamp == get_message("builtin_interfaces/msg/Time")(sec=3)
    with pytest.raises(TypeError, match="stamp"):
        header.stamp = Duration(seconds=3)


@pytest.mark.parametrize(
    ("type_name", "field", "value", "text"),
    [
        ("std_msgs/msg/String", "data", 5, "of type 'str'"),
        (
            "std_msgs/msg/Float32",
            "data",
            1e39,
            r"a float in \[-3.402823466e\+38, ",
        ),
        ("std_msgs/msg/UInt8", "data", -1, r"an unsigned integer in \[0, 255\]"),
        ("std_msgs/msg/Byte", "data", b"ab", "of type 'bytes' or 'ByteString' with length 1"),
        ("sensor_msgs/msg/JointState", "header", 1, "a sub message of type 'Header'"),
        (
            "sensor_msgs/msg/JointState",
            "name",
            [1],
            "a set or sequence and each value of",
        ),
        (
            "sensor_msgs/msg/CameraInfo",
            "k",
            [1.0],
            "a set or sequence with length 9 and each value of type 'float' and each double in",
        ),
    ],
)
def test_a_field_says_what_it_takes_in_the_words_of_ros(type_name, field, value, text):
    with pytest.raises(AssertionError, match=rf"^The '{field}' field must be {text}"):
        setattr(get_message(type_name)(), field, value)


def test_constants_and_defaults_stay_as_they_are():
    for cls, name in ((get_message("std_msgs/msg/Int8"), "X__DEFAULT"), (STATUS, "STATUS_FIX")):
        with pytest.raises(AttributeError, match=name):
            setattr(cls, name, 5)
    assert STATUS.STATUS_FIX == 0
    constants = STATUS._Metaclass_NavSatStatus__constants  # what ros2cli reads
    assert (constants["STATUS_FIX"], constants["SERVICE_GPS"]) == (0, 1)
    add_definition_text("words/msg/Words", "string[] said ['a', 'b']\nstring other")
    words = get_message("words/msg/Words")
    words.SAID__DEFAULT.append("c")
    assert words.SAID__DEFAULT == ["a", "b"]
    assert not hasattr(words, "OTHER__DEFAULT")
