"""Displays of poses, paths and arrows: what browsers are sent is what messages say."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies

from teleopctl.interfaces import get_message
from teleopctl.tf import Transform, quaternion_from_rpy
from teleopctl.viewer import ERROR, OK, WARN
from tests.viewer.conftest import FakePage
from tests.viewer.displays.conftest import SECOND, Draw, Picture, look, message, put_frame

QUARTER = quaternion_from_rpy(0.0, 0.0, math.pi / 2)


def point(x: float, y: float, z: float = 0.0) -> Any:
    return get_message("geometry_msgs/msg/Point")(x=x, y=y, z=z)


def pose(x: float, y: float, z: float = 0.0, *, turn: Any = (0.0, 0.0, 0.0, 1.0)) -> Any:
    made = get_message("geometry_msgs/msg/Pose")(position=point(x, y, z))
    made.orientation.x, made.orientation.y, made.orientation.z, made.orientation.w = turn
    return made


def pose_stamped(*place: float, frame: str = "map", stamp: int = 0, turn: Any = None) -> Any:
    at = pose(*place, turn=turn or (0.0, 0.0, 0.0, 1.0))
    return message("geometry_msgs/msg/PoseStamped", frame, stamp, pose=at)


def path_through(*poses: Any) -> Any:
    stamped = [get_message("geometry_msgs/msg/PoseStamped")(pose=one) for one in poses]
    return message("nav_msgs/msg/Path", poses=stamped)


def light(*color: int) -> list[int]:
    """What viser's batches and lines want for a colour: its amounts of light, by the standard."""
    shades = [part / 255 for part in color]
    return [
        round(255 * (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4)) for c in shades
    ]


def test_an_arrow_points_along_the_x_axis_of_its_pose(page: FakePage, draw: Draw, picture: Picture):
    draw("Pose")
    page.publish("/it", pose_stamped(1.0, 2.0, turn=QUARTER))
    look(page)
    nodes = picture.nodes("/display1")
    assert set(nodes) == {"cylinder", "cone"}
    # a shaft of 1 m and a head of 0.3 m, from the pose towards y
    np.testing.assert_allclose(nodes["cylinder"].batched_positions, [[1.0, 2.5, 0.0]], atol=1e-6)
    np.testing.assert_allclose(nodes["cone"].batched_positions, [[1.0, 3.15, 0.0]], atol=1e-6)
    np.testing.assert_allclose(nodes["cone"].batched_scales, [[0.2, 0.2, 0.3]], atol=1e-6)
    np.testing.assert_array_equal(nodes["cone"].batched_colors, [light(255, 25, 0)])


def test_a_pose_stands_where_its_frame_stood_at_its_time(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("Pose", Shape="Axes", **{"Axes Length": 2.0})
    put_frame(page, "tool", "map", Transform((0.0, 0.0, 0.0)), SECOND)
    put_frame(page, "tool", "map", Transform((10.0, 0.0, 0.0)), 2 * SECOND)
    page.publish("/it", pose_stamped(0.0, 0.0, frame="tool", stamp=SECOND * 3 // 2))
    look(page)
    axes = picture.nodes("/display1")["cylinder"]
    middles = np.array([[6.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 1.0]])
    np.testing.assert_allclose(axes.batched_positions, middles, atol=1e-6)
    np.testing.assert_array_equal(axes.batched_colors, np.eye(3) * 255)


def test_a_message_waits_for_its_transform_and_the_status_says_so(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Pose")
    page.publish("/it", pose_stamped(0.0, 0.0, frame="tool", stamp=SECOND))
    look(page)
    assert display.status == (WARN, "No transform from [tool] to [map]")
    assert not picture.nodes("/display1")
    put_frame(page, "tool", "map", Transform((3.0, 0.0, 0.0)), SECOND)
    look(page)
    assert display.status == (OK, "")
    assert picture.nodes("/display1")["cylinder"].batched_positions[0][0] == 3.5


def test_where_tf_comes_late_the_newest_message_that_has_a_place_is_drawn(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("Pose")
    put_frame(page, "tool", "map", Transform(), SECOND)
    put_frame(page, "tool", "map", Transform((1.0, 0.0, 0.0)), 2 * SECOND)
    for second in (1, 2, 3, 4):
        page.publish("/it", pose_stamped(0.0, 0.0, frame="tool", stamp=second * SECOND))
    look(page)
    assert picture.nodes("/display1")["cylinder"].batched_positions[0][0] == 1.5
    put_frame(page, "tool", "map", Transform((7.0, 0.0, 0.0)), 3 * SECOND)
    look(page)
    assert picture.nodes("/display1")["cylinder"].batched_positions[0][0] == 7.5


def test_what_is_older_than_tf_remembers_is_drawn_where_its_frame_stands_now(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Pose")
    put_frame(page, "tool", "map", Transform((4.0, 0.0, 0.0)), 90 * SECOND)
    page.publish("/it", pose_stamped(0.0, 0.0, frame="tool", stamp=SECOND))
    look(page)
    assert display.status == (OK, "")
    assert picture.nodes("/display1")["cylinder"].batched_positions[0][0] == 4.5


def test_another_fixed_frame_moves_what_is_drawn(page: FakePage, draw: Draw, picture: Picture):
    draw("PointStamped", Radius=0.1)
    put_frame(page, "tool", "map", Transform((2.0, 0.0, 0.0)), SECOND)
    page.publish("/it", message("geometry_msgs/msg/PointStamped", point=point(5.0, 0.0)))
    look(page)
    page.frames.set_fixed_frame("tool")
    look(page)
    look(page)
    ball = picture.nodes("/display1")["sphere"]
    np.testing.assert_allclose(ball.batched_positions, [[3.0, 0.0, 0.0]])
    np.testing.assert_allclose(ball.batched_scales, [[0.2, 0.2, 0.2]])


def test_a_history_is_as_long_as_its_property_says(page: FakePage, draw: Draw, picture: Picture):
    display = draw("PointStamped", **{"History Length": 3})
    for x in range(5):
        page.publish("/it", message("geometry_msgs/msg/PointStamped", point=point(float(x), 0.0)))
    look(page)
    assert picture.nodes("/display1")["sphere"].batched_positions[:, 0].tolist() == [2.0, 3.0, 4.0]
    display.set("History Length", 2)
    look(page)
    assert picture.nodes("/display1")["sphere"].batched_positions[:, 0].tolist() == [3.0, 4.0]


def test_nothing_is_left_of_a_display_that_has_ended(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Path", **{"Pose Style": "Arrows"})
    page.publish("/it", path_through(pose(0.0, 0.0), pose(1.0, 0.0)))
    look(page)
    assert picture.nodes("/display1")
    display.end()
    look(page)
    assert not picture.nodes("/display1")


def test_a_path_is_a_line_through_its_poses(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Path", **{"Line Style": "Billboards", "Line Width": 0.05})
    page.publish("/it", path_through(pose(0.0, 0.0), pose(1.0, 0.0), pose(1.0, 2.0)))
    look(page)
    (line,) = picture.nodes("/display1").values()
    assert line.points.tolist() == [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 2, 0]]]
    assert (line.thickness, line.thickness_units) == (pytest.approx(0.05), "world")
    assert line.colors.reshape(-1, 3).tolist() == [light(25, 255, 0)] * 4
    display.set("Line Style", "Lines")
    display.set("Pose Style", "Axes")
    look(page)
    nodes = picture.nodes("/display1")
    assert nodes["lines0"].thickness_units == "screen"
    assert len(nodes["cylinder"].batched_positions) == 9


def test_a_pose_that_is_not_finite_is_left_out_and_the_status_says_so(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("Path")
    page.publish("/it", path_through(pose(0.0, 0.0), pose(math.nan, 0.0), pose(1.0, 2.0)))
    look(page)
    assert picture.nodes("/display1")["lines0"].points.tolist() == [[[0, 0, 0], [1, 2, 0]]]
    assert display.status == (WARN, "1 is not drawn: poses must be finite numbers")


def test_particles_are_one_batch_of_flat_arrows_or_of_axes(
    page: FakePage, draw: Draw, picture: Picture
):
    display = draw("PoseArray")
    poses = [pose(float(x), 0.0, turn=QUARTER) for x in range(100)]
    page.publish("/it", message("geometry_msgs/msg/PoseArray", poses=poses))
    look(page)
    (arrows,) = picture.nodes("/display1").values()
    assert arrows.points.shape == (300, 2, 3)
    np.testing.assert_allclose(arrows.points[0], [[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]], atol=1e-6)
    display.set("Shape", "Axes")
    look(page)
    (axes,) = picture.nodes("/display1").values()
    assert axes.batched_positions.shape == (300, 3)


def test_odometry_keeps_a_pose_for_every_step_and_the_last_covariance(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("Odometry", Keep=5)
    for step in range(100):
        odometry = message("nav_msgs/msg/Odometry")
        odometry.pose.pose = pose(step * 0.06, 0.0)
        odometry.pose.covariance[0] = 0.25
        odometry.pose.covariance[7] = 0.01
        odometry.pose.covariance[35] = 0.01
        page.publish("/it", odometry)
    look(page)
    nodes = picture.nodes("/display1")
    # more than 0.1 m apart
    np.testing.assert_allclose(
        nodes["cylinder"].batched_positions[:, 0] - 0.5, [5.4, 5.52, 5.64, 5.76, 5.88], atol=1e-5
    )
    ellipsoid = nodes["sphere_clear"]
    np.testing.assert_allclose(ellipsoid.batched_positions, [[5.88, 0.0, 0.0]], atol=1e-5)
    # twice the standard deviation across, whichever of its axes is which
    assert sorted(ellipsoid.batched_scales[0].tolist()) == pytest.approx([0.001, 0.2, 1.0])
    assert "surface0" in nodes


@given(
    strategies.lists(strategies.floats(-1, 1), min_size=9, max_size=9),
    strategies.lists(strategies.floats(0.05, 2), min_size=3, max_size=3),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_ellipsoid_is_the_covariance(
    page: FakePage, draw: Draw, picture: Picture, turn: list[float], spread: list[float]
):
    for display in list(page.displays):
        page.remove_display(display)
    draw("PoseWithCovariance", Covariance={"Orientation": {"Value": False}})
    q, _ = np.linalg.qr(np.array(turn).reshape(3, 3) + 3 * np.eye(3))
    covariance = q @ np.diag(np.square(spread)) @ q.T
    said = message("geometry_msgs/msg/PoseWithCovarianceStamped")
    whole = np.zeros((6, 6))
    whole[:3, :3] = covariance
    said.pose.covariance = whole.reshape(-1)
    page.publish("/it", said)
    look(page)
    node = picture.nodes("/display1")["sphere_clear"]
    w, x, y, z = (float(part) for part in node.batched_wxyzs[0])
    matrix = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    radii = np.diag(np.square(node.batched_scales[0] / 2))
    np.testing.assert_allclose(matrix @ radii @ matrix.T, covariance, atol=1e-4)


def test_a_polygon_is_closed(page: FakePage, draw: Draw, picture: Picture):
    draw("Polygon")
    corner = get_message("geometry_msgs/msg/Point32")
    polygon = message("geometry_msgs/msg/PolygonStamped")
    polygon.polygon.points = [corner(x=0.0), corner(x=1.0), corner(x=1.0, y=1.0)]
    page.publish("/it", polygon)
    look(page)
    ends = picture.nodes("/display1")["lines0"].points
    assert ends.shape == (3, 2, 3)
    assert ends[-1].tolist() == [[1, 1, 0], [0, 0, 0]]


def test_grid_cells_are_squares_of_their_size(page: FakePage, draw: Draw, picture: Picture):
    draw("GridCells", Alpha=0.5)
    cells = message("nav_msgs/msg/GridCells", cell_width=0.5, cell_height=0.25)
    cells.cells = [point(0.0, 0.0), point(1.0, 0.0)]
    page.publish("/it", cells)
    look(page)
    node = picture.nodes("/display1")["box_clear"]
    np.testing.assert_allclose(node.batched_scales[:, :2], [[0.5, 0.25]] * 2)
    assert node.batched_opacities.tolist() == [0.5, 0.5]


def test_a_range_is_a_cone_with_its_tip_at_the_sensor(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Range")
    said = message("sensor_msgs/msg/Range", field_of_view=math.pi / 2, max_range=4.0, range=2.0)
    page.publish("/it", said)
    look(page)
    (cone,) = picture.nodes("/display1").values()
    np.testing.assert_allclose(cone.batched_positions, [[1.0, 0.0, 0.0]])
    np.testing.assert_allclose(cone.batched_scales, [[4.0, 4.0, 2.0]], rtol=1e-6)
    said.range = math.inf
    page.publish("/it", said)
    look(page)
    assert not picture.nodes("/display1")
    assert display.status[0] == WARN


def test_a_wrench_is_a_force_and_a_torque_with_its_turn(
    page: FakePage, draw: Draw, picture: Picture
):
    draw("Wrench", **{"Arrow Width": 0.1})
    said = message("geometry_msgs/msg/WrenchStamped")
    said.wrench.force.z = 1.3
    said.wrench.torque.x = 0.65
    page.publish("/it", said)
    look(page)
    nodes = picture.nodes("/display1")
    np.testing.assert_allclose(
        nodes["cylinder"].batched_positions, [[0, 0, 1.0], [0.5, 0, 0]], atol=1e-6
    )
    assert nodes["cone"].batched_colors.tolist() == [light(204, 51, 51), light(204, 204, 51)]
    assert (nodes["lines0"].points[:23, :, 0] == np.float32(0.65)).all()


def test_axes_hang_on_their_frame(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Axes", **{"Reference Frame": "tool"})
    look(page)
    assert display.status == (WARN, "No transform from [tool] to [map]")
    put_frame(page, "tool", "map", Transform((1.0, 0.0, 0.0)))
    look(page)
    assert display.status == (OK, "")
    (axes,) = picture.nodes("/frames/tool").values()
    np.testing.assert_allclose(axes.batched_scales, [[0.2, 0.2, 1.0]] * 3)


def test_an_arrow_that_is_not_finite_is_not_drawn(page: FakePage, draw: Draw, picture: Picture):
    display = draw("Pose")
    page.publish("/it", pose_stamped(math.inf, 0.0))
    look(page)
    assert not picture.nodes("/display1")
    assert display.status[0] == ERROR


def test_particles_are_the_longer_the_likelier(page: FakePage, draw: Draw, picture: Picture):
    display = draw("ParticleCloud")
    particles = [
        SimpleNamespace(pose=pose(0.0, 0.0), weight=0.0),
        SimpleNamespace(pose=pose(5.0, 0.0), weight=0.5),
        SimpleNamespace(pose=pose(9.0, 0.0), weight=7.0),
        SimpleNamespace(pose=pose(0.0, 0.0), weight=math.nan),
    ]
    header = get_message("std_msgs/msg/Header")()
    page.publish("/it", SimpleNamespace(header=header, particles=particles))
    look(page)
    ends = picture.nodes("/display1")["lines0"].points
    shafts = {float(a[0]): float(b[0]) for a, b in ends if a[0] in (0.0, 5.0, 9.0)}
    assert shafts == pytest.approx({0.0: 0.02, 5.0: 5.16, 9.0: 9.3})
    assert display.status == (WARN, "1 is not drawn: particles must be finite numbers")
    assert display.values.given["Class"] == "nav2_rviz_plugins/ParticleCloud"
