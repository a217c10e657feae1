"""``sensor_msgs_py.point_cloud2``: the points of clouds as numpy arrays and back."""

from __future__ import annotations

import collections
import sys
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidMessageError
from teleopctl.interfaces import get_message

Points = npt.NDArray[Any]

# The numbers of sensor_msgs/msg/PointField's constants.
_TYPES: dict[int, np.dtype[Any]] = {
    1: np.dtype("i1"),
    2: np.dtype("u1"),
    3: np.dtype("i2"),
    4: np.dtype("u2"),
    5: np.dtype("i4"),
    6: np.dtype("u4"),
    7: np.dtype("f4"),
    8: np.dtype("f8"),
}
_FLOAT32 = 7


class PointTypesError(InvalidMessageError, AssertionError):
    """Raised when points have other types than required; sensor_msgs_py asserts that."""


# Any, here and below: PointCloud2, PointField and Header, or what has their fields.
def dtype_from_fields(fields: Iterable[Any], point_step: int | None = None) -> np.dtype[Any]:
    """Return numpy's type of a point.

    Args:
        fields: ``sensor_msgs/msg/PointField`` messages; a field of several numbers becomes one
            column each, ``name_0`` and so on.
        point_step: Bytes of a point; as many as the fields take if None.
    """
    names, offsets, formats = [], [], []
    for index, field in enumerate(fields):
        kind = _TYPES[field.datatype]
        name = field.name or f"unnamed_field_{index}"
        for part in range(field.count):
            names.append(name if field.count == 1 else f"{name}_{part}")
            offsets.append(field.offset + part * kind.itemsize)
            formats.append(kind)
    layout: Any = {"names": names, "offsets": offsets, "formats": formats}
    if point_step is not None:
        layout["itemsize"] = point_step
    point: np.dtype[Any] = np.dtype(layout)
    return point


def read_points(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[int] | None = None,
    reshape_organized_cloud: bool = False,
) -> Points:
    """Return the points of a cloud as a structured array.

    Args:
        cloud: A ``sensor_msgs/msg/PointCloud2``.
        field_names: The fields to read; all if None.
        skip_nans: Leave points out that have a NaN.
        uvs: The indices of the points to read; all if None.
        reshape_organized_cloud: Give the array two dimensions where the cloud is organized: its
            width and its height, in this order, as `create_cloud` takes it.

    Raises:
        InvalidMessageError: The cloud has no such field, or its rows are padded.
    """
    kind = dtype_from_fields(cloud.fields, cloud.point_step)
    if cloud.height > 1 and cloud.row_step != cloud.width * cloud.point_step:
        raise InvalidMessageError("the rows of the point cloud are padded, which cannot be read")
    points: Points = np.frombuffer(cloud.data, dtype=kind, count=cloud.width * cloud.height)
    if bool(sys.byteorder == "little") == bool(cloud.is_bigendian):
        points = points.byteswap()
    if field_names is not None:
        if missing := [name for name in field_names if name not in (kind.names or ())]:
            raise InvalidMessageError(
                f"the point cloud has no field {', '.join(missing)}",
                hint=f"It has {', '.join(kind.names or ())}.",
            )
        points = points[list(field_names)]
    if skip_nans and not cloud.is_dense:
        columns = [points[name] for name in points.dtype.names or ()]
        points = points[~np.any([np.isnan(column) for column in columns], axis=0)]
    if uvs is not None:
        points = points[np.fromiter(uvs, np.int64)]
    if reshape_organized_cloud and cloud.height > 1:
        points = points.reshape(cloud.width, cloud.height)
    return points


def read_points_numpy(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[int] | None = None,
    reshape_organized_cloud: bool = False,
) -> Points:
    """Return the points as a plain array, a column for each field; all are of one type.

    Raises:
        InvalidMessageError: As `read_points`.
        PointTypesError: The fields are of several types.
    """
    points = read_points(cloud, field_names, skip_nans, uvs, reshape_organized_cloud)
    columns = [points[name] for name in points.dtype.names or ()]
    if len({column.dtype for column in columns}) > 1:
        raise PointTypesError(
            "the fields of the point cloud are of several types", hint="Name those of one type."
        )
    return np.stack(columns, axis=-1)


def read_points_list(
    cloud: Any,
    field_names: Sequence[str] | None = None,
    skip_nans: bool = False,
    uvs: Iterable[int] | None = None,
) -> list[Any]:
    """Return the points as a list of named tuples."""
    points = read_points(cloud, field_names, skip_nans, uvs)
    point = collections.namedtuple("Point", points.dtype.names or ())  # type: ignore[misc]
    return [point(*values) for values in points.tolist()]


def create_cloud(
    header: Any, fields: Sequence[Any], points: Any, point_step: int | None = None
) -> Any:
    """Return points as a ``sensor_msgs/msg/PointCloud2``.

    Args:
        header: Its header.
        fields: Its ``sensor_msgs/msg/PointField`` messages.
        points: A structured array, or an array or lists with the values of a point in the last
            dimension; with two more dimensions, width and height, the cloud is organized.
        point_step: Bytes of a point; as many as the fields take if None.

    Raises:
        InvalidMessageError: The points have another number of values than there are fields.
        PointTypesError: The array is a structured one, of other types than the fields.
    """
    kind = dtype_from_fields(fields, point_step)
    names = kind.names or ()
    given = points if isinstance(points, np.ndarray) else np.array(list(points))
    if given.dtype.names is None:
        given = given.reshape(-1, len(names)) if given.size == 0 else given
        if given.ndim < 2 or given.shape[-1] != len(names):
            raise InvalidMessageError(
                f"points of shape {given.shape} do not fit {len(names)} fields ({', '.join(names)})"
            )
        filled = np.zeros(given.shape[:-1], dtype=kind)
        for index, name in enumerate(names):
            filled[name] = given[..., index]
    else:
        if given.dtype != kind:
            raise PointTypesError(
                f"points of type {given.dtype} do not fit the fields, which are {kind}"
            )
        filled = given
    width, height = filled.shape if filled.ndim == 2 else (filled.shape[0], 1)
    return get_message("sensor_msgs/msg/PointCloud2")(
        header=header,
        height=height,
        width=width,
        fields=list(fields),
        is_bigendian=sys.byteorder == "big",
        point_step=kind.itemsize,
        row_step=kind.itemsize * width,
        data=filled.tobytes(),
        is_dense=False,
    )


def create_cloud_xyz32(header: Any, points: Any) -> Any:
    """Return points of x, y and z as a ``sensor_msgs/msg/PointCloud2`` of 32-bit floats."""
    field = get_message("sensor_msgs/msg/PointField")
    fields = [
        field(name=name, offset=4 * index, datatype=_FLOAT32, count=1)
        for index, name in enumerate("xyz")
    ]
    return create_cloud(header, fields, points)
