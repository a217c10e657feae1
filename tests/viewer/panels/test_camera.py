"""The Camera tab: choose one, see it, and nothing is listened to that nobody switched on."""

import pytest

from teleopctl.interfaces import get_message
from teleopctl.viewer.displays.sensors.images import CameraDisplay
from teleopctl.viewer.panels.camera import CameraPanel
from teleopctl.viewer.scene_view import SceneView

IMAGE = get_message("sensor_msgs/msg/Image")
COMPRESSED = get_message("sensor_msgs/msg/CompressedImage")
TOPICS = {
    "/cam/image_raw": [IMAGE.TYPE_NAME],
    "/cam/image_raw/compressed": [COMPRESSED.TYPE_NAME],
    "/chatter": ["std_msgs/msg/String"],
}


def picture(value=90, encoding="mono8"):
    return IMAGE(width=400, height=300, encoding=encoding, step=400, data=bytes([value]) * 120_000)


def cameras(stage):
    """Those that are in the picture."""
    return [display for display in stage.scene_view.displays if isinstance(display, CameraDisplay)]


@pytest.fixture
def panel(stage):
    stage.scene_view = SceneView(stage.server, stage)
    stage.scene_view.begin()
    stage.node.topics.update(TOPICS)
    panel = CameraPanel(stage)
    with stage.gui.add_tab_group().add_tab(panel.title):
        panel.build()
    panel.began()
    return panel


def test_raw_and_compressed_topics_are_offered_and_the_first_is_ready(panel, stage):
    assert panel._choice.options == ("/cam/image_raw", "/cam/image_raw/compressed")
    assert panel._choice.value == "/cam/image_raw"
    assert not any(stage.listens_to(topic) for topic in TOPICS)


def test_the_switch_brings_the_picture_and_takes_it_away(panel, stage):
    stage.choose(panel._switch, True)
    assert stage.listens_to("/cam/image_raw")
    stage.publish("/cam/image_raw", picture())
    panel.tick()
    assert panel._image.visible
    assert panel._image._data.startswith(b"\xff\xd8")
    assert "400 x 300 · mono8" in panel._note.content
    stage.choose(panel._switch, False)
    assert not stage.listens_to("/cam/image_raw")
    assert not panel._image.visible


def test_whoever_chooses_a_camera_sees_it(panel, stage):
    stage.choose(panel._choice, "/cam/image_raw/compressed")
    assert panel._switch.value
    assert stage.listens_to("/cam/image_raw/compressed")
    assert not stage.listens_to("/cam/image_raw")


def test_nobody_looks_and_nothing_is_listened_to_until_somebody_does(panel, stage):
    stage.choose(panel._switch, True)
    panel.ended()
    assert not stage.listens_to("/cam/image_raw")
    panel.began()
    assert stage.listens_to("/cam/image_raw")


def test_a_camera_that_goes_away_stays_chosen_until_it_is_back(panel, stage):
    stage.choose(panel._switch, True)
    stage.node.topics.clear()
    panel.graph_changed()
    assert panel._choice.value == "/cam/image_raw"
    stage.choose(panel._switch, False)
    panel.graph_changed()
    assert panel._choice.disabled


def test_a_topic_of_both_types_of_image_is_taken_as_raw(panel, stage):
    stage.node.topics["/cam/image_raw"] = [COMPRESSED.TYPE_NAME, IMAGE.TYPE_NAME]
    panel.graph_changed()
    assert panel._types["/cam/image_raw"] == IMAGE.TYPE_NAME


def test_what_cannot_be_shown_is_told_without_its_markup(panel, stage):
    stage.choose(panel._switch, True)
    stage.publish("/cam/image_raw", picture(encoding="<b>x</b>"))
    panel.tick()
    assert "<b>" not in panel._note.content
    assert "Not shown" in panel._note.content


def test_the_frustum_is_switched_on_in_the_scene_and_follows_the_choice(panel, stage):
    stage.choose(panel._place, True)
    (display,) = cameras(stage)
    assert (display.topic, display.is_drawn) == ("/cam/image_raw", True)
    stage.choose(panel._choice, "/cam/image_raw/compressed")
    assert display.topic == "/cam/image_raw/compressed"
    stage.choose(panel._place, False)
    assert not display.is_drawn
    stage.scene_view.remove(display)
    panel.tick()
    stage.choose(panel._place, True)
    assert len(cameras(stage)) == 1
