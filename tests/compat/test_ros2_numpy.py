"""ros2_numpy: messages as arrays and back, held to numbers."""

import math

import numpy as np
import pytest
import ros2_numpy
from ros2_numpy.point_cloud2 import (
    get_xyz_points,
    merge_rgb_fields,
    pointcloud2_to_xyz_array,
    split_rgb_field,
)
from sensor_msgs_py.point_cloud2 import read_points

from teleopctl.interfaces import get_message

VECTOR, POINT, QUATERNION, TRANSFORM, POSE = (
    get_message(f"geometry_msgs/msg/{name}")
    for name in ("Vector3", "Point", "Quaternion", "Transform", "Pose")
)
IMAGE, CLOUD, FIELD = (
    get_message(f"sensor_msgs/msg/{name}") for name in ("Image", "PointCloud2", "PointField")
)
GRID, INFO = (get_message(f"nav_msgs/msg/{name}") for name in ("OccupancyGrid", "MapMetaData"))
HALF = math.sqrt(0.5)


def test_points_and_vectors_have_their_homogeneous_coordinate():
    assert ros2_numpy.numpify(POINT(x=1.0, y=2.0, z=3.0)).tolist() == [1, 2, 3]
    assert ros2_numpy.numpify(POINT(x=1.0, y=2.0, z=3.0), hom=True).tolist() == [1, 2, 3, 1]
    assert ros2_numpy.numpify(VECTOR(x=1.0, y=2.0, z=3.0), hom=True).tolist() == [1, 2, 3, 0]
    assert ros2_numpy.msgify(POINT, np.array([2.0, 4.0, 6.0, 2.0])) == POINT(x=1.0, y=2.0, z=3.0)
    assert ros2_numpy.msgify(VECTOR, np.array([2, 4, 6, 0])) == VECTOR(x=2.0, y=4.0, z=6.0)
    with pytest.raises(AssertionError):
        ros2_numpy.msgify(VECTOR, np.array([2, 4, 6, 1]))


def test_an_array_of_points_is_an_array_of_messages():
    made = ros2_numpy.msgify(POINT, np.arange(12.0).reshape(2, 2, 3))
    assert made.shape == (2, 2)
    assert made[1, 0] == POINT(x=6.0, y=7.0, z=8.0)


@pytest.mark.parametrize(("kind", "move", "turn"), [(TRANSFORM, 0, 1), (POSE, 0, 1)])
def test_a_frame_is_the_matrix_that_takes_its_points_to_the_parent(kind, move, turn):
    names = list(kind.get_fields_and_field_types())
    parts = {names[move]: (VECTOR if kind is TRANSFORM else POINT)(x=1.0, y=2.0, z=3.0)}
    frame = kind(**parts, **{names[turn]: QUATERNION(z=HALF, w=HALF)})
    matrix = ros2_numpy.numpify(frame)
    assert matrix @ [1, 0, 0, 1] == pytest.approx([1, 3, 3, 1])
    back = ros2_numpy.msgify(kind, matrix)
    assert ros2_numpy.numpify(getattr(back, names[turn])) == pytest.approx([0, 0, HALF, HALF])
    assert ros2_numpy.numpify(getattr(back, names[move])).tolist() == [1, 2, 3]
    both = ros2_numpy.msgify(kind, np.stack([matrix, np.eye(4)]))
    assert ros2_numpy.numpify(both[1]).tolist() == np.eye(4).tolist()


def test_an_image_is_its_pixels_without_the_padding_of_its_rows():
    image = IMAGE(height=2, width=1, encoding="bgr8", step=4, data=bytes([1, 2, 3, 9, 4, 5, 6, 9]))
    assert ros2_numpy.numpify(image).tolist() == [[[1, 2, 3]], [[4, 5, 6]]]
    depth = np.array([[0.5, 1.5, 2.5]], dtype=np.float32)
    made = ros2_numpy.msgify(IMAGE, depth, encoding="32FC1")
    assert (made.height, made.width, made.step, made.encoding) == (1, 3, 12, "32FC1")
    assert ros2_numpy.numpify(made).tolist() == [[0.5, 1.5, 2.5]]
    big = IMAGE(height=1, width=1, encoding="mono16", step=2, is_bigendian=1, data=b"\1\0")
    assert ros2_numpy.numpify(big).tolist() == [[256]]


@pytest.mark.parametrize(
    ("shape", "kind", "encoding"),
    [((2, 2), "u1", "rgb8"), ((2, 2), "f4", "mono8"), ((2, 2), "u1", "no"), ((2,), "u1", "mono8")],
)
def test_pixels_that_are_not_of_the_encoding_are_refused(shape, kind, encoding):
    with pytest.raises(TypeError):
        ros2_numpy.msgify(IMAGE, np.zeros(shape, kind), encoding)


def test_unknown_cells_of_a_map_are_masked():
    grid = GRID(data=[0, 100, -1, 50, 0, 0], info=INFO(width=3, height=2, resolution=0.05))
    cells = ros2_numpy.numpify(grid)
    assert cells.shape == (2, 3)
    assert cells.mask.tolist() == [[False, False, True], [False, False, False]]
    assert cells.sum() == 150
    cells[1, 2] = np.ma.masked
    back = ros2_numpy.msgify(GRID, cells, info=grid.info)
    assert list(back.data) == [0, 100, -1, 50, 0, -1]
    assert (back.info.width, back.info.height) == (3, 2)
    assert back.info.resolution == pytest.approx(0.05)
    for wrong in (np.zeros(3, np.int8), np.zeros((3, 3))):
        with pytest.raises(TypeError):
            ros2_numpy.msgify(GRID, wrong)


def points():
    kind = [("x", "f4"), ("y", "f4"), ("z", "f4"), ("r", "u1"), ("g", "u1"), ("b", "u1")]
    return np.array([(1, 2, 3, 10, 20, 30), (4, np.nan, 6, 40, 50, 60)], dtype=kind)


def test_a_cloud_is_a_structured_array():
    cloud = ros2_numpy.msgify(CLOUD, points(), frame_id="lidar")
    assert (cloud.height, cloud.width, cloud.point_step, cloud.row_step) == (1, 2, 15, 30)
    assert (cloud.header.frame_id, cloud.is_dense) == ("lidar", False)
    assert [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields][2:4] == [
        ("z", 8, FIELD.FLOAT32, 1),
        ("r", 12, FIELD.UINT8, 1),
    ]
    assert read_points(cloud)["x"].tolist() == [1, 4]  # as another reader has it
    back = ros2_numpy.numpify(cloud)
    assert back.shape == (2,)
    assert ros2_numpy.numpify(cloud, squeeze=False).shape == (1, 2)
    for name in ("x", "z", "b"):
        assert back[name].tolist() == points()[name].tolist()
    assert pointcloud2_to_xyz_array(cloud).tolist() == [[1, 2, 3]]
    assert get_xyz_points(back, remove_nans=False).shape == (2, 3)


def test_gaps_and_fields_of_several_numbers_are_kept_apart():
    fields = [
        FIELD(name="a", offset=1, datatype=FIELD.UINT8, count=1),
        FIELD(name="v", offset=4, datatype=FIELD.UINT16, count=2),
    ]
    cloud = CLOUD(height=1, width=1, fields=fields, point_step=9, data=bytes(range(9)))
    read = ros2_numpy.numpify(cloud)
    assert read.dtype.names == ("a", "v")
    assert (read["a"].tolist(), read["v"].tolist()) == ([1], [[0x0504, 0x0706]])
    cloud.is_bigendian = True
    assert ros2_numpy.numpify(cloud)["v"].tolist() == [[0x0405, 0x0607]]
    described = ros2_numpy.numpify(fields, point_step=9)
    kind = np.dtype(described)
    assert kind.itemsize == 9
    made = ros2_numpy.msgify(FIELD, kind, plural=True)
    assert [field for field in made if not field.name.startswith("__")] == fields


def test_colours_are_packed_as_pcl_has_them():
    merged = merge_rgb_fields(points())
    assert merged.dtype.names == ("x", "y", "z", "rgb")
    assert merged["rgb"].view(np.uint32).tolist() == [0x0A141E, 0x28323C]
    split = split_rgb_field(merged)
    assert [split[name].tolist() for name in "rgb"] == [[10, 40], [20, 50], [30, 60]]
    assert split["z"].tolist() == [3, 6]


def test_what_has_no_conversion_is_told():
    assert ros2_numpy.numpify(None) is None
    with pytest.raises(ValueError, match=r"Unable to convert message int - only supports .*Image"):
        ros2_numpy.numpify(3)
    with pytest.raises(ValueError, match="empty Collection"):
        ros2_numpy.numpify([])
    with pytest.raises(ValueError, match=r"Unable to build message PointField .* PointField\[\]"):
        ros2_numpy.msgify(FIELD, np.zeros(1))
