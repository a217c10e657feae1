"""``teleopctl camera save``: one picture of a camera as a file."""

from typing import Any

import numpy as np
import pytest
from PIL import Image

from teleopctl.interfaces import get_message
from teleopctl.testing import RosGraph


class Camera:
    """Publishes one and the same image, of a gradient, often."""

    def __init__(self, ros: RosGraph, encoding: str, step_padding: int = 0) -> None:
        channels = {"rgb8": 3, "bgr8": 3, "mono8": 1}.get(encoding, 1)
        rows = np.arange(4 * 6 * channels, dtype=np.uint8).reshape(4, 6, channels)
        padding = np.zeros((4, step_padding), np.uint8)
        self.pixels = rows[..., ::-1] if encoding == "bgr8" else rows
        data = np.hstack([rows.reshape(4, -1), padding])
        kind: type[Any] = get_message("sensor_msgs/msg/Image")
        message = kind(
            height=4, width=6, encoding=encoding, step=data.shape[1], data=data.tobytes()
        )
        publisher = ros.node.create_publisher(kind, "/eye/image_raw", 1)
        ros.node.create_timer(0.05, lambda: publisher.publish(message))


@pytest.mark.parametrize(("encoding", "padding"), [("rgb8", 0), ("bgr8", 2), ("mono8", 3)])
def test_a_picture_is_saved_with_its_pixels(ros, tmp_path, encoding, padding):
    camera = Camera(ros, encoding, padding)
    file = tmp_path / "picture.png"
    done = ros.run(["camera", "save", str(file), "--topic", "eye/image_raw"])
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"{file}: 6 x 4, ")
    with Image.open(file) as picture:
        assert np.array_equal(np.asarray(picture).reshape(camera.pixels.shape), camera.pixels)


@pytest.mark.parametrize("big", [False, True])
def test_depths_are_saved_as_millimetres(ros, tmp_path, big):
    """What is nothing, infinite or beyond 65 m is 0, as drivers of depth cameras have it."""
    metres = np.array([[0.5, 1.2344, np.nan], [np.inf, -np.inf, 70.0]], ">f4" if big else "<f4")
    kind: type[Any] = get_message("sensor_msgs/msg/Image")
    message = kind(
        height=2, width=3, encoding="32FC1", step=12, is_bigendian=int(big), data=metres.tobytes()
    )
    publisher = ros.node.create_publisher(kind, "/depth", 1)
    ros.node.create_timer(0.05, lambda: publisher.publish(message))
    file = tmp_path / "depths.png"

    done = ros.run(["camera", "save", str(file), "--topic", "/depth"])

    assert (done.returncode, done.stderr) == (0, "")
    with Image.open(file) as picture:
        assert np.asarray(picture).tolist() == [[500, 1234, 0], [0, 0, 0]]


def test_what_cannot_be_saved_is_refused_with_its_reason(ros, tmp_path):
    Camera(ros, "yuv422")
    for words, status, told in (
        (["picture.tiff"], 2, "End its name with .png"),
        (["picture.png"], 1, "/image_raw"),
        (["picture.png", "--topic", "/rosout"], 2, "rcl_interfaces/msg/Log"),
        (["picture.png", "--topic", "/eye/image_raw"], 2, "'yuv422'"),
        (["picture.png", "--topic", "/eye/image_ra"], 1, "/eye/image_raw"),
    ):
        done = ros.run(["camera", "save", *words])
        assert done.returncode == status, done.stderr
        assert told in done.stderr
    assert not list(ros.folder.glob("picture.*"))


def test_who_waits_for_a_picture_is_told_so(ros):
    publisher = ros.node.create_publisher(get_message("sensor_msgs/msg/Image"), "/image_raw", 1)
    saving = ros.spawn("camera save picture.png")
    saving.wait_for_line("Waiting for a picture on '/image_raw' for 2 s", stream="stderr")
    assert publisher.get_subscription_count() == 1
    publisher.publish(publisher.msg_type(height=1, width=1, encoding="mono8", step=1, data=b"\x07"))
    assert saving.wait() == 0
    done = ros.run("camera save picture.png --timeout 0.2")
    assert "No picture on '/image_raw' within 0.2 s" in done.stderr
