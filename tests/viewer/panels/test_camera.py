"""The cameras: each that is published is shown while the panel is seen, and no other."""

import pytest

from teleopctl.interfaces import get_message
from teleopctl.viewer.displays.sensors.images import CameraDisplay
from teleopctl.viewer.panels.camera import MOST_SHOWN, CameraPanel
from teleopctl.viewer.scene_view import SceneView

IMAGE = get_message("sensor_msgs/msg/Image")
COMPRESSED = get_message("sensor_msgs/msg/CompressedImage")
TOPICS = {
    "/cam/image_raw": [IMAGE.TYPE_NAME],
    "/cam/image_raw/compressed": [COMPRESSED.TYPE_NAME],
    "/depth/image": [COMPRESSED.TYPE_NAME, IMAGE.TYPE_NAME],
    "/chatter": ["std_msgs/msg/String"],
}


def picture(value=90, encoding="mono8"):
    return IMAGE(width=800, height=300, encoding=encoding, step=800, data=bytes([value]) * 240_000)


def heard(stage):
    return [topic for topic in TOPICS if stage.listens_to(topic)]


@pytest.fixture
def panel(stage):
    stage.scene_view = SceneView(stage.server, stage)
    stage.scene_view.begin()
    stage.node.topics.update(TOPICS)
    panel = CameraPanel(stage)
    panel.build()
    panel.began()
    return panel


def test_of_each_camera_one_topic_is_shown_without_a_click_as_long_as_it_is_seen(panel, stage):
    assert heard(stage) == ["/cam/image_raw", "/depth/image"]
    view = panel._views["/cam/image_raw"]
    stage.publish("/cam/image_raw", picture())
    panel.tick()
    assert view._image.visible
    assert view._image._data.startswith(b"\xff\xd8")
    assert view._image.label.startswith("/cam/image_raw · 800 x 300")
    panel.ended()
    assert not heard(stage)
    assert not view._image.visible
    panel.began()
    assert heard(stage) == ["/cam/image_raw", "/depth/image"]
    # Of both types the raw one.
    assert panel._types["/depth/image"] == IMAGE.TYPE_NAME


def test_what_is_chosen_by_hand_is_kept(panel, stage):
    stage.choose(panel._boxes["/cam/image_raw"], False)
    stage.choose(panel._boxes["/cam/image_raw/compressed"], True)
    assert heard(stage) == ["/cam/image_raw/compressed", "/depth/image"]
    again = CameraPanel(stage)
    again.build()
    again.restore(panel.state())
    panel.ended()
    again.began()
    assert heard(stage) == ["/cam/image_raw/compressed", "/depth/image"]
    again.ended()
    states: list[object] = [[], {"/a": 1, 2: True}, "text", None]
    for wrong in states:
        again.restore(wrong)


def test_a_camera_that_goes_away_goes_and_a_chosen_one_waits(panel, stage):
    stage.choose(panel._boxes["/cam/image_raw/compressed"], True)
    stage.node.topics.clear()
    panel.graph_changed()
    assert heard(stage) == ["/cam/image_raw/compressed"]
    stage.choose(panel._boxes["/cam/image_raw/compressed"], False)
    panel.graph_changed()
    assert not heard(stage)
    assert panel._note.visible
    assert not CameraPanel.is_needed(stage.node)


def test_of_many_cameras_the_first_are_shown(stage):
    stage.node.topics.update({f"/c{n:03}/image": [IMAGE.TYPE_NAME] for n in range(200)})
    panel = CameraPanel(stage)
    panel.build()
    panel.began()
    assert sum(stage.listens_to(topic) for topic in stage.node.topics) == MOST_SHOWN


def test_labels_are_shown_in_colours_where_there_are_any_and_as_numbers_on_request(stage):
    stage.node.topics.clear()
    for name in ("/lone/labels_map", "/names/colored_map", "/names/labels_map"):
        stage.node.topics[name] = [IMAGE.TYPE_NAME]
    panel = CameraPanel(stage)
    panel.build()
    panel.began()
    assert panel.shown() == ["/lone/labels_map", "/names/colored_map"]
    stage.choose(panel._boxes["/names/labels_map"], True)
    assert panel.shown() == sorted(stage.node.topics)
    panel.ended()


def test_what_cannot_be_shown_is_told_without_its_markup(panel, stage):
    stage.publish("/cam/image_raw", picture(encoding="<b>x</b>"))
    panel.tick()
    note = panel._views["/cam/image_raw"]._note
    assert note.visible
    assert "not shown" in note.content
    assert "<b>" not in note.content


def test_pictures_are_small_for_the_page_and_whole_on_demand(panel, stage):
    def shown():
        stage.publish("/cam/image_raw", picture())
        panel._views["/cam/image_raw"]._feed._due = 0.0
        panel.tick()
        return len(panel._views["/cam/image_raw"]._image._data)

    small = shown()
    stage.choose(panel._full, True)
    assert shown() > small


def test_pictures_stand_in_the_scene_while_they_are_wanted_there(panel, stage):
    def cameras():
        return [d.topic for d in stage.scene_view.displays if isinstance(d, CameraDisplay)]

    stage.choose(panel._place, True)
    assert cameras() == ["/cam/image_raw", "/depth/image"]
    stage.choose(panel._boxes["/depth/image"], False)
    assert cameras() == ["/cam/image_raw"]
    stage.scene_view.remove(stage.scene_view.displays[-1])
    stage.choose(panel._place, False)
    assert cameras() == []
