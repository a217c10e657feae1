"""Publishing, calling and sending goals by a form, in a graph; and the form of any message."""

import pytest

from teleopctl.errors import UsageError
from teleopctl.interfaces import get_action, get_message, get_service
from teleopctl.node import ActionServer
from teleopctl.viewer.panels import message_form
from teleopctl.viewer.panels.message_form import MessageForm
from teleopctl.viewer.panels.send import SendPanel

PoseStamped = get_message("geometry_msgs/msg/PoseStamped")
JointState = get_message("sensor_msgs/msg/JointState")
SetBool = get_service("std_srvs/srv/SetBool")
Fibonacci = get_action("example_interfaces/action/Fibonacci")


def form_of(page, type_name):
    form = MessageForm(page.gui, get_message(type_name))
    return form, form._controls


def test_a_form_has_a_control_for_each_field_and_stamps_are_now(page):
    form, controls = form_of(page, "geometry_msgs/msg/PoseStamped")
    assert [*controls][:3] == ["header.frame_id", "pose.position.x", "pose.position.y"]
    assert controls["pose.orientation.w"].value == 1.0
    controls["header.frame_id"].value = "map"
    controls["pose.position.x"].value = 1.5
    message = form.message(3_000_000_007)
    assert (message.header.frame_id, message.pose.position.x) == ("map", 1.5)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (3, 7)


def test_lists_are_yaml_and_what_does_not_fit_is_told_with_its_field(page):
    form, controls = form_of(page, "sensor_msgs/msg/JointState")
    controls["name"].value = "[hip, knee]"
    controls["position"].value = "[1, 2.5]"
    message = form.message(0)
    assert (message.name, list(message.position)) == (["hip", "knee"], [1.0, 2.5])
    for text in ("[1, two]", "[1, ", "{a: 1}"):
        controls["position"].value = text
        with pytest.raises(UsageError, match="position"):
            form.message(0)


def test_a_large_message_is_typed_as_yaml(page, monkeypatch):
    monkeypatch.setattr(message_form, "MOST_CONTROLS", 5)
    form, controls = form_of(page, "nav_msgs/msg/Odometry")
    assert not controls
    form._text.value = form._text.value.replace("child_frame_id: ''", "child_frame_id: base")
    assert form.message(0).child_frame_id == "base"


def test_a_message_is_published_a_service_called_and_a_goal_sent(live):
    node = live.node
    received: list[object] = []
    called: list[bool] = []
    node.create_subscription(PoseStamped, "/goal", received.append, 10)

    def serve(request, response):
        called.append(request.data)
        response.success, response.message = True, "<b>done</b>"
        return response

    node.create_service(SetBool, "/switch", serve)

    def execute(goal):
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order])

    server = ActionServer(node, Fibonacci, "/count", execute)
    panel = SendPanel(live)
    live.show(panel)
    live.until(lambda: {"topic /goal", "service /switch", "action /count"} <= {*panel._targets})
    assert not any("get_parameters" in name for name in panel._targets)

    def put(field, value):
        assert panel._form is not None
        panel._form._controls[field].value = value

    def choose(name):
        live.choose(panel._choice, name)
        return next(one for one in panel._place._children.values() if hasattr(one, "options"))

    buttons = choose("topic /goal")
    put("pose.position.x", 2.0)
    live.choose(buttons, "Publish")
    live.until(lambda: received)
    assert received[0].pose.position.x == 2.0  # type: ignore[attr-defined]
    live.choose(buttons, "at 10 Hz")
    live.until(lambda: len(received) > 2)
    live.choose(buttons, "Stop")

    buttons = choose("service /switch")
    put("data", True)
    live.choose(buttons, "Call")
    live.until(lambda: "success: true" in panel._answer.content)
    assert called == [True]
    assert "<b>" not in panel._answer.content

    buttons = choose("action /count")
    put("order", 5)
    live.choose(buttons, "Send goal")
    live.until(lambda: "succeeded" in panel._answer.content)
    assert "- 5" in panel._answer.content
    server.destroy()
