"""``ros2_numpy.point_cloud2``. Point clouds as structured arrays."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from ros2_numpy.registry import converts_from_numpy, converts_to_numpy
from teleopctl.interfaces import get_message

if TYPE_CHECKING:
    from builtin_interfaces.msg import Time
    from sensor_msgs.msg import PointCloud2, PointField

DUMMY_FIELD_PREFIX = "__"

_CLOUD = get_message("sensor_msgs/msg/PointCloud2")
_FIELD = get_message("sensor_msgs/msg/PointField")

# The numbers of sensor_msgs/msg/PointField's constants, from 1.
_TYPES = [np.dtype(kind) for kind in ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")]

Points = npt.NDArray[Any]  # Any: structured, with the fields of the cloud


# Any: whatever numpy takes for a kind of numbers.
@converts_to_numpy(_FIELD, plural=True)
def fields_to_dtype(fields: "Sequence[PointField]", point_step: int) -> list[tuple[str, Any]]:
    """Return the description of a point as numpy's, bytes without a field named ``__offset``."""
    described: list[tuple[str, Any]] = []
    offset = 0

    def pad(end: int) -> None:
        described.extend((f"{DUMMY_FIELD_PREFIX}{at}", np.uint8) for at in range(offset, end))

    for field in fields:
        pad(field.offset)
        kind = _TYPES[field.datatype - 1]
        described.append(
            (field.name, kind if field.count == 1 else np.dtype((kind, (field.count,))))
        )
        offset = max(offset, field.offset) + kind.itemsize * field.count
    pad(point_step)
    return described


@converts_from_numpy(_FIELD, plural=True)
def dtype_to_fields(dtype: np.dtype[Any]) -> "list[PointField]":
    """Return numpy's description of a point as fields."""
    fields = []
    for name, (kind, offset, *_) in (dtype.fields or {}).items():
        count = int(np.prod(kind.shape))
        number = _TYPES.index(kind.base) + 1
        fields.append(_FIELD(name=name, offset=offset, datatype=number, count=count))
    return fields


@converts_to_numpy(_CLOUD)
def pointcloud2_to_array(cloud_msg: "PointCloud2", squeeze: bool = True) -> Points:
    """Return the points, (height, width); (width,) where the height is 1, unless not squeezed."""
    kind = np.dtype(fields_to_dtype(cloud_msg.fields, cloud_msg.point_step))
    order: Literal["<", ">"] = ">" if cloud_msg.is_bigendian else "<"
    points = np.frombuffer(cloud_msg.data, dtype=kind.newbyteorder(order))
    wanted = [name for name in kind.names or () if not name.startswith(DUMMY_FIELD_PREFIX)]
    flat = squeeze and cloud_msg.height == 1
    return points[wanted].reshape(
        (cloud_msg.width,) if flat else (cloud_msg.height, cloud_msg.width)
    )


@converts_from_numpy(_CLOUD)
def array_to_pointcloud2(
    cloud_arr: Points, stamp: "Time | None" = None, frame_id: str | None = None
) -> "PointCloud2":
    """Return a structured array, of one dimension or (height, width), as a cloud."""
    points = np.ascontiguousarray(np.atleast_2d(cloud_arr))
    height, width = points.shape
    cloud: PointCloud2 = _CLOUD(
        height=height,
        width=width,
        fields=dtype_to_fields(points.dtype),
        is_bigendian=False,
        point_step=points.dtype.itemsize,
        row_step=points.dtype.itemsize * width,
        is_dense=all(bool(np.isfinite(points[name]).all()) for name in points.dtype.names or ()),
        data=points.astype(points.dtype.newbyteorder("<")).tobytes(),
    )
    if stamp is not None:
        cloud.header.stamp = stamp
    if frame_id is not None:
        cloud.header.frame_id = frame_id
    return cloud


def merge_rgb_fields(cloud_arr: Points) -> Points:
    """Put the fields r, g and b (uint8) into one field rgb, a float32 of their bits, as PCL has."""
    red, green, blue = (np.asarray(cloud_arr[name], dtype=np.uint32) for name in "rgb")
    others = [name for name in cloud_arr.dtype.names or () if name not in ("r", "g", "b")]
    merged = np.zeros(
        cloud_arr.shape, [*((name, cloud_arr.dtype[name]) for name in others), ("rgb", np.float32)]
    )
    for name in others:
        merged[name] = cloud_arr[name]
    merged["rgb"] = ((red << 16) | (green << 8) | blue).view(np.float32)
    return merged


def split_rgb_field(cloud_arr: Points) -> Points:
    """Take the field rgb, a float32 of bits, apart into the fields r, g and b (uint8)."""
    bits = np.ascontiguousarray(cloud_arr["rgb"]).view(np.uint32)
    others = [name for name in cloud_arr.dtype.names or () if name != "rgb"]
    split = np.zeros(
        cloud_arr.shape,
        [
            *((name, cloud_arr.dtype[name]) for name in others),
            *((name, np.uint8) for name in "rgb"),
        ],
    )
    for name in others:
        split[name] = cloud_arr[name]
    for name, shift in (("r", 16), ("g", 8), ("b", 0)):
        split[name] = (bits >> shift) & 255
    return split


def get_xyz_points(
    cloud_array: Points, remove_nans: bool = True, dtype: npt.DTypeLike = np.float64
) -> Points:
    """Return x, y and z in the last dimension, by default only of points that have all three."""
    if remove_nans:
        finite = [np.isfinite(cloud_array[axis]) for axis in "xyz"]
        cloud_array = cloud_array[np.all(finite, axis=0)]
    return np.stack([cloud_array[axis] for axis in "xyz"], axis=-1).astype(dtype)


def pointcloud2_to_xyz_array(cloud_msg: "PointCloud2", remove_nans: bool = True) -> Points:
    """Return x, y and z of the points of a cloud; see `get_xyz_points`."""
    return get_xyz_points(pointcloud2_to_array(cloud_msg), remove_nans=remove_nans)
