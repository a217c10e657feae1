"""Image and Camera: the newest picture, in a window and in the scene."""

import math

import numpy as np
import pytest

from teleopctl.interfaces import get_message
from teleopctl.viewer.displays.sensors.images import CameraDisplay, Image

IMAGE = get_message("sensor_msgs/msg/Image")
COMPRESSED = get_message("sensor_msgs/msg/CompressedImage")
INFO = get_message("sensor_msgs/msg/CameraInfo")


def picture(value=90, frame="optical", **fields):
    message = IMAGE(
        width=400, height=300, encoding="mono8", step=400, data=bytes([value]) * 120_000, **fields
    )
    message.header.frame_id = frame
    return message


def camera_info(fx=300.0, fy=300.0):
    info = INFO(width=400, height=300)
    info.k[0], info.k[4] = fx, fy
    info.header.frame_id = "optical"
    return info


def made(stage, kind, topic="/cam/image_raw", **given):
    display = kind(stage, "cam", "/display1", {"Topic": {"Value": topic}, **given})
    stage.displays.append(display)
    display.begin()
    return display


def shown(display, message):
    """Hand over a message, as the graph does, and give the picture its time."""
    display.stage.publish(display.topic, message)
    display._feed._due = 0.0
    display.tick()


def windows(stage):
    return stage.gui._panel_handle_from_uuid


def test_a_picture_opens_a_window_which_closes_with_the_display(stage):
    display = made(stage, Image)
    assert not windows(stage)
    shown(display, picture())
    assert len(windows(stage)) == 1
    first = display._image._data
    assert first.startswith(b"\xff\xd8")
    assert display.status == ("ok", "400 x 300, mono8")
    shown(display, picture(value=200))
    assert display._image._data != first
    display.end()
    assert not windows(stage)
    assert not stage.listens_to("/cam/image_raw")


def test_a_compressed_topic_is_known_by_its_name_and_by_who_publishes(stage):
    assert made(stage, Image, "/a/compressed").subscription_type() == COMPRESSED.TYPE_NAME
    assert made(stage, Image, "/a").subscription_type() == IMAGE.TYPE_NAME
    stage.node.topics["/a"] = [COMPRESSED.TYPE_NAME]
    assert made(stage, Image, "/a").subscription_type() == COMPRESSED.TYPE_NAME


def test_pictures_that_come_faster_than_they_are_watched_are_not_decoded(stage):
    display = made(stage, Image)
    decoded = []
    display.show = lambda message, _picture: decoded.append(message)
    for value in range(30):  # a second's worth, between two ticks
        stage.publish(display.topic, picture(value=value))
    display.tick()
    display.tick()
    assert [message.data[0] for message in decoded] == [29]


def test_a_picture_that_makes_no_sense_says_why_and_the_next_one_is_shown(stage):
    display = made(stage, Image)
    message = picture()
    message.encoding = "hologram"
    shown(display, message)
    assert display.status == ("error", "The encoding 'hologram' is not known")
    shown(display, picture())
    assert display.status[0] == "ok"


def test_another_range_of_grey_shows_the_last_picture_anew(stage):
    display = made(stage, Image)
    depths = np.linspace(1, 2, 120_000, dtype=np.float32)
    message = IMAGE(width=400, height=300, encoding="32FC1", step=1600, data=depths.tobytes())
    shown(display, message)
    before = display._image._data
    display.set("Normalize Range", False)
    display._feed._due = 0.0
    display.tick()
    assert display._image._data != before


def test_the_frustum_stands_on_the_cameras_frame_and_is_as_wide_as_the_lens(stage):
    display = made(stage, CameraDisplay)
    stage.publish("/cam/camera_info", camera_info(fx=200.0, fy=300.0))
    shown(display, picture())
    frustum = display._frustum
    assert frustum.name == "/frames/optical/display1"
    assert frustum.fov == pytest.approx(2 * math.atan(150 / 300))
    assert frustum.aspect == pytest.approx((400 / 200) / (300 / 300))
    assert frustum._image_data.startswith(b"\xff\xd8")
    assert display.status[0] == "ok"
    stage.publish("/cam/camera_info", camera_info(fx=300.0, fy=300.0))
    shown(display, picture())
    assert frustum.aspect == pytest.approx(400 / 300)
    display.end()
    assert not stage.listens_to("/cam/camera_info")
    assert "/frames/optical/display1" not in stage.scene._handle_from_node_name


def test_a_camera_that_does_not_say_how_it_sees_is_shown_and_that_is_told(stage):
    display = made(stage, CameraDisplay, "/cam/image_raw/compressed")
    stage.publish("/cam/camera_info", camera_info(fx=0.0, fy=float("nan")))
    display._show_result(picture(), _some_picture())
    assert display._frustum is not None
    assert display.status[0] == "warn"
    assert "/cam/camera_info" in display.status[1]


def _some_picture():
    from teleopctl.pictures import Picture

    return Picture(b"\xff\xd8", "jpeg", 400, 300, "jpeg")
