"""Messages of cameras become pictures that browsers show, in each encoding, whatever they hold."""

import io
import struct

import numpy as np
import pytest
from hypothesis import example, given, strategies
from PIL import Image as Pil

from teleopctl.interfaces import get_message
from teleopctl.pictures import GreyScaling, PictureError, picture_of
from teleopctl.viewer.displays.sensors.images import (
    base_topic,
    camera_info_topic,
    image_type_by_name,
)

IMAGE = get_message("sensor_msgs/msg/Image")
COMPRESSED = get_message("sensor_msgs/msg/CompressedImage")
WIDTH, HEIGHT = 360, 240


def smooth():
    """Colours that change slowly, so that neighbours may stand for each other."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    return np.stack(
        [40 + 150 * x / WIDTH, 200 - 150 * y / HEIGHT, 60 + 120 * (x + y) / (WIDTH + HEIGHT)], -1
    )


def image(encoding, pixels, *, pad=0, big=False, **fields):
    """A message whose rows have room behind them."""
    pixels = np.ascontiguousarray(pixels)
    if big:
        pixels = pixels.astype(pixels.dtype.newbyteorder(">"))
    rows = pixels.reshape(len(pixels), -1).view(np.uint8)
    rows = np.pad(rows, ((0, 0), (0, pad)), constant_values=77)
    given = {
        "height": HEIGHT,
        "width": WIDTH,
        "encoding": encoding,
        "step": rows.shape[1],
        "is_bigendian": int(big),
        "data": rows.tobytes(),
    }
    return IMAGE(**{**given, **fields})


def shown(message, scaling=None, width=640):
    picture = picture_of(message, width, scaling or GreyScaling())
    opened = Pil.open(io.BytesIO(picture.data))
    assert opened.format == picture.format.upper()
    return np.asarray(opened.convert("RGB")).astype(float)


def close(found, wanted):
    assert found.shape == wanted.shape
    return np.abs(found - wanted)[2:-2, 2:-2].mean() < 3.0


RGB = smooth()
BYTES = RGB.astype(np.uint8)
WORDS = (RGB * 257).astype(np.uint16)
OPAQUE = np.full((HEIGHT, WIDTH, 1), 255, np.uint8)


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(
    ("encoding", "pixels"),
    [
        ("rgb8", BYTES),
        ("bgr8", BYTES[..., ::-1]),
        ("8UC3", BYTES[..., ::-1]),
        ("rgba8", np.concatenate([BYTES, OPAQUE], -1)),
        ("bgra8", np.concatenate([BYTES[..., ::-1], OPAQUE * 0], -1)),
        ("rgb16", WORDS),
        ("bgr16", WORDS[..., ::-1]),
        ("rgba16", np.concatenate([WORDS, OPAQUE.astype(np.uint16)], -1)),
    ],
)
def test_colours_are_those_of_the_message(encoding, pixels, big):
    assert close(shown(image(encoding, pixels, pad=8, big=big)), RGB)


@pytest.mark.parametrize("depth", ["8", "16"])
@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
@pytest.mark.parametrize("width", [640, 120])
def test_the_colours_of_a_mosaic_are_put_together(pattern, depth, width):
    mosaic = np.empty((HEIGHT, WIDTH), np.uint8 if depth == "8" else np.uint16)
    for place, color in enumerate(pattern):
        y, x = place // 2, place % 2
        mosaic[y::2, x::2] = (BYTES if depth == "8" else WORDS)[y::2, x::2, "rgb".index(color)]
    found = shown(image(f"bayer_{pattern}{depth}", mosaic), width=width)
    wanted = np.asarray(Pil.fromarray(BYTES).resize(found.shape[1::-1]), float)
    assert close(found, wanted)


def yuv():
    """BT.601 in the range of video, as OpenCV's conversions have it."""
    r, g, b = (RGB[..., index] for index in range(3))
    y = 16 + 0.257 * r + 0.504 * g + 0.098 * b
    u = 128 - 0.148 * r - 0.291 * g + 0.439 * b
    v = 128 + 0.439 * r - 0.368 * g - 0.071 * b
    return tuple(plane.round().astype(np.uint8) for plane in (y, u, v))


@pytest.mark.parametrize("width", [640, 120])
@pytest.mark.parametrize("encoding", ["yuv422", "uyvy", "yuv422_yuy2", "yuyv", "nv21", "nv12"])
def test_video_has_its_colours(encoding, width):
    y, u, v = yuv()
    if encoding.startswith("nv"):
        halves = (v, u) if encoding == "nv21" else (u, v)
        chroma = np.stack([half[::2, ::2] for half in halves], -1).reshape(HEIGHT // 2, WIDTH)
        message = image(encoding, np.concatenate([y, chroma]), pad=4)
    else:
        planes = [u[:, ::2], y[:, ::2], v[:, ::2], y[:, 1::2]]
        if encoding in ("yuv422_yuy2", "yuyv"):
            planes = [y[:, ::2], u[:, ::2], y[:, 1::2], v[:, ::2]]
        message = image(encoding, np.stack(planes, -1))
    found = shown(message, width=width)
    wanted = np.asarray(Pil.fromarray(BYTES).resize(found.shape[1::-1]), float)
    assert close(found, wanted)


DEPTHS = (1000.0 + 2000.0 * np.mgrid[0:HEIGHT, 0:WIDTH][1] / WIDTH).astype(np.float32)


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(
    ("encoding", "dtype", "unknown"),
    [("16UC1", np.uint16, 0), ("mono16", np.uint16, 0), ("32FC1", np.float32, np.nan),
     ("64FC1", np.float64, np.inf), ("32SC1", np.int32, 0)],
)  # fmt: skip
def test_depths_are_from_black_to_white_and_what_is_unknown_is_black(encoding, dtype, unknown, big):
    depths = DEPTHS.astype(dtype)
    depths[100:140, 200:300] = unknown
    found = shown(image(encoding, depths, big=big))[..., 0]
    assert found[10, 2] < 5
    assert found[10, -3] > 250
    assert abs(found[10, WIDTH // 2] - 127) < 5
    assert found[110:130, 220:280].max() < 8


def test_a_range_that_is_given_stays():
    found = shown(image("32FC1", DEPTHS), GreyScaling(automatic=False, low=0.0, high=4000.0))
    assert abs(found[10, 2, 0] - 255 * 1000 / 4000) < 4
    assert abs(found[10, -3, 0] - 255 * 3000 / 4000) < 4


def test_one_outlier_does_not_change_the_range_of_the_pictures_around_it():
    scaling = GreyScaling(window=5)
    values = np.array([1.0, 2.0, 3.0])
    for _ in range(4):
        assert list(scaling.to_grey(values)) == [0, 127, 255]
    assert list(scaling.to_grey(np.array([1.0, 2.0, 3000.0]))) == [0, 127, 255]


def test_a_picture_is_no_wider_than_asked_for_and_no_narrower_than_can_be_seen():
    assert shown(image("rgb8", BYTES), width=100).shape[1] == 100
    small = image("rgb8", BYTES[:6, :8], width=8, height=6)
    assert shown(small).shape[1] == 320


def test_of_a_picture_that_is_much_too_wide_each_nth_pixel_is_taken():
    message = image("bgr8", BYTES[..., ::-1], pad=5)
    small = shown(message, width=WIDTH // 8)
    assert small.shape == (HEIGHT // 8, WIDTH // 8, 3)
    whole = shown(message)[::8, ::8]
    assert np.abs(small.astype(int) - whole).mean() < 12


def test_rows_that_are_missing_are_told_and_the_others_shown():
    message = image("rgb8", BYTES)
    message.data = message.data[: message.step * 100]
    picture = picture_of(message, 640, GreyScaling())
    assert picture.left_out == "Only 100 of 240 rows have arrived."
    assert Pil.open(io.BytesIO(picture.data)).size == (WIDTH, 100)


def encoded(pixels, kind):
    buffer = io.BytesIO()
    Pil.fromarray(pixels).save(buffer, kind)
    return buffer.getvalue()


@pytest.mark.parametrize("kind", ["jpeg", "png"])
def test_what_browsers_know_is_passed_through(kind):
    data = encoded(BYTES, kind)
    picture = picture_of(
        COMPRESSED(format=f"bgr8; {kind} compressed", data=data), 64, GreyScaling()
    )
    assert (picture.data, picture.format) == (data, kind)
    assert (picture.width, picture.height) == (WIDTH, HEIGHT)


def test_what_browsers_would_show_as_black_is_made_grey():
    data = encoded(DEPTHS.astype(np.uint16), "png")
    found = shown(COMPRESSED(format="16UC1; png compressed", data=data))
    assert found[10, -3, 0] > 250


def test_a_compressed_depth_is_decoded():
    raw = encoded(DEPTHS.astype(np.uint16), "png")
    header = struct.pack("<iff", 0, 0.0, 0.0)
    found = shown(COMPRESSED(format="16UC1; compressedDepth png", data=header + raw))
    assert abs(found[10, WIDTH // 2, 0] - 127) < 5
    scale, offset = 10_000.0, 0.5
    metres = DEPTHS / 1000
    inverse = (scale / metres + offset).astype(np.uint16)
    inverse[100:140, 200:300] = 0
    header = struct.pack("<iff", 0, scale, offset)
    message = COMPRESSED(format="32FC1; compressedDepth", data=header + encoded(inverse, "png"))
    found = shown(message)
    assert abs(found[10, WIDTH // 2, 0] - 127) < 5
    assert found[110:130, 220:280].max() < 8


numbers = strategies.sampled_from([0, 1, 2, 3, 7, 64, 65_535, 2**32 - 1])
KNOWN = """
rgb8 bgr8 rgba8 mono8 mono16 rgb16 8UC1 16UC1 16SC2 32FC1 32FC3 64FC4 8FC1 16UC0 16UC999
bayer_rggb8 bayer_grbg16 yuv422 yuv422_yuy2 nv21 nv12 nv24 h264
"""
encodings = strategies.sampled_from(KNOWN.split()) | strategies.text(max_size=8)


@given(numbers, numbers, numbers, encodings, strategies.binary(max_size=600), strategies.booleans())
@example(64, 2**32 - 1, 0, "nv21", bytes(600), False)
def test_an_absurd_image_is_refused_or_shown_and_nothing_else(
    width, height, step, encoding, data, big
):
    message = IMAGE(
        width=width, height=height, step=step, encoding=encoding, data=data, is_bigendian=big
    )
    try:
        picture = picture_of(message, 640, GreyScaling())
    except PictureError as error:
        assert error.message
    else:
        Pil.open(io.BytesIO(picture.data)).load()


@given(
    strategies.sampled_from(["jpeg", "16UC1; compressedDepth", "32FC1; compressedDepth rvl", ""]),
    strategies.binary(max_size=40),
    strategies.integers(0, 400),
    strategies.sampled_from(["none", "jpeg", "png", "webp", "gif"]),
)
def test_absurd_compressed_bytes_are_refused_or_shown_and_nothing_else(name, head, cut, kind):
    tail = b"" if kind == "none" else encoded(BYTES[:9, :9], kind)[: cut + 20]
    for data in (head + tail, tail, bytes(12) + tail):
        try:
            assert picture_of(COMPRESSED(format=name, data=data), 640, GreyScaling()).data
        except PictureError as error:
            assert error.message


@given(
    strategies.lists(
        strategies.floats(width=32) | strategies.just(3e38) | strategies.just(-3e38), max_size=8
    )
)
def test_numbers_of_any_kind_have_a_grey_level(values):
    assert GreyScaling().to_grey(np.array(values, np.float32)).shape == (len(values),)


def test_a_cameras_other_topics_are_named_as_image_transport_does():
    assert base_topic("/cam/image_raw/compressed") == "/cam/image_raw"
    assert camera_info_topic("/cam/image_raw/compressed") == "/cam/camera_info"
    assert camera_info_topic("/image") == "/camera_info"
    assert image_type_by_name("/cam/image_raw") == "sensor_msgs/msg/Image"
    assert image_type_by_name("/cam/depth/compressedDepth") == "sensor_msgs/msg/CompressedImage"
    assert image_type_by_name("/compressed") == "sensor_msgs/msg/Image"
