"""Packages beside rclpy that nodes compute with: images, point clouds, rotations."""

import math

import numpy as np
import pytest
import tf_transformations as tft
from cv_bridge import CvBridge, CvBridgeError
from image_geometry import PinholeCameraModel, StereoCameraModel
from sensor_msgs.msg import CameraInfo
from sensor_msgs_py import point_cloud2
from tf_transformations.euler import SEQUENCES

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces.store import get_message

HEADER = get_message("std_msgs/msg/Header")(frame_id="lidar")
FIELD = get_message("sensor_msgs/msg/PointField")
IMAGE = get_message("sensor_msgs/msg/Image")


@pytest.mark.parametrize(
    ("encoding", "dtype", "shape"),
    [
        ("bgr8", np.uint8, (4, 5, 3)),
        ("rgba8", np.uint8, (4, 5, 4)),
        ("mono8", np.uint8, (4, 5)),
        ("mono16", np.uint16, (4, 5)),
        ("16UC1", np.uint16, (4, 5)),
        ("32FC1", np.float32, (4, 5)),
        ("8SC2", np.int8, (4, 5, 2)),
        ("passthrough", np.float64, (4, 5, 3)),
    ],
)
def test_pixels_survive_the_way_through_a_message(encoding, dtype, shape):
    pixels = np.arange(math.prod(shape)).reshape(shape).astype(dtype)
    message = CvBridge().cv2_to_imgmsg(pixels, encoding, HEADER)
    assert (message.width, message.height, message.header.frame_id) == (5, 4, "lidar")
    back = CvBridge().imgmsg_to_cv2(message)
    assert back.dtype == dtype
    assert np.array_equal(back, pixels)


@pytest.mark.parametrize(
    ("given", "pixel", "wanted", "expected"),
    [
        ("rgb8", (10, 20, 30), "bgr8", [30, 20, 10]),
        ("bgr8", (10, 20, 30), "rgba8", [30, 20, 10, 255]),
        ("bgra8", (10, 20, 30, 7), "rgb8", [30, 20, 10]),
        ("rgb8", (255, 0, 0), "mono8", 76),
        ("bgr8", (255, 0, 0), "mono8", 29),
        ("mono8", 9, "bgr8", [9, 9, 9]),
        ("mono8", 255, "mono16", 65535),
        ("rgb8", (10, 20, 30), "8UC3", [10, 20, 30]),
    ],
)
def test_colours_are_converted_as_they_are_named(given, pixel, wanted, expected):
    pixels = np.array([[pixel]], dtype=np.uint8)
    message = CvBridge().cv2_to_imgmsg(pixels, given)
    assert CvBridge().imgmsg_to_cv2(message, wanted)[0, 0].tolist() == expected


def test_padded_rows_and_the_other_byte_order_are_read():
    data = bytes([0, 1, 0, 2, 99, 99, 0, 3, 0, 4, 99, 99])
    message = IMAGE(height=2, width=2, encoding="mono16", is_bigendian=1, step=6, data=data)
    assert CvBridge().imgmsg_to_cv2(message).tolist() == [[1, 2], [3, 4]]


@pytest.mark.parametrize(
    ("act", "error"),
    [
        (lambda b: b.cv2_to_imgmsg(np.zeros((2, 2, 3), np.uint8), "mono8"), "are not mono8"),
        (lambda b: b.cv2_to_imgmsg(np.zeros((2, 2), bool)), "not known"),
        (lambda b: b.imgmsg_to_cv2(IMAGE(encoding="fancy")), "'fancy' is not known"),
        (lambda b: b.imgmsg_to_cv2(IMAGE(width=9, height=9, encoding="mono8")), "no image"),
        (lambda b: b.cvtColor(np.zeros((2, 2), np.float32), "32FC1", "bgr8"), "no way"),
    ],
)
def test_what_cannot_be_converted_is_said(act, error):
    with pytest.raises(CvBridgeError, match=error):
        act(CvBridge())


def test_points_survive_the_way_through_a_cloud():
    points = [(1.0, 2.0, 3.0), (4.0, float("nan"), 6.0), (7.0, 8.0, 9.0)]
    cloud = point_cloud2.create_cloud_xyz32(HEADER, points)
    assert (cloud.width, cloud.height, cloud.point_step, cloud.row_step) == (3, 1, 12, 36)
    assert point_cloud2.read_points_list(cloud)[0] == (1.0, 2.0, 3.0)
    assert point_cloud2.read_points_list(cloud)[2].z == 9.0
    dense = point_cloud2.read_points_numpy(cloud, ["z", "y"], skip_nans=True)
    assert dense.tolist() == [[3.0, 2.0], [9.0, 8.0]]
    assert point_cloud2.read_points(cloud, uvs=[2])["x"].tolist() == [7.0]
    assert point_cloud2.read_points(point_cloud2.create_cloud_xyz32(HEADER, [])).size == 0


def test_a_cloud_may_be_organized_padded_and_of_several_types():
    fields = [
        FIELD(name="x", offset=0, datatype=FIELD.FLOAT32, count=1),
        FIELD(name="ring", offset=4, datatype=FIELD.UINT16, count=2),
    ]
    values = np.arange(18).reshape(2, 3, 3)
    cloud = point_cloud2.create_cloud(HEADER, fields, values, point_step=16)
    assert (cloud.width, cloud.height, cloud.point_step, cloud.row_step) == (2, 3, 16, 32)
    points = point_cloud2.read_points(cloud, reshape_organized_cloud=True)
    assert points["ring_1"].tolist() == [[2, 5, 8], [11, 14, 17]]
    copied = point_cloud2.create_cloud(HEADER, fields, points, point_step=16)
    assert copied.data == cloud.data
    with pytest.raises(TeleopctlError, match="several types"):
        point_cloud2.read_points_numpy(cloud)
    with pytest.raises(TeleopctlError, match="no field intensity"):
        point_cloud2.read_points(cloud, ["intensity"])
    with pytest.raises(TeleopctlError, match="do not fit 3 fields"):
        point_cloud2.create_cloud(HEADER, fields, [(1.0, 2.0)])


@pytest.mark.parametrize(
    "angles", [(0.1, -0.2, 0.3), (3.0, 1.2, -2.0), (0.0, 0.0, math.pi), (-1.0, 0.5, 0.0)]
)
def test_angles_quaternions_and_matrices_are_the_same_rotation(angles):
    quaternion = tft.quaternion_from_euler(*angles)
    matrix = tft.euler_matrix(*angles)
    about = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    x, y, z = (
        tft.quaternion_matrix(tft.quaternion_about_axis(angle, axis))
        for angle, axis in zip(angles, about, strict=True)
    )
    assert matrix == pytest.approx(tft.concatenate_matrices(z, y, x))
    assert tft.quaternion_matrix(quaternion) == pytest.approx(matrix)
    assert tft.quaternion_matrix(tft.quaternion_from_matrix(matrix)) == pytest.approx(matrix)
    assert tft.euler_matrix(*tft.euler_from_quaternion(quaternion)) == pytest.approx(matrix)
    assert tft.euler_matrix(*tft.euler_from_matrix(matrix)) == pytest.approx(matrix)
    assert tft.inverse_matrix(matrix) @ matrix == pytest.approx(np.identity(4))
    undone = tft.quaternion_multiply(tft.quaternion_inverse(2 * quaternion), 2 * quaternion)
    assert undone == pytest.approx([0.0, 0.0, 0.0, 1.0])


def test_the_rest_of_the_rotations():
    half = tft.quaternion_about_axis(1.0, (0.0, 0.0, 2.0))
    assert tft.quaternion_slerp((0, 0, 0, 1), tft.quaternion_from_euler(0, 0, 2), 0.5) == (
        pytest.approx(half)
    )
    assert tft.quaternion_conjugate((1, 2, 3, 4)).tolist() == [-1.0, -2.0, -3.0, 4.0]
    moved = tft.concatenate_matrices(tft.translation_matrix((1, 2, 3)), np.identity(4))
    assert tft.translation_from_matrix(moved).tolist() == [1.0, 2.0, 3.0]
    for name in ("rzyw", "szz", "xyz", "szzx", "rxyzx"):
        with pytest.raises(TeleopctlError, match=f"'{name}' is no sequence of axes"):
            tft.quaternion_from_euler(0, 0, 0, name)


@pytest.mark.parametrize("axes", SEQUENCES)
@pytest.mark.parametrize("middle", [0.4, 0.0, math.pi / 2, -math.pi / 2, math.pi])
def test_angles_about_any_axes_are_turns_about_each(axes, middle):
    angles = (0.3, middle, -1.1)
    units = dict(zip("xyz", np.identity(3), strict=True))
    turns = [
        tft.rotation_matrix(angle, units[letter])
        for angle, letter in zip(angles, axes[1:], strict=True)
    ]
    # About axes that stand still, the turn that comes last stands first.
    ordered = turns[::-1] if axes[0] == "s" else turns
    matrix = tft.euler_matrix(*angles, axes)
    assert matrix == pytest.approx(tft.concatenate_matrices(*ordered))
    found = tft.euler_from_matrix(matrix, axes)
    assert tft.euler_matrix(*found, axes) == pytest.approx(matrix, abs=1e-6)


def test_matrices_are_made_and_taken_apart():
    random = np.random.default_rng(1)
    point, axis, angles = random.normal(size=(3, 3)) * 0.5
    turn = tft.rotation_matrix(2.5, axis, point)
    assert turn @ [*point, 1.0] == pytest.approx([*point, 1.0])
    assert tft.rotation_matrix(*tft.rotation_from_matrix(turn)) == pytest.approx(turn)
    half = tft.rotation_matrix(math.pi, (0, 0, 1))
    assert abs(tft.rotation_from_matrix(half)[1][2]) == pytest.approx(1.0)
    parts = ((-1.5, 0.5, 2.0), (0.1, -0.2, 0.3), angles, point, (0.1, 0.0, 0.2, 1.0))
    matrix = tft.compose_matrix(*parts)
    again = tft.compose_matrix(*tft.decompose_matrix(matrix))
    assert tft.is_same_transform(3.0 * matrix, again)
    assert not tft.is_same_transform(matrix, tft.identity_matrix())
    with pytest.raises(ValueError, match="singular"):
        tft.decompose_matrix(tft.scale_matrix(0.0))
    mirror = tft.reflection_matrix(point, axis)
    assert mirror @ mirror == pytest.approx(np.identity(4))
    assert mirror @ [*point, 1.0] == pytest.approx([*point, 1.0])
    points = random.normal(size=(3, 6))
    moved = 2.0 * turn[:3, :3] @ points + point[:, None]
    found = tft.superimposition_matrix(points, moved, scaling=True)
    assert found[:3, :3] @ points + found[:3, 3:] == pytest.approx(moved)
    assert tft.vector_norm(tft.unit_vector(points, axis=0), axis=0) == pytest.approx(np.ones(6))
    assert np.linalg.det(tft.random_rotation_matrix()) == pytest.approx(1.0)
    assert tft.random_vector(4).shape == (4,)


def test_points_of_other_types_than_the_fields_are_refused():
    fields = [FIELD(name="x", datatype=FIELD.FLOAT32, count=1)]
    for wrong in (np.zeros(2, [("x", "f8")]), np.zeros(2, [("y", "f4")])):
        with pytest.raises(AssertionError, match="do not fit the fields"):
            point_cloud2.create_cloud(HEADER, fields, wrong)
    padded = np.zeros(2, {"names": ["x"], "formats": ["f4"], "offsets": [0], "itemsize": 16})
    assert point_cloud2.create_cloud(HEADER, fields, padded, 16).point_step == 16


def camera(baseline=0.0):
    return CameraInfo(
        width=640,
        height=480,
        k=[430.0, 0.0, 310.0, 0.0, 430.0, 220.0, 0.0, 0.0, 1.0],
        p=[300.0, 0.0, 285.0, -300.0 * baseline, 0.0, 300.0, 223.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    )


def test_a_camera_model_takes_pixels_to_rays_and_back():
    model = PinholeCameraModel()
    model.fromCameraInfo(camera())
    x, y, z = model.projectPixelTo3dRay((100.0, 200.0))
    assert x * x + y * y + z * z == pytest.approx(1.0)
    assert model.project3dToPixel((x, y, z)) == pytest.approx((100.0, 200.0))
    assert model.getDeltaX(model.getDeltaU(0.2, 2.0), 2.0) == pytest.approx(0.2)
    assert model.fovX() == pytest.approx(2 * math.atan(320 / 300))
    binned = camera()
    binned.binning_x, binned.roi.x_offset, binned.roi.width = 2, 100, 100
    model.fromCameraInfo(binned)
    assert (model.fx(), model.cx(), model.fullProjectionMatrix()[0, 0]) == (150.0, 92.5, 300.0)


def test_a_stereo_model_finds_the_point_of_a_disparity():
    model = StereoCameraModel()
    model.fromCameraInfo(camera(), camera(baseline=0.1))
    point = model.projectPixelTo3d((16.0, 240.0), 5.0)
    assert point[2] == pytest.approx(model.getZ(5.0)) == pytest.approx(6.0)
    left, right = model.project3dToPixel(point)
    assert (*left, right[0]) == pytest.approx((16.0, 240.0, 11.0))
    assert model.getDisparity(6.0) == pytest.approx(5.0)
