"""Map: cells where the grid says, in RViz's colours, with their changes."""

import array
import io
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies
from PIL import Image as Pil

from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, transform_stamped
from teleopctl.viewer.displays.sensors.map import (
    Map,
    MapError,
    apply_update,
    cells_of,
    map_png,
    palette,
)

GRID = get_message("nav_msgs/msg/OccupancyGrid")
# map_msgs/msg/OccupancyGridUpdate is learned from whoever publishes it.
UPDATE = SimpleNamespace


def cells(*values):
    return array.array("b", values)


def grid(rows, frame="map", resolution=0.5):
    rows = np.asarray(rows, np.int8)
    message = GRID(data=rows.ravel().tolist())
    message.info.height, message.info.width = rows.shape
    message.info.resolution = resolution
    message.info.origin.position.x = -1.0
    message.header.frame_id = frame
    return message


def pixels(png, rows):
    image = np.asarray(Pil.open(io.BytesIO(png)).convert("RGBA"))
    times = len(image) // rows
    return image[times // 2 :: times, times // 2 :: times]


@pytest.fixture
def display(stage):
    display = Map(stage, "map", "/display1", {"Topic": {"Value": "/map"}})
    display.begin()
    stage.frames.set_fixed_frame("map")
    stage.frames.update()
    return display


def drawn(display):
    display._due = 0.0
    display.tick()
    return pixels(display._image._data, len(display._cells))


@pytest.mark.parametrize(
    ("scheme", "value", "rgba"),
    [
        ("map", 0, (255, 255, 255, 255)),
        ("map", 100, (0, 0, 0, 255)),
        ("map", 50, (128, 128, 128, 255)),
        ("map", -1, (112, 137, 134, 255)),
        ("map", 101, (0, 255, 0, 255)),
        ("map", -128, (255, 0, 0, 255)),
        ("map", -2, (255, 255, 0, 255)),
        ("costmap", 0, (0, 0, 0, 0)),
        ("costmap", 1, (2, 0, 253, 255)),
        ("costmap", 98, (249, 0, 6, 255)),
        ("costmap", 99, (0, 255, 255, 255)),
        ("costmap", 100, (255, 0, 255, 255)),
        ("costmap", -1, (112, 137, 134, 255)),
        ("raw", 7, (7, 7, 7, 255)),
        ("raw", -1, (255, 255, 255, 255)),
    ],
)
def test_cells_have_rvizs_colours(scheme, value, rgba):
    assert tuple(int(part) for part in palette(scheme)[np.uint8(value % 256)]) == rgba


def test_the_first_row_is_at_the_origin_and_the_map_is_as_large_as_its_cells(display, stage):
    stage.publish("/map", grid([[100, 0, 0], [0, 0, -1]]))
    found = drawn(display)
    # viser draws a picture's first row at negative y, which is where the origin is
    assert found[0, 0].tolist()[:3] == [0, 0, 0]
    assert found[1, 2].tolist() == [112, 137, 134, int(0.7 * 255)]
    image = display._image
    assert image.name == "/frames/map/display1"
    assert (image.render_width, image.render_height) == (1.5, 1.0)
    assert image.position.tolist()[:2] == [-1.0 + 0.75, 0.5]
    display.tick()
    assert display.status == ("ok", "3 x 2 cells of 0.5 m")


def test_changes_are_drawn_as_far_as_they_lie_in_the_map(display, stage):
    stage.publish("/map", grid(np.zeros((3, 4))))
    stage.publish("/map_updates", UPDATE(x=2, y=1, width=2, height=1, data=cells(100, 100)))
    found = drawn(display)
    assert (found[..., 0] == 0).tolist() == [[False] * 4, [False, False, True, True], [False] * 4]
    stage.publish("/map_updates", UPDATE(x=-1, y=-1, width=2, height=2, data=cells(*[100] * 4)))
    assert drawn(display)[0, 0, 0] == 0
    assert display.status[0] == "warn"


def test_other_colours_draw_the_same_map_anew(display, stage):
    stage.publish("/map", grid([[0, 100]]))
    drawn(display)
    display.set("Color Scheme", "costmap")
    display.set("Alpha", 1.0)
    found = drawn(display)
    assert found[0].tolist() == [[0, 0, 0, 0], [255, 0, 255, 255]]


def test_a_map_whose_frame_is_not_known_says_so_until_it_is(display, stage):
    stage.publish("/map", grid([[0]], frame="odom"))
    drawn(display)
    stage.frames.update()
    display.tick()
    assert display.status == ("warn", "No transform from [odom] to [map]")
    stage.frames.buffer.set_transform(transform_stamped("map", "odom", 1, Transform()))
    stage.frames.update()
    display.tick()
    assert display.status[0] == "ok"


def test_what_is_no_map_takes_the_last_one_away_and_says_why(display, stage):
    stage.publish("/map", grid([[0]]))
    drawn(display)
    for resolution in (0.0, -1.0, math.nan, math.inf):
        stage.publish("/map", grid([[0]], resolution=resolution))
        assert display.status[0] == "error"
        assert display._image is None
    stage.publish("/map", GRID())
    assert display.status[0] == "error"
    display.end()
    assert not stage.listens_to("/map_updates")


def test_large_maps_are_thinned_and_small_ones_keep_sharp_edges():
    assert Pil.open(io.BytesIO(map_png(np.zeros((5000, 10), np.int8), "map", 1.0))).height == 2500
    assert Pil.open(io.BytesIO(map_png(np.zeros((10, 10), np.int8), "map", 1.0))).height == 80


sizes = strategies.integers(0, 20) | strategies.sampled_from([2**16, 2**32 - 1])


@given(sizes, sizes, strategies.lists(strategies.integers(-128, 127), max_size=200))
def test_an_absurd_map_is_refused_or_drawn(width, height, data):
    message = GRID(data=data)
    message.info.width, message.info.height = width, height
    try:
        found, wrong = cells_of(message)
    except MapError as error:
        assert error.message
    else:
        assert bool(wrong) == (len(data) != width * height)
        assert found.ravel()[: len(data)].tolist() == data[: found.size]


places = strategies.integers(-5, 12) | strategies.sampled_from([2**31 - 1, -(2**31)])


@given(places, places, sizes, sizes, strategies.lists(strategies.just(100), max_size=60))
def test_an_absurd_change_reaches_no_further_than_the_map(x, y, width, height, data):
    found = np.zeros((6, 7), np.int8)
    apply_update(found, UPDATE(x=x, y=y, width=width, height=height, data=cells(*data)))
    rows, columns = np.nonzero(found)
    assert all(x <= column < x + width for column in columns.tolist())
    assert all(y <= row < y + height for row in rows.tolist())
