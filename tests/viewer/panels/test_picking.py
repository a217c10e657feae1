"""A click on a link: what it is, and what can be done with it."""

import html
from types import SimpleNamespace

import pytest

from teleopctl.interfaces import get_message
from teleopctl.testing import eventually
from teleopctl.tf import Transform
from teleopctl.viewer import PageLayout
from teleopctl.viewer.panels.picking import contact_forces
from teleopctl.viewer.panels.scene import ScenePanel
from teleopctl.viewer.panels.tools import ToolsPanel
from teleopctl.viewer.scene_view import SceneView
from tests.viewer.displays.conftest import put_frame

STRING = get_message("std_msgs/msg/String")
BOX = '<visual><geometry><box size="1 2 3"/></geometry></visual>'
URDF = f"""<robot name="r">
<link name="base">{BOX}</link><link name="arm">{BOX}</link><link name="tool">{BOX}</link>
<joint name="hip" type="revolute"><parent link="base"/><child link="arm"/>
<limit lower="-1" upper="2" velocity="3" effort="4"/></joint>
<joint name="fixed" type="fixed"><parent link="arm"/><child link="tool"/></joint>
</robot>"""


class Workspace:
    """Records what is asked of the workspace."""

    def __init__(self):
        self.calls = []

    def set_open(self, *words, **named):
        self.calls.append(("set_open", *words, *named.values()))

    def plot_joint(self, _client, joint):
        self.calls.append(("plot_joint", joint))


@pytest.fixture
def scene(stage):
    stage.scene_view = SceneView(stage.server, stage)
    stage.workspace = Workspace()
    stage.scene_view.begin()
    panel = ScenePanel(stage)
    panel.build()
    put_frame(stage, "base", "map", Transform())
    put_frame(stage, "tool", "base", Transform((1.0, 2.0, 3.0)))
    stage.frames.update()
    stage.publish("/robot_description", STRING(data=URDF))
    return panel


def click(stage, link):
    """Click on a link: the text of the window, and its buttons."""
    client = SimpleNamespace(client_id=1, gui=stage.gui)
    handles = stage.scene._handle_from_node_name
    path = next(path for path in handles if f"/{link}/" in path and path.endswith("visual0"))
    handles[path]._impl.click_cb[0].callback(SimpleNamespace(client=client))
    (modal,) = stage.gui._modal_handle_from_uuid.values()
    text, _forces, buttons, _close = modal._children.values()
    return text.content, buttons


def test_a_clicked_link_is_named_with_its_frame_and_the_joint_that_moves_it(scene, stage):
    del scene
    text, buttons = click(stage, "tool")
    assert "frame <b>tool</b>" in text
    assert "at 1.000, 2.000, 3.000 m in " in text
    assert "joint <b>hip</b>, revolute" in text
    assert "from -1 to 2 rad<br>at most 3 rad/s<br>at most 4 N m" in text
    assert buttons.options == ("Follow", "Trace", "Axes", "Hide", "Slider", "Plot")
    stage.choose(buttons, "Plot")
    assert stage.workspace.calls == [("plot_joint", "hip")]
    assert not stage.gui._modal_handle_from_uuid


def test_a_link_is_hidden_as_rviz_hides_it_and_shown_again(scene, stage):
    del scene
    robot = next(d for d in stage.scene_view.displays if d.rviz_class == "RobotModel")
    stage.choose(click(stage, "tool")[1], "Hide")
    assert robot.values.given["Links"] == {"tool": {"Value": False}}
    assert robot.hidden_links() == ["tool"]
    _, buttons = click(stage, "base")
    # The root has no joint above it.
    assert buttons.options == ("Follow", "Trace", "Axes", "Hide", "Show all links")
    stage.choose(buttons, "Show all links")
    assert robot.hidden_links() == []


def test_a_link_is_followed_and_traced(scene, stage):
    del scene
    stage.choose(click(stage, "tool")[1], "Trace")
    assert stage.scene_view.displays[-1].name == "Trace of tool"
    stage.choose(click(stage, "tool")[1], "Follow")
    assert stage.scene_view.followed(1) == "tool"
    _, buttons = click(stage, "tool")
    stage.choose(buttons, "Stop following")
    assert stage.scene_view.followed(1) == ""


def test_displays_that_were_changed_by_hand_are_kept(scene, stage):
    assert scene.state() is None
    grid = next(row for row in scene._rows.values() if row._display.name == "Grid")
    stage.choose(
        next(c for c in grid._folder._children.values() if getattr(c, "label", "") == "Show"), False
    )
    kept = scene.state()
    again = ScenePanel(stage)
    again.build()
    again.restore(kept)
    again.tick()
    drawn = {display.name: display.is_enabled for display in stage.scene_view.displays}
    assert drawn == {"Grid": False, "RobotModel": True, "TF": False}
    assert again.state() == kept
    states: list[object] = [None, [], {"rviz": 3}]
    for wrong in states:
        again.restore(wrong)
    assert again.state() == kept


def test_an_added_display_takes_the_first_topic_of_its_type_or_says_that_there_is_none(
    scene, stage
):
    stage.node.topics["/scan"] = ["sensor_msgs/msg/LaserScan"]

    def add():
        scene._kind.value = "LaserScan"
        scene._add()
        scene.tick()
        row = scene._rows[id(stage.scene_view.displays[-1])]
        return stage.scene_view.displays[-1].topic, row._folder.label, row._status_text.content

    assert add() == ("/scan", "☑ LaserScan", "")
    topic, title, status = add()
    assert (topic, title) == ("", "☑ LaserScan 2 ⚠")
    assert "No topic" in status
    stage.node.topics["/path"] = ["nav_msgs/msg/Path"]
    scene.graph_changed()
    # What is drawn already is not offered again.
    assert scene._kind.options[:2] == ("/path · Path", "AccelStamped")
    scene._kind.value = "/path · Path"
    scene._add()
    assert stage.scene_view.displays[-1].topic == "/path"


def test_two_points_of_the_robot_or_the_ground_are_measured(scene, stage):
    tools = scene._tools
    stage.choose(tools._buttons, "Measure")
    for x in (0.0, 5.0):
        tools._click(SimpleNamespace(client_id=1, ray_origin=(x, 0, 9), ray_direction=(0, 0, -2)))
    # The base is 3 m high, so that the first point lies 1.5 m above the ground.
    plain = html.unescape(tools._advice.content)
    assert "5.22 m: 5 along x, 0 along y, 1.5 along z" in plain
    number = stage.scene.get_handle_by_name("/click_tool_number")
    assert number.text == "5.22 m"
    assert tuple(number.position) == (2.5, 0.0, 0.75)
    assert "Measure ✕" in tools._buttons.options
    stage.choose(tools._buttons, "Measure ✕")
    assert not tools.is_active
    assert stage.scene.get_handle_by_name("/click_tool_number") is None


def test_the_window_of_a_link_shows_where_its_joint_is(scene, stage):
    del scene
    click(stage, "tool")
    (modal,) = stage.gui._modal_handle_from_uuid.values()
    live = list(modal._children.values())[1]
    state = get_message("sensor_msgs/msg/JointState")(
        name=["knee", "hip"], position=[9.0, 0.5], velocity=[9.0, -1e-15]
    )

    def is_shown():
        stage.publish("/joint_states", state)
        return "now position 0.5, velocity 0" in live.content

    eventually(is_shown)


def test_the_window_of_a_link_shows_what_it_touches(scene, stage):
    del scene
    stage.node.topics["/contacts"] = ["ros_gz_interfaces/msg/Contacts"]
    click(stage, "tool")
    (modal,) = stage.gui._modal_handle_from_uuid.values()
    forces = list(modal._children.values())[1]
    contact = get_message("ros_gz_interfaces/msg/Contact")()
    contact.collision1.name, contact.collision2.name = "r::tool::c", "cube"
    wrench = get_message("ros_gz_interfaces/msg/JointWrench")()
    wrench.body_1_wrench.force.x, wrench.body_1_wrench.force.z = 3.0, 4.0
    contact.wrenches = [wrench]
    message = get_message("ros_gz_interfaces/msg/Contacts")(contacts=[contact])
    assert contact_forces(message, "too") == {}

    def is_shown():
        stage.publish("/contacts", message)
        return "touches <b>cube</b> with 5 N" in forces.content

    eventually(is_shown)
    modal.close()
    stage.publish("/contacts", message)
    assert not stage.listens_to("/contacts")


def test_a_browser_films_what_it_sees_and_looks_through_the_camera(scene, stage):
    del scene
    tools = ToolsPanel(stage)
    stage.workspace.layout_in = lambda _client: PageLayout()
    tools.build()
    event = SimpleNamespace(client=SimpleNamespace(client_id=7, camera=SimpleNamespace()))
    for part in ("MediaRecorder", "teleopctlFilm?.stop"):
        tools._views._film(event)
        browser, script = stage.scripts[-1]
        assert browser == 7
        assert part in script
    tools._views._look_through("/camera_info", event)
    info = get_message("sensor_msgs/msg/CameraInfo")()
    info.header.frame_id = "tool"
    stage.publish("/camera_info", info)
    assert event.client.camera.position == (1.0, 2.0, 3.0)
    assert event.client.camera.look_at == (1.0, 2.0, 4.0)
    assert not stage.listens_to("/camera_info")
