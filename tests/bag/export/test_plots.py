"""Numbers of a bag as curves and pictures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from teleopctl.bag import (
    BagMessage,
    BagWriter,
    Curve,
    check_plot_file,
    open_bag,
    read_curves,
    save_plot,
)
from teleopctl.bag.export.plots import MOST_CURVES, parse_field
from teleopctl.errors import InvalidMessageError, NotFoundError, SystemFailureError, UsageError
from tests.bag.bags import START_NS, message, topic

JOINT_STATE = "sensor_msgs/msg/JointState"
NAN = math.nan


@pytest.fixture
def write(tmp_path: Path):
    def write_bag(*positions: list[float], names: list[str] | None = None, **other: Any) -> Path:
        """A message each millisecond; then one a second after the first on another topic."""
        with BagWriter(tmp_path / "bag") as writer:
            writer.add_topic(topic("/joint_states", JOINT_STATE))
            writer.add_topic(topic("/load", "std_msgs/msg/Float32"))
            for number, position in enumerate(positions):
                fields = {"name": names or [], "position": position, **other}
                writer.write(message("/joint_states", number, JOINT_STATE, **fields))
            writer.write(message("/load", 1000, "std_msgs/msg/Float32", data=2.5))
        return tmp_path / "bag"

    return write_bag


def curves(bag: Path, *fields: str, **times: float) -> list[Curve]:
    with open_bag(bag) as opened:
        return read_curves(opened, fields, **times)


def test_a_field_is_written_as_in_rqt_plot_or_as_in_python():
    topics = ["/odom", "/odom/raw", "/tf"]
    for text in ("/odom/raw/pose/pose/x", "/odom/raw/pose.pose.x", "odom/raw.pose.pose.x"):
        assert parse_field(text, topics) == ("/odom/raw", "pose.pose.x")
        assert parse_field(text, topics).full_name == "/odom/raw/pose/pose/x"
    assert parse_field("/odom/rawness", topics) == ("/odom", "rawness")
    with pytest.raises(NotFoundError, match="begins with none of the bag's topics") as caught:
        parse_field("/odum/pose", topics)
    assert caught.value.hint == "Did you mean /odom?"


def test_each_element_of_an_array_is_a_curve_with_its_joint(write):
    bag = write([0.0, 1.0], [0.5, -1.0], names=["shoulder", "elbow"])
    first, second, load = curves(bag, "/joint_states/position", "/load/data")
    assert first == ("/joint_states/position[0] shoulder", [0.0, 0.001], [0.0, 0.5])
    assert second == ("/joint_states/position[1] elbow", [0.0, 0.001], [1.0, -1.0])
    assert load == ("/load/data", [1.0], [2.5])


def test_nan_and_what_is_missing_are_one_gap_and_infinity_too(write):
    bag = write([1.0], [2.0], [NAN], [], [math.inf], [3.0])
    (curve,) = curves(bag, "/joint_states/position[0]")
    assert curve.times == [0.0, 0.001, 0.002, 0.005]
    assert curve.values[:2] + curve.values[3:] == [1.0, 2.0, 3.0]
    assert math.isnan(curve.values[2])


def test_only_the_time_that_was_asked_for_is_read(write):
    bag = write(*([float(n)] for n in range(100)))
    (curve,) = curves(bag, "/joint_states/position[0]", start_s=0.010, end_s=0.012)
    assert curve.values == [10.0, 11.0, 12.0]
    with pytest.raises(NotFoundError, match="no message of /joint_states in that time"):
        curves(bag, "/joint_states/position[0]", start_s=0.5)


def test_no_peak_of_many_samples_is_lost(tmp_path, monkeypatch):
    count, peak = 2000, 1234
    monkeypatch.setattr("teleopctl.bag.export.plots._INTERVALS", 100)
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/load", "std_msgs/msg/Float32"))
        for number in range(count):
            value = 9.0 if number == peak else math.sin(number / 50)
            writer.write(message("/load", number, "std_msgs/msg/Float32", data=value))
    (curve,) = curves(tmp_path / "bag", "/load/data")
    assert len(curve.times) <= 202
    assert curve.times == sorted(curve.times)
    assert curve.values[curve.times.index(peak / 1000)] == 9.0
    for time_s, value in zip(curve.times, curve.values, strict=True):
        assert value == pytest.approx(math.sin(time_s * 20), abs=1e-6) or time_s == peak / 1000


@pytest.mark.parametrize(
    ("field", "error", "text"),
    [
        ("/joint_states", UsageError, "needs a field of it"),
        ("/joint_states/name", InvalidMessageError, r"name\[0\] is not a number but str"),
        ("/joint_states/header", InvalidMessageError, "is not a number but std_msgs/msg/Header"),
        ("/joint_states/effort", InvalidMessageError, "was empty in all messages"),
        ("/joint_states/positions", InvalidMessageError, "has no field 'positions'"),
        ("/joint_states/position[9]", InvalidMessageError, "there is no element 9"),
        ("/joint_states/position[", UsageError, "Invalid field"),
    ],
)
def test_what_is_no_number_is_named(write, field, error, text):
    bag = write([1.0], names=["a"])
    with pytest.raises(error, match=text):
        curves(bag, field)


def test_more_curves_than_can_be_told_apart_are_refused(write):
    bag = write([0.0] * 1000)
    with pytest.raises(UsageError, match=f"{MOST_CURVES} can"):
        curves(bag, "/joint_states/position")


def test_messages_that_cannot_be_read_are_passed_over(write, tmp_path):
    with BagWriter(tmp_path / "broken") as writer:
        writer.add_topic(topic("/load", "std_msgs/msg/Float32"))
        writer.write(message("/load", 0, "std_msgs/msg/Float32", data=1.0))
        writer.write(BagMessage("/load", START_NS + 5, 0, b"\0\1"))
    (curve,) = curves(tmp_path / "broken", "/load/data")
    assert curve.values == [1.0]


def test_a_bag_without_messages_has_no_curves(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(topic("/load", "std_msgs/msg/Float32"))
    with pytest.raises(NotFoundError, match="no message of /load"):
        curves(tmp_path / "bag", "/load/data")


EXAMPLE = [
    Curve("/a/position[0] elbow", [0.0, 1.0, 2.0], [0.0, 1.0, 0.5]),
    Curve("/_$x$ <&>", [0.0, 1.0, 1.5, 2.0], [1.0, NAN, 0.2, 0.1]),
]


def test_an_svg_has_each_curve_by_its_name_and_texts_as_texts(tmp_path):
    save_plot(EXAMPLE, tmp_path / "a.svg", "session")
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    ids = [element.get("id") for element in root.iter()]
    assert {curve.name for curve in EXAMPLE} <= set(ids)
    texts = {
        "".join(element.itertext()).strip() for element in root.iter() if "text" in element.tag
    }
    assert {"session", "Seconds since the start of the bag", *(c.name for c in EXAMPLE)} <= texts
    save_plot(EXAMPLE, tmp_path / "b.svg", "session")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_a_png_shows_the_curves_in_different_colours(tmp_path):
    save_plot(EXAMPLE, tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        assert image.size[0] == 1200
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    for colour in ((0x1F, 0x77, 0xB4), (0xFF, 0x7F, 0x0E)):
        assert (pixels == colour).all(axis=1).sum() > 100


def test_pictures_have_names_that_say_what_they_are(tmp_path):
    with pytest.raises(UsageError, match=r"must end in \.png"):
        check_plot_file(tmp_path / "a.jpg")
    with pytest.raises(UsageError, match=r"There is no folder '.*none' for 'a\.png'"):
        check_plot_file(tmp_path / "none" / "a.png")
    (tmp_path / "a.png").mkdir()
    with pytest.raises(SystemFailureError, match="Cannot write"):
        save_plot(EXAMPLE, tmp_path / "a.png")
