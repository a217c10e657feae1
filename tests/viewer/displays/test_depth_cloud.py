"""DepthCloud: the pixels of a depth camera stand where the camera saw them, in their colours."""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pil

from teleopctl.interfaces import get_message
from teleopctl.pictures import PictureError, depths_of
from teleopctl.viewer import ERROR, OK, WARN
from teleopctl.viewer.displays.sensors.depth_cloud import DepthCloud
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import Draw

IMAGE = get_message("sensor_msgs/msg/Image")
COMPRESSED = get_message("sensor_msgs/msg/CompressedImage")
INFO = get_message("sensor_msgs/msg/CameraInfo")
WIDTH, HEIGHT, FOCUS = 8, 6, 10.0
DEPTH, COLOR = "/cam/depth/image", "/cam/color/image"
# Millimetres: 1 m at the upper left, more to the right and below, and nothing at one place.
DEPTHS = (1000 + 100 * np.arange(WIDTH) + 10 * np.arange(HEIGHT)[:, None]).astype(np.uint16)
DEPTHS[2, 3] = 0


def image(encoding: str, pixels: Any, stamp: float = 1.0, frame: str = "map") -> Any:
    pixels = np.ascontiguousarray(pixels)
    made = IMAGE(encoding=encoding, height=len(pixels), width=pixels.shape[1])
    made.step, made.data = pixels[0].nbytes, pixels.tobytes()
    made.header.frame_id = frame
    made.header.stamp.sec, made.header.stamp.nanosec = int(stamp), int(stamp % 1 * 1e9)
    return made


def info(**fields: Any) -> Any:
    made = INFO(width=WIDTH, height=HEIGHT)
    made.k[0] = made.k[4] = FOCUS
    made.k[2], made.k[5] = WIDTH / 2, HEIGHT / 2
    for name, value in fields.items():
        setattr(made, name, value)
    return made


def where(u: int, v: int) -> list[float]:
    """Where a pixel is, by the pinhole's rule."""
    z = DEPTHS[v, u] / 1000
    return [(u - WIDTH / 2) / FOCUS * z, (v - HEIGHT / 2) / FOCUS * z, z]


def begin(draw: Draw, page: FakePage, **given: Any) -> Any:
    display = draw("DepthCloud", **{"Topic": {}, "Depth Map Topic": DEPTH, **given})
    page.publish("/cam/depth/camera_info", info())
    return display


def show(page: FakePage, display: Any, *sent: Any) -> Any:
    """Hand over depths, and return viser's node of the points."""
    for message in sent:
        page.publish(display.topic, message)
    display._due = 0.0
    display.tick()
    display.tick()
    return display._drawn_ones[-1].node._handle if display._drawn_ones else None


def places(node: Any) -> Any:
    return node.points + node.position


def test_each_pixel_with_a_depth_is_a_point_where_the_camera_saw_it(page: FakePage, draw: Draw):
    display = begin(draw, page)
    node = show(page, display, image("16UC1", DEPTHS))
    pixels = [(u, v) for v in range(HEIGHT) for u in range(WIDTH) if (u, v) != (3, 2)]
    np.testing.assert_allclose(places(node), [where(*one) for one in pixels], atol=1e-3)
    assert display.status == (OK, "47 of 48 points")
    # a pixel of 0.1 rad at the middle distance
    assert node.point_size == pytest.approx(np.median(DEPTHS) / 1000 / FOCUS, rel=0.06)
    node = show(
        page,
        display,
        image("32FC1", np.where(DEPTHS == 0, np.nan, DEPTHS / 1000).astype(np.float32)),
    )
    assert len(node.points) == 47
    display.set("Auto Size", value=False)
    assert show(page, display).point_size == pytest.approx(0.01)


def test_colours_are_those_of_the_image_that_was_taken_with_the_depths(page: FakePage, draw: Draw):
    display = begin(draw, page, **{"Color Image Topic": COLOR})
    colors = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for stamp, red in ((0.9, 1), (1.0, 200), (1.2, 2)):
        colors[..., 0] = red
        page.publish(COLOR, image("rgb8", colors, stamp))
    node = show(page, display, image("16UC1", DEPTHS))
    assert set(map(tuple, node.colors.tolist())) == {(200, 0, 0)}
    assert display.status[0] == OK
    for wrong, why in (
        (image("rgb8", colors[:-1], 3.0), "8 x 5 pixels are not the 8 x 6"),
        (image("rgb8", colors, 5.0, frame="other"), "in frame [other]"),
        (image("rgb9", colors, 7.0), "'rgb9' is not known"),
    ):
        page.publish(COLOR, wrong)
        show(page, display, image("16UC1", DEPTHS, wrong.header.stamp.sec))
        assert display.status[0] == WARN
        assert why in display.status[1]
    show(page, display, image("16UC1", DEPTHS, 9.0))
    assert display.status == (WARN, "The newest image of colours is 2.0 s from the depths")


def test_no_more_points_are_sent_than_the_budget_and_they_are_larger_then(
    page: FakePage, draw: Draw
):
    display = begin(draw, page, **{"Point Budget": 100})
    fine = np.full((120, 160), 2000, np.uint16)
    lens = info(width=160, height=120)
    page.publish("/cam/depth/camera_info", lens)
    node = show(page, display, image("16UC1", fine))
    assert 50 <= len(node.points) <= 100
    every = 2.0 / FOCUS * 15
    assert node.point_size == pytest.approx(every, rel=0.06)


def test_without_its_camera_info_the_status_says_what_is_missing(page: FakePage, draw: Draw):
    display = draw("DepthCloud", **{"Topic": {}, "Depth Map Topic": DEPTH})
    assert show(page, display, image("16UC1", DEPTHS)) is None
    assert display.status[0] == WARN
    assert "/cam/depth/camera_info" in display.status[1]
    page.publish("/cam/depth/camera_info", info())
    # what has waited for it is drawn
    assert show(page, display) is not None


@pytest.mark.parametrize(
    ("sent", "lens", "why"),
    [
        (image("16UC1", DEPTHS), info(width=99), "of 99 x 6 pixels, the image of 8 x 6"),
        (image("16UC1", DEPTHS), INFO(width=WIDTH, height=HEIGHT), "not calibrated"),
        (
            image("rgb8", np.zeros((HEIGHT, WIDTH, 3), np.uint8)),
            info(),
            "in rgb8 contain no depths",
        ),
    ],
)
def test_what_makes_no_points_is_told(page: FakePage, draw: Draw, sent: Any, lens: Any, why: str):
    display = begin(draw, page)
    page.publish("/cam/depth/camera_info", lens)
    assert show(page, display, sent) is None
    assert display.status[0] == ERROR
    assert why in display.status[1]


def test_binning_and_a_region_of_interest_count(page: FakePage, draw: Draw):
    display = begin(draw, page)
    lens = info(width=40, height=30, binning_x=2, binning_y=2)
    lens.k[0] = lens.k[4] = 2 * FOCUS
    lens.k[2], lens.k[5] = 10.0 + WIDTH, 12.0 + HEIGHT
    lens.roi.x_offset, lens.roi.y_offset = 10, 12
    lens.roi.width, lens.roi.height = 2 * WIDTH, 2 * HEIGHT
    page.publish("/cam/depth/camera_info", lens)
    node = show(page, display, image("16UC1", DEPTHS))
    np.testing.assert_allclose(places(node)[0], where(0, 0), atol=1e-3)


def test_a_file_names_topics_and_their_transports(page: FakePage):
    given = {
        "Depth Map Topic": DEPTH,
        "Depth Map Transport Hint": "compressedDepth",
        "Color Image Topic": COLOR,
        "Color Transport Hint": "compressed",
    }
    display = DepthCloud(page, "depth", "/display1", given)
    assert display.topic == f"{DEPTH}/compressedDepth"
    display.begin()
    assert page.listens_to(f"{DEPTH}/compressedDepth")
    assert page.listens_to(f"{COLOR}/compressed")
    assert page.listens_to("/cam/depth/camera_info")
    display.set_topic("/other/depth/image/compressedDepth")
    assert given["Depth Map Topic"] == "/other/depth/image"
    assert given["Depth Map Transport Hint"] == "compressedDepth"
    assert not page.listens_to("/cam/depth/camera_info")
    display.end()
    assert not any(page.subscribed.values())


def compressed(kind: str, pixels: Any, scale: float = 0.0, offset: float = 0.0) -> Any:
    stored = io.BytesIO()
    Pil.fromarray(pixels).save(stored, "PNG")
    header = struct.pack("<iff", 0, scale, offset)
    return COMPRESSED(format=f"{kind}; compressedDepth png", data=header + stored.getvalue())


def test_depths_are_metres_in_each_encoding():
    metres = DEPTHS / np.float32(1000)
    np.testing.assert_allclose(depths_of(image("16UC1", DEPTHS)), metres, rtol=1e-6)
    np.testing.assert_allclose(depths_of(image("32FC1", metres)), metres)
    np.testing.assert_allclose(depths_of(compressed("16UC1", DEPTHS)), metres, rtol=1e-6)
    # the inverse of the depth, as compressed_depth_image_transport keeps it
    inverse = np.where(DEPTHS > 0, 100 / np.maximum(metres, 1) + 2, 0).round().astype(np.uint16)
    found = depths_of(compressed("32FC1", inverse, 100.0, 2.0))
    np.testing.assert_allclose(found, metres, rtol=0.02)
    with pytest.raises(PictureError, match="contain no depths"):
        depths_of(COMPRESSED(format="jpeg"))
