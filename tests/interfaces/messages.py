"""Hypothesis strategies that make messages of any type."""

import string
import struct
from random import Random
from typing import Any

from hypothesis import strategies as st

from teleopctl.interfaces.definition import INTEGER_RANGES, FieldType, Shape
from teleopctl.interfaces.store import get_message

REPRESENTATIVE_TYPES = (
    "action_msgs/msg/GoalStatusArray",
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/TransformStamped",
    "rcl_interfaces/msg/ParameterEvent",
    "rcl_interfaces/msg/ParameterDescriptor",
    "sensor_msgs/msg/BatteryState",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
    "service_msgs/msg/ServiceEventInfo",
    "shape_msgs/msg/Mesh",
    "shape_msgs/msg/SolidPrimitive",
    "std_msgs/msg/Byte",
    "std_msgs/msg/ByteMultiArray",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Float32MultiArray",
    "std_msgs/msg/Int16",
    "std_msgs/msg/String",
    "std_msgs/msg/UInt64MultiArray",
    "tf2_msgs/msg/TFMessage",
    "trajectory_msgs/msg/JointTrajectory",
    "type_description_interfaces/msg/TypeDescription",
    "visualization_msgs/msg/Marker",
)

_TEXT = st.text(
    st.one_of(
        st.sampled_from(string.printable), st.characters(codec="utf-8", exclude_characters="\0")
    ),
    max_size=12,
)


def _single(kind: FieldType, allow_nan: bool) -> st.SearchStrategy[Any]:
    if kind.base in INTEGER_RANGES:
        return st.integers(*INTEGER_RANGES[kind.base])
    match kind.base:
        case "float32":
            return st.floats(width=32, allow_nan=allow_nan)
        case "float64":
            return st.floats(allow_nan=allow_nan)
        case "bool":
            return st.booleans()
        case "byte":
            return st.binary(min_size=1, max_size=1)
        case "string" | "wstring":
            return _TEXT.map(lambda text: text[: kind.string_capacity or None])
    return messages(kind.base, allow_nan)


def _values(kind: FieldType, allow_nan: bool) -> st.SearchStrategy[Any]:
    single = _single(kind.element, allow_nan)
    match kind.shape:
        case Shape.SINGLE:
            return single
        case Shape.ARRAY:
            return st.lists(single, min_size=kind.capacity, max_size=kind.capacity)
        case Shape.BOUNDED:
            return st.lists(single, max_size=min(kind.capacity, 3))
    return st.lists(single, max_size=3)


def messages(type_name: str, allow_nan: bool = False) -> st.SearchStrategy[Any]:
    """Return a strategy for messages of one type."""
    cls = get_message(type_name)
    fields = {f.attribute: _values(f.type, allow_nan) for f in cls.__definition__.fields}
    return st.fixed_dictionaries(fields).map(lambda values: cls(**values))


def any_message(allow_nan: bool = False) -> st.SearchStrategy[Any]:
    """Return a strategy for messages of the representative types."""
    return st.sampled_from(REPRESENTATIVE_TYPES).flatmap(
        lambda type_name: messages(type_name, allow_nan)
    )


def string_cdr(text: bytes) -> bytes:
    """Return ``std_msgs/msg/String`` as CDR, made by hand."""
    return b"\0\1\0\0" + struct.pack("<I", len(text) + 1) + text + b"\0"


_ODD_FLOATS = (0.0, -0.0, float("inf"), -float("inf"))


def random_message(source: Random, type_name: str) -> Any:
    """Return a message of one type with random values; quicker than a strategy."""
    cls = get_message(type_name)
    fields = {f.attribute: _random_values(source, f.type) for f in cls.__definition__.fields}
    return cls(**fields)


def _random_values(source: Random, kind: FieldType) -> Any:
    if kind.shape is Shape.SINGLE:
        return _random_single(source, kind)
    count = source.choice((0, 0, 1, 2, 3))
    if kind.shape is not Shape.UNBOUNDED:
        count = kind.capacity if kind.shape is Shape.ARRAY else min(count, kind.capacity)
    return [_random_single(source, kind.element) for _ in range(count)]


def _random_single(source: Random, kind: FieldType) -> Any:
    if kind.base in INTEGER_RANGES:
        least, most = INTEGER_RANGES[kind.base]
        return source.choice((least, most, source.randint(least, most)))
    match kind.base:
        case "float32":
            value = source.choice((*_ODD_FLOATS, 2.0**-149, source.uniform(-1e6, 1e6)))
            return struct.unpack("<f", struct.pack("<f", value))[0]
        case "float64":
            return source.choice((*_ODD_FLOATS, 5e-324, source.uniform(-1e300, 1e300)))
        case "bool":
            return source.random() < 0.5
        case "byte":
            return source.randbytes(1)
        case "string" | "wstring":
            return "aé🦾 \n"[: source.randint(0, kind.string_capacity or 5)]
    return random_message(source, kind.base)
