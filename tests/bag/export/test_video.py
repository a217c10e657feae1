"""Topics of pictures as films, read back by another program's decoder."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from PIL import Image

from teleopctl.bag import BagMessage, BagWriter, ExportedVideo, VideoExport, open_bag
from teleopctl.bag.export.video import VideoFile, resample_frames
from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError, UsageError
from teleopctl.interfaces import get_message, serialize
from tests.bag.bags import START_NS, message, topic

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
RED, BLUE = (200, 30, 40), (20, 60, 220)
SIZE = (64, 48)


def raw(encoding: str = "rgb8", colour: tuple[int, ...] = RED, size: tuple[int, int] = SIZE) -> Any:
    width, height = size
    pixel = np.asarray(colour, np.uint8)
    data = np.tile(pixel, width * height).tobytes()
    return get_message(IMAGE)(
        encoding=encoding, width=width, height=height, step=width * len(pixel), data=data
    )


def jpeg(colour: tuple[int, int, int], form: str = "JPEG") -> Any:
    file = io.BytesIO()
    Image.new("RGB", SIZE, colour).save(file, form)
    return get_message(COMPRESSED)(format=form.lower(), data=file.getvalue())


def write(folder: Path, *images: Any, times_s: list[float] | None = None) -> Path:
    type_name = type(images[0]).TYPE_NAME if images else IMAGE
    with BagWriter(folder / "bag") as writer:
        writer.add_topic(topic("/image", type_name))
        writer.add_topic(topic("/text"))
        for number, image in enumerate(images):
            time_ns = START_NS + round((times_s[number] if times_s else number / 10) * 1e9)
            writer.write(BagMessage("/image", time_ns, time_ns, bytes(serialize(image))))
        writer.write(message("/text", 0))
    return folder / "bag"


def films(bag: Path, folder: Path, **options: Any) -> list[ExportedVideo]:
    with open_bag(bag) as opened:
        return list(VideoExport(opened, folder, **options).write())


def decoded(path: Path) -> tuple[list[float], list[list[int]]]:
    """Times of the frames, and the colour in the middle of each."""
    with av.open(str(path)) as file:
        frames = list(file.decode(file.streams.video[0]))
    pixels = [frame.to_ndarray(format="rgb24") for frame in frames]
    return [round(frame.time or 0.0, 6) for frame in frames], [
        image[image.shape[0] // 2, image.shape[1] // 2].tolist() for image in pixels
    ]


def assert_colour(found: list[int], expected: tuple[int, ...]) -> None:
    assert np.abs(np.subtract(found, expected)).max() <= 12, (found, expected)


def test_each_frame_is_shown_when_it_was_recorded(tmp_path):
    times_s = [0.0, 0.1, 0.15, 2.0]
    bag = write(tmp_path, raw(), raw(), raw(colour=BLUE), raw(colour=BLUE), times_s=times_s)
    (film,) = films(bag, tmp_path / "out")
    assert film == ExportedVideo(tmp_path / "out" / "image.mp4", "/image", 4, SIZE, 2.0, 0, "")
    times, colours = decoded(film.path)
    assert times == times_s
    for colour, expected in zip(colours, (RED, RED, BLUE, BLUE), strict=True):
        assert_colour(colour, expected)


def test_at_a_constant_rate_each_frame_is_the_latest_picture(tmp_path):
    bag = write(tmp_path, raw(), raw(colour=BLUE), raw(), times_s=[0.0, 0.25, 0.5])
    (film,) = films(bag, tmp_path / "out", rate=10.0)
    times, colours = decoded(film.path)
    assert times == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]
    for colour, expected in zip(colours, (RED, RED, RED, BLUE, BLUE, RED), strict=True):
        assert_colour(colour, expected)


@pytest.mark.parametrize(
    ("image", "shown"),
    [
        (raw("bgr8", (40, 30, 200)), RED),
        (raw("rgba8", (*RED, 0)), RED),
        (raw("bgra8", (40, 30, 200, 255)), RED),
        (raw("mono8", (90,)), (90, 90, 90)),
        (raw("yuv422", (128, 16)), (0, 0, 0)),
        (raw("yuv422_yuy2", (235, 128)), (255, 255, 255)),
        (jpeg(BLUE), BLUE),
        (jpeg(BLUE, "PNG"), BLUE),
    ],
)
def test_pictures_are_shown_in_their_colours(tmp_path, image, shown):
    (film,) = films(write(tmp_path, image), tmp_path / "out")
    _, (colour,) = decoded(film.path)
    assert_colour(colour, shown)


def test_sixteen_bits_of_grey_are_scaled_to_what_they_hold(tmp_path):
    image = raw("mono16", (0, 0))
    values = np.full((48, 64), 1000, np.uint16)
    values[:, 32:] = 3000
    image.data = values.tobytes()
    (film,) = films(write(tmp_path, image), tmp_path / "out")
    with av.open(str(film.path)) as file:
        (frame,) = file.decode(file.streams.video[0])
    grey = frame.to_ndarray(format="gray")
    assert grey[24, 8] < 20
    assert grey[24, 56] > 235


def test_odd_sizes_are_made_even(tmp_path):
    (film,) = films(write(tmp_path, raw(size=(63, 47))), tmp_path / "out")
    with av.open(str(film.path)) as file:
        stream = file.streams.video[0]
        assert (stream.width, stream.height, stream.codec_context.name) == (64, 48, "h264")


def test_what_is_no_frame_is_counted_with_the_first_reason(tmp_path):
    broken = raw()
    broken.data = b"\0" * 10
    half = raw()
    half.data = bytes(half.data)[: len(half.data) // 2]
    odd = raw("what_is_this")
    bag = write(tmp_path, raw(), broken, half, odd, raw(size=(32, 32)), raw())
    (film,) = films(bag, tmp_path / "out")
    assert (film.frames, film.left_out) == (2, 4)
    assert film.reason == "10 bytes are not one row of 64 pixels in rgb8"


def test_topics_without_pictures_make_no_film(tmp_path):
    bag = write(tmp_path)
    assert films(bag, tmp_path / "out") == []
    with open_bag(bag) as opened:
        with pytest.raises(UsageError, match="/text has no pictures, but std_msgs/msg/String"):
            VideoExport(opened, tmp_path / "a", ["/text"])
        with pytest.raises(NotFoundError):
            VideoExport(opened, tmp_path / "a", ["/other"])
        with pytest.raises(UsageError, match="not a frame rate"):
            VideoExport(opened, tmp_path / "a", rate=0.0)


def test_nothing_is_written_over(tmp_path):
    bag = write(tmp_path, raw())
    films(bag, tmp_path / "out")
    with pytest.raises(RefusedError, match="already exists"):
        films(bag, tmp_path / "out")


def test_times_that_jump_or_stand_still_make_a_film_all_the_same(tmp_path):
    bag = write(tmp_path, *([raw()] * 6), times_s=[0.0, 0.0, 0.0, 1e6, 1e6, 2e6])
    (film,) = films(bag, tmp_path / "out")
    times, _ = decoded(film.path)
    gap_s = 2**28 / 90_000
    assert times == pytest.approx([0.0, 0.0, 0.0, gap_s, gap_s, 2 * gap_s], abs=0.001)
    assert times == sorted(set(times))


def test_a_clock_that_was_set_does_not_fill_the_disk_with_one_picture():
    image = Image.new("RGB", SIZE)
    with pytest.raises(InvalidFileError, match="no picture came until 1000000"):
        list(resample_frames([(0.0, image), (1e6, image)], 30.0))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux's full device")
def test_a_full_disk_is_an_error_and_no_crash_of_the_encoder():
    film = VideoFile(Path("/dev/full"), SIZE, rate=30)
    with pytest.raises(OSError, match="No space left on device"):
        for number in range(100):
            film.add(number / 30, Image.new("RGB", SIZE))
    film.close()
