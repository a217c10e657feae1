"""The world around a simulated robot is in the picture, and moves with its frames."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from teleopctl.interfaces import get_message
from teleopctl.mujoco_model import build_model
from teleopctl.node import init, qos_profile_latched
from teleopctl.packages import package_share
from teleopctl.robot import RobotDescription, read_world
from teleopctl.sim.world_markers import WORLD_MARKERS_TOPIC, world_markers
from teleopctl.tf import Transform
from teleopctl.viewer import PageLayout, Viewer, open_server
from teleopctl.viewer.scene_view import SceneView
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import SECOND, put_frame

POST = '<robot name="post"><link name="base"/></robot>'


@pytest.mark.parametrize("simulated", [True, False])
def test_the_world_is_shown_in_simulation_alone(page: FakePage, simulated: bool) -> None:
    picture = SceneView(page.server, page, simulated=simulated)
    picture.begin()
    assert ("World" in [display.name for display in picture.displays]) == simulated
    assert page.listens_to(WORLD_MARKERS_TOPIC) == simulated
    picture.end()


def test_displays_of_plans_and_of_servo_come_with_their_topics_and_leave_the_world_alone(
    page: FakePage,
) -> None:
    picture = SceneView(page.server, page, simulated=True)
    picture.begin()
    topics = [
        ("/left/display_planned_path", ["moveit_msgs/msg/DisplayTrajectory"]),
        ("/left/servo_node/status_markers", ["visualization_msgs/msg/MarkerArray"]),
        ("/other/status_markers", ["std_msgs/msg/String"]),
    ]
    page.node.topics.update(topics)
    picture.offer_topics(topics)
    names = [display.name for display in picture.displays]
    assert names[-2:] == ["MotionPlanning", "Servo"]
    plans = picture.displays[-2]
    assert not plans.values.flag("Scene Geometry/Show Simulated World")
    for topic in (
        *("/left/monitored_planning_scene", "/left/display_planned_path"),
        "/left/servo_node/status_markers",
    ):
        assert page.listens_to(topic), topic
    clouds = [(f"/cloud_{number}", ["sensor_msgs/msg/PointCloud2"]) for number in range(6)]
    page.node.topics.update(clouds, **{"/scan": ["sensor_msgs/msg/LaserScan"]})
    picture.offer_topics([("/scan", ["sensor_msgs/msg/LaserScan"]), *clouds])
    shown = [topic for topic in ("/scan", *dict(clouds)) if page.listens_to(topic)]
    assert shown == ["/scan", "/cloud_0", "/cloud_1", "/cloud_2"]
    # What a person removes does not come back.
    picture.remove(plans)
    picture.offer_topics(topics)
    assert plans.name not in [display.name for display in picture.displays]
    picture.end()


# Any: viser's nodes of any kind.
def label_boxes(page: FakePage, picture: SceneView) -> dict[str, Any]:
    """What is drawn of the world, by frame."""
    world = next(display for display in picture.displays if display.name == "World")
    return {
        frame: page.scene.get_handle_by_name(f"{page.frames.node_path(frame)}{world.root}/box")
        for frame in ("base", "cube")
    }


def test_the_world_is_there_after_the_simulation_was_reset(
    page: FakePage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its markers are latched: they come when somebody subscribes, and not again."""
    table = read_world(package_share("teleopctl") / "worlds" / "table.urdf")
    model = build_model(RobotDescription.from_urdf(POST), world=table, fixed_base=True)
    message = get_message("visualization_msgs/msg/MarkerArray")(markers=world_markers(model))
    page.node.get_publishers_info_by_topic = lambda _topic: [
        SimpleNamespace(
            topic_type="visualization_msgs/msg/MarkerArray", qos_profile=qos_profile_latched
        )
    ]
    waiting = []
    subscribe = page.subscribe

    def subscribe_to_latched(topic: str, *arguments: Any) -> Any:
        waiting.append(topic)
        return subscribe(topic, *arguments)

    def deliver() -> None:
        while waiting:
            if waiting.pop() == WORLD_MARKERS_TOPIC:
                page.publish(WORLD_MARKERS_TOPIC, message)

    monkeypatch.setattr(page, "subscribe", subscribe_to_latched)
    picture = SceneView(page.server, page, simulated=True)
    picture.begin()
    put_frame(page, "cube", "base", Transform((-0.15, 1.5, 0.17)))
    page.frames.set_fixed_frame("base")
    page.frames.update()
    for jumped_back in (False, True):
        picture.tick(jumped_back=jumped_back)
        deliver()
        picture.tick(jumped_back=False)
        assert all(label_boxes(page, picture).values()), f"jumped back: {jumped_back}"
    picture.end()


def test_the_cube_is_drawn_in_its_own_frame_and_the_table_in_the_robots(page: FakePage) -> None:
    table = read_world(package_share("teleopctl") / "worlds" / "table.urdf")
    model = build_model(RobotDescription.from_urdf(POST), world=table, fixed_base=True)
    picture = SceneView(page.server, page, simulated=True)
    picture.begin()
    put_frame(page, "cube", "base", Transform((-0.15, 1.5, 0.17)))
    page.frames.set_fixed_frame("base")
    page.frames.update()
    markers = world_markers(model)
    page.publish(
        WORLD_MARKERS_TOPIC, get_message("visualization_msgs/msg/MarkerArray")(markers=markers)
    )
    picture.tick(jumped_back=False)
    boxes = label_boxes(page, picture)
    assert boxes["base"].batched_positions.shape == (5, 3)
    assert boxes["cube"].batched_positions.tolist() == [[0.0, 0.0, 0.0]]

    put_frame(page, "cube", "base", Transform((0.0, 0.0, 3.0)), 2 * SECOND)
    page.frames.update()
    frame: Any = page.scene.get_handle_by_name(page.frames.node_path("cube"))
    assert np.allclose(frame.position, (0.0, 0.0, 3.0))
    picture.end()


def test_the_page_of_a_simulation_knows_that_it_is_one(ros) -> None:
    del ros  # this process is in it
    for words, shown in ((["--ros-args", "-p", "use_sim_time:=true"], True), ([], False)):
        with init(args=[]):
            viewer = Viewer(
                open_server(port=0), layout=PageLayout.with_panels(["log"]), cli_args=words
            )
            with viewer:
                names = [display.name for display in viewer.scene_view.displays]
                assert ("World" in names) == shown
