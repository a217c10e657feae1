"""Images are published, flipped and shown, as by ROS 2's image_tools."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from teleopctl.errors import MissingExtraError, UsageError
from teleopctl.interfaces import get_message
from teleopctl.node import SingleThreadedExecutor, init, try_shutdown
from teleopctl.nodes.image_tools import Burgers, Cam2Image, ImageWindow, ShowImage
from teleopctl.testing import RosGraph


@pytest.fixture(autouse=True)
def rclpy(ros: RosGraph) -> Iterator[None]:
    del ros
    yield
    try_shutdown()


def start(**parameters: Any) -> None:
    words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    init(args=["--ros-args", *words] if words else [])


def test_what_one_publishes_the_other_shows_also_flipped():
    start(burger_mode="true", width=64, height=48, frequency=100.0)
    camera, shower = Cam2Image(), ShowImage()
    sent: list[Any] = []
    got: list[Any] = []
    camera.show, shower.show = sent.append, got.append
    executor = SingleThreadedExecutor()
    for node in (camera, shower):
        executor.add_node(node)
    while not got:
        executor.spin_once(0.05)
    assert shower.title == "/image"
    assert any(np.array_equal(got[0], picture) for picture in sent)
    assert got[0].shape == (48, 64, 3)
    camera._read = lambda: (
        np.arange(48 * 64 * 3, dtype=np.uint32).astype(np.uint8).reshape(48, 64, 3)
    )
    camera._on_flip(get_message("std_msgs/msg/Bool")(data=True))
    camera._publish()
    plain = camera._read()
    assert plain is not None
    assert np.array_equal(sent[-1], plain[:, ::-1])
    executor.shutdown()
    for node in (camera, shower):
        node.destroy_node()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"reliability": "maybe"}, "Invalid QoS reliability setting 'maybe'"),
        ({"history": "some"}, "Invalid QoS history setting 'some'"),
        ({"frequency": 0.0}, "frequency must be greater than zero, got 0"),
        ({"width": 0}, "width and height must be positive, got 0 x 240"),
    ],
)
def test_a_wrong_parameter_is_named(parameters, message):
    start(**parameters)
    with pytest.raises(UsageError) as raised:
        Cam2Image()
    assert raised.value.message == message


def test_without_opencv_the_library_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "cv2", None)
    start()
    with pytest.raises(MissingExtraError, match="OpenCV") as raised:
        Cam2Image()
    assert "burger_mode:=true" in (raised.value.hint or "")


def test_burgers_stay_in_the_picture_and_move():
    burgers = Burgers(80, 60)
    pictures = [burgers.draw() for _ in range(300)]
    assert all(picture.shape == (60, 80, 3) for picture in pictures)
    assert not np.array_equal(pictures[0], pictures[1])
    assert all(0.0 < place < 1.0 for burger in burgers._burgers for place in burger[:2])


def test_the_page_has_the_newest_picture_upright():
    window = ImageWindow("/image")
    try:
        picture = np.zeros((4, 6, 3), np.uint8)
        picture[0] = 255
        window.show(picture)
        # viser's pictures have their lowest row first.
        assert window._image.image[-1].all()
    finally:
        window.close()
