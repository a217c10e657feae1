"""PointCloud2 and LaserScan: points where the sensor stood, in the colours that RViz gives them."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies

from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, matrix_from_quaternion, quaternion_from_rpy, transform_stamped
from teleopctl.viewer.displays.properties import Properties
from teleopctl.viewer.displays.sensors.cloud import CloudError, read_cloud, read_scan
from teleopctl.viewer.displays.sensors.colors import Coloring
from teleopctl.viewer.displays.sensors.points import LaserScan, PointCloud, PointCloud2

CLOUD = get_message("sensor_msgs/msg/PointCloud2")
FIELD = get_message("sensor_msgs/msg/PointField")
SCAN = get_message("sensor_msgs/msg/LaserScan")
NUMBERS = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
XYZ = {"x": "f4", "y": "f4", "z": "f4"}


def cloud(columns, types=XYZ, *, big=False, pad=0, width=None, frame="lidar", stamp_ns=0):
    """A cloud whose fields have room between them, in rows that may have room behind them."""
    order = ">" if big else "<"
    length = len(columns["x"])
    width = width or length
    offsets, offset = {}, 0
    for name, kind in types.items():
        offsets[name] = offset
        offset += np.dtype(kind).itemsize + 1
    dtype = np.dtype(
        {
            "names": list(types),
            "formats": [order + kind for kind in types.values()],
            "offsets": list(offsets.values()),
            "itemsize": offset,
        }
    )
    points = np.zeros(length, dtype)
    for name, values in columns.items():
        points[name] = values
    rows = np.frombuffer(points.tobytes(), np.uint8).reshape(length // width, width * offset)
    message = CLOUD(
        width=width,
        height=length // width,
        fields=[
            FIELD(name=name, offset=offsets[name], datatype=NUMBERS[kind], count=1)
            for name, kind in types.items()
        ],
        is_bigendian=big,
        point_step=offset,
        row_step=width * offset + pad,
        data=np.pad(rows, ((0, 0), (0, pad))).tobytes(),
    )
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    return message


def put(stage, transform, stamp_ns=1, parent="base", child="lidar"):
    stage.frames.buffer.set_transform(transform_stamped(parent, child, stamp_ns, transform))
    stage.frames.update()


def made(stage, kind=PointCloud2, **given):
    display = kind(stage, "points", "/display1", {"Topic": {"Value": "/points"}, **given})
    display.begin()
    return display


def shown(display, message):
    """Hand over a message, as the graph does, and give the picture its time."""
    display.stage.publish("/points", message)
    display._due = 0.0
    display.tick()
    display.tick()


def handle(display):
    return display._drawn_ones[-1].node._handle


def places(display):
    """Where the points stand in the fixed frame, as browsers have them."""
    node = handle(display)
    w, x, y, z = (float(part) for part in node.wxyz)
    turn = np.array(matrix_from_quaternion((x, y, z, w)))
    return node.points @ turn.T + node.position


LINE = np.linspace(-1.0, 1.0, 12)
COLUMNS = {"x": LINE, "y": 2 * LINE, "z": LINE + 5}


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(("width", "pad"), [(12, 0), (12, 5), (4, 0), (4, 3)])
@pytest.mark.parametrize("kind", ["f4", "f8", "i2"])
def test_fields_are_found_by_name_offset_type_and_byte_order(big, width, pad, kind):
    columns = {"z": 3 * LINE, "intensity": 100 * LINE, "y": 20 * LINE, "x": 10 * LINE}
    types = {"z": kind, "intensity": "f4", "y": "f4", "x": "f8"}
    found = read_cloud(cloud(columns, types, big=big, pad=pad, width=width), 1000)
    z = columns["z"].astype(kind)
    assert np.allclose(found.points, np.stack([columns["x"], columns["y"], z], -1))
    assert np.allclose(found.channels["intensity"], columns["intensity"])


def test_points_that_are_nowhere_are_left_out_and_the_others_keep_what_was_measured():
    x = np.array([0.0, np.nan, 2.0, np.inf, 3e38, 5.0])
    message = cloud({"x": x, "y": x, "z": x, "intensity": np.arange(6)}, {**XYZ, "intensity": "u1"})
    found = read_cloud(message, 1000)
    assert found.points[:, 0].tolist() == [0.0, 2.0, 5.0]
    assert found.channels["intensity"].tolist() == [0, 2, 5]
    assert found.total == 6


def test_a_scan_hits_what_its_rays_say_within_its_range():
    scan = SCAN(
        angle_min=-math.pi / 2,
        angle_increment=math.pi / 2,
        range_min=0.5,
        range_max=4.0,
        ranges=[1.0, 2.0, 3.0, 0.1, 9.0, math.nan, math.inf],
        intensities=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
    )
    found = read_scan(scan)
    assert np.allclose(found.points, [[0, -1, 0], [2, 0, 0], [0, 3, 0]], atol=1e-6)
    assert found.channels["intensity"].tolist() == [1.0, 2.0, 3.0]
    assert found.total == 7


def test_the_rays_of_a_scanner_that_moves_start_where_it_is():
    scan = SCAN(range_max=9.0, ranges=[1.0, 1.0, 1.0])
    turn = quaternion_from_rpy(0.0, 0.0, 0.2)
    found = read_scan(scan, Transform((0.4, 0.0, 0.0), turn)).points
    expected = [
        (Transform((0.4 * part, 0.0, 0.0), quaternion_from_rpy(0.0, 0.0, 0.2 * part)))
        @ Transform((1.0, 0.0, 0.0))
        for part in (0.0, 0.5, 1.0)
    ]
    assert np.allclose(found, [one.translation for one in expected], atol=1e-5)


def coloured(message, **given):
    display_values = Properties(PointCloud2.properties, given)
    found = read_cloud(message, 1000)
    return Coloring.from_properties(display_values).colors(found, Transform())


@pytest.mark.parametrize("kind", ["u4", "f4"])
@pytest.mark.parametrize("big", [False, True])
def test_packed_colours_are_read_as_bits(kind, big):
    packed = np.array([0xFF102030, 0x00FF8001], np.uint32)
    message = cloud(
        {"x": [0, 1], "y": [0, 1], "z": [0, 1], "rgb": packed.view(kind)},
        {**XYZ, "rgb": kind},
        big=big,
    )
    colors, transformer = coloured(message)
    assert colors.tolist() == [[0x10, 0x20, 0x30], [0xFF, 0x80, 0x01]]
    assert transformer == "RGB8"


def test_the_rainbow_goes_from_red_to_magenta_between_the_least_and_the_most():
    z = np.array([0.0, 2.5, 5.0, np.nan])
    message = cloud({"x": z, "y": z, "z": [1, 1, 1, 1], "heat": z}, {**XYZ, "heat": "f4"})
    colors, _ = coloured(message, **{"Color Transformer": "Intensity", "Channel Name": "heat"})
    assert colors[0].tolist() == [255, 0, 0]
    assert colors[2].tolist() == [255, 0, 255]
    plain = {"Color Transformer": "Intensity", "Channel Name": "heat", "Use rainbow": False}
    bounds = {"Autocompute Intensity Bounds": False, "Min Intensity": 0, "Max Intensity": 10}
    colors, _ = coloured(message, **plain, **bounds)
    assert colors[2].tolist() == [127, 127, 127]


def test_colours_that_points_lack_are_replaced_by_those_that_they_have(stage):
    stage.frames.set_fixed_frame("lidar")
    stage.frames.update()
    display = made(stage, **{"Color Transformer": "RGB8"})
    shown(display, cloud(COLUMNS))
    assert display.status[0] == "ok"
    assert "AxisColor" in display.status[1]
    assert handle(display).colors[0].tolist() == [255, 0, 0]
    assert handle(display).colors[-1].tolist() == [255, 0, 255]


def test_points_stand_where_their_frame_stood_at_their_stamp(stage):
    put(stage, Transform((0.0, 0.0, 0.0)), 1_000_000_000)
    put(stage, Transform((10.0, 0.0, 0.0), quaternion_from_rpy(0, 0, math.pi)), 2_000_000_000)
    display = made(stage)
    shown(display, cloud(COLUMNS, stamp_ns=1_000_000_000))
    points = np.stack([COLUMNS[name] for name in "xyz"], -1)
    assert np.allclose(places(display), points, atol=0.01)
    shown(display, cloud(COLUMNS, stamp_ns=2_000_000_000))
    turned = points * [-1, -1, 1] + [10, 0, 0]
    assert np.allclose(places(display), turned, atol=0.01)
    assert display.status == ("ok", "12 points")


def test_points_far_from_the_origin_keep_their_shape(stage):
    display = made(stage)
    put(stage, Transform())
    shown(display, cloud({"x": 5000.0 + LINE, "y": LINE, "z": LINE}))
    assert np.allclose(places(display)[:, 0], 5000.0 + LINE, atol=0.002)


def test_points_wait_for_the_transform_of_their_stamp_and_say_so(stage):
    put(stage, Transform(), 1, child="other")
    display = made(stage)
    shown(display, cloud(COLUMNS))
    assert display.status == ("warn", "No transform from [lidar] to [base]")
    put(stage, Transform((1.0, 0.0, 0.0)))
    display.tick()
    display.tick()
    assert display.status == ("ok", "12 points")
    assert places(display)[0] == pytest.approx((0.0, -2.0, 4.0), abs=0.01)


def test_points_appear_where_nobody_publishes_transforms(stage):
    display = made(stage)
    stage.frames.update()
    shown(display, cloud(COLUMNS))
    assert stage.frames.fixed == "lidar"
    assert display.status == ("ok", "12 points")
    put(stage, Transform((1.0, 0.0, 0.0)))
    assert stage.frames.fixed == "base"
    display.tick()
    assert places(display)[0] == pytest.approx((0.0, -2.0, 4.0), abs=0.01)


def test_only_the_newest_of_what_came_meanwhile_is_drawn(stage):
    put(stage, Transform())
    display = made(stage)
    read = []

    def reading(job):
        read.append(job.message)
        return read_cloud(job.message, 10)

    display.read = reading
    for x in range(20):
        stage.publish("/points", cloud({"x": [x], "y": [0], "z": [0]}))
    display.tick()
    display.tick()
    assert len(read) == 1
    assert places(display)[0][0] == pytest.approx(19.0)


def test_large_clouds_are_thinned_to_the_budget_and_both_counts_are_told(stage):
    put(stage, Transform())
    display = made(stage, **{"Point Budget": 100})
    many = np.linspace(0.0, 1.0, 350)
    shown(display, cloud({"x": many, "y": many, "z": many}))
    assert len(handle(display).points) == 88
    assert display.status == ("ok", "88 of 350 points")


@pytest.mark.parametrize(
    "style", ["Points", "Squares", "Flat Squares", "Spheres", "Boxes", "Tiles"]
)
def test_every_style_draws(stage, style):
    put(stage, Transform())
    display = made(stage, Style=style)
    shown(display, cloud(COLUMNS))
    node = handle(display)
    drawn = node.batched_positions if style == "Boxes" else node.points
    assert len(drawn) == 12
    before = node.name
    display.set("Size (m)", 0.5)
    display.tick()
    display.tick()
    assert handle(display).name != before or style == "Points"


def test_with_a_decay_time_older_points_stay_until_it_is_over(stage):
    put(stage, Transform())
    display = made(stage, **{"Decay Time": 60.0})
    for x in range(3):
        shown(display, cloud({"x": [x], "y": [0], "z": [0]}))
    assert len(display._drawn_ones) == 3
    display._drawn_ones[0].until = 0.0
    display.tick()
    assert len(display._drawn_ones) == 2
    for x in range(200):
        shown(display, cloud({"x": [x], "y": [0], "z": [0]}))
    assert len(display._drawn_ones) <= 61
    display.time_jumped_back()
    assert not display._drawn_ones
    assert not [name for name in stage.scene._handle_from_node_name if "/display1/" in name]


def test_a_cloud_that_makes_no_sense_says_why_and_the_next_one_is_drawn(stage):
    put(stage, Transform())
    display = made(stage)
    shown(display, cloud({"x": LINE}, {"x": "f4"}))
    assert display.status == ("error", "The cloud has no field 'y', 'z'")
    shown(display, cloud(COLUMNS))
    assert display.status[0] == "ok"
    display.end()
    assert not display._drawn_ones


def test_an_empty_cloud_takes_the_last_one_away(stage):
    put(stage, Transform())
    display = made(stage)
    shown(display, cloud(COLUMNS))
    shown(display, CLOUD(header=cloud(COLUMNS).header))
    assert handle(display) is None
    assert display.status == ("ok", "0 points")


def test_a_scan_is_drawn_and_waits_for_where_the_scanner_is_at_its_end(stage):
    put(stage, Transform(), 1_000_000_000)
    display = made(stage, LaserScan)
    scan = SCAN(range_max=9.0, ranges=[1.0, 1.0], time_increment=0.5)
    scan.header.frame_id, scan.header.stamp.sec = "lidar", 1
    shown(display, scan)
    assert display.status[0] == "warn"
    put(stage, Transform((2.0, 0.0, 0.0)), 1_500_000_000)
    display.tick()
    display.tick()
    assert np.allclose(places(display), [[1, 0, 0], [3, 0, 0]], atol=0.01)


small = strategies.integers(0, 40) | strategies.sampled_from([2**31, 2**32 - 1])
fields = strategies.builds(
    FIELD,
    name=strategies.sampled_from(["x", "y", "z", "rgb", "intensity", "r", "g", "b", ""]),
    offset=small,
    datatype=strategies.integers(0, 255) | strategies.integers(1, 8),
    count=small,
)
xyz_first = strategies.just(
    [FIELD(name=name, offset=4 * at, datatype=7, count=1) for at, name in enumerate("xyz")]
)


@given(
    small, small, small, small,
    strategies.tuples(xyz_first | strategies.just([]), strategies.lists(fields, max_size=4)),
    strategies.binary(max_size=300), strategies.booleans(),
    strategies.sampled_from(["", "Intensity", "RGB8", "RGBF32", "AxisColor", "FlatColor"]),
)  # fmt: skip
def test_an_absurd_cloud_is_refused_or_coloured_and_nothing_else(
    width, height, step, row, fields, data, big, transformer
):
    message = CLOUD(
        width=width, height=height, point_step=step, row_step=row,
        fields=[*fields[0], *fields[1]], data=data, is_bigendian=big,
    )  # fmt: skip
    try:
        found = read_cloud(message, 100)
    except CloudError as error:
        assert error.message
        return
    assert np.isfinite(found.points).all()
    if len(found.points):
        given = {"Color Transformer": transformer} if transformer else {}
        colors, _ = coloured(message, **given)
        assert colors.shape in ((3,), found.points.shape)


absurd = strategies.floats(width=32)


@given(absurd, absurd, absurd, absurd, strategies.lists(absurd, max_size=9))
def test_an_absurd_scan_has_no_points_or_finite_ones(start, increment, least, most, ranges):
    scan = SCAN(
        angle_min=start, angle_increment=increment, range_min=least, range_max=most,
        ranges=ranges, intensities=ranges[:3],
    )  # fmt: skip
    assert np.isfinite(read_scan(scan).points).all()


def test_a_cloud_of_the_old_type_is_drawn_with_its_channels(stage):
    put(stage, Transform((1.0, 0.0, 0.0)))
    corner, channel = get_message("geometry_msgs/msg/Point32"), "sensor_msgs/msg/ChannelFloat32"
    message = get_message("sensor_msgs/msg/PointCloud")(
        points=[corner(x=float(number)) for number in range(3)] + [corner(x=math.nan)],
        channels=[
            get_message(channel)(name="intensity", values=[0.0, 0.5, 1.0, 9.0]),
            get_message(channel)(name="short", values=[1.0]),
        ],
    )
    message.header.frame_id = "lidar"
    display = made(stage, PointCloud)
    shown(display, message)
    assert np.allclose(places(display), [[1, 0, 0], [2, 0, 0], [3, 0, 0]], atol=0.01)
    assert len({tuple(color) for color in handle(display).colors.tolist()}) == 3
    assert display.status == ("ok", "3 of 4 points")
