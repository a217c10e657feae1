"""Messages with invalid and extreme values, for tests of displays."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from teleopctl.interfaces import get_message

# Any stands for messages: their classes are made at run time, from definitions.

FLOATS = (0.0, -0.0, math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 1e10, -1e38, 2.0, -1.0)
TEXTS = (
    *("", "map", "base", "shoulder", "finger"),
    *("/map", "ghost", "a/b", "\0", "\x1b[31mred\n", "x" * 3000, "<b>", "図"),
    *("rgb8", "mono16", "32FC1", "8UC4", "bayer_rggb8", "yuv422", "jpeg", "png", "x y z"),
    *("file:///nowhere.stl", "package://nobody/a.dae", "http://h/a.obj", "embedded://a.glb"),
)

STATE = {
    "joint_state": "sensor_msgs/msg/JointState",
    "multi_dof_joint_state": "sensor_msgs/msg/MultiDOFJointState",
}
OBJECT: dict[str, Any] = {
    "type": {"key": "string", "db": "string"},
    "header": "std_msgs/msg/Header",
    "pose": "geometry_msgs/msg/Pose",
    "id": "string",
    "primitives": "sequence<shape_msgs/SolidPrimitive>",
    "primitive_poses": "sequence<geometry_msgs/Pose>",
    "meshes": "sequence<shape_msgs/Mesh>",
    "mesh_poses": "sequence<geometry_msgs/Pose>",
    "planes": "sequence<shape_msgs/Plane>",
    "plane_poses": "sequence<geometry_msgs/Pose>",
    "operation": "octet",
}
ROBOT_STATE = {
    **STATE,
    "attached_collision_objects": [{"link_name": "string", "object": OBJECT}],
    "is_diff": "boolean",
}
# Types of packages that may not be installed.
OTHERS: dict[str, dict[str, Any]] = {
    "nav2_msgs/msg/ParticleCloud": {
        "header": "std_msgs/msg/Header",
        "particles": [{"pose": "geometry_msgs/msg/Pose", "weight": "double"}],
    },
    "map_msgs/msg/OccupancyGridUpdate": {
        "header": "std_msgs/msg/Header",
        **dict.fromkeys(("x", "y"), "int32"),
        **dict.fromkeys(("width", "height"), "uint32"),
        "data": "sequence<int8>",
    },
    "moveit_msgs/msg/DisplayRobotState": {"state": ROBOT_STATE, "hide": "boolean"},
    "moveit_msgs/msg/DisplayTrajectory": {
        "model_id": "string",
        "trajectory": [{"joint_trajectory": "trajectory_msgs/msg/JointTrajectory"}],
        "trajectory_start": ROBOT_STATE,
    },
    "moveit_msgs/msg/PlanningScene": {
        "is_diff": "boolean",
        "robot_state": ROBOT_STATE,
        "object_colors": [{"id": "string", "color": "std_msgs/msg/ColorRGBA"}],
        "world": {
            "collision_objects": [OBJECT],
            "octomap": {"octomap": {"data": "sequence<int8>"}},
        },
    },
}


class Absurd:
    """Generator of messages with invalid and extreme values, the same for the same seed.

    Args:
        seed: Seed of the random generator.
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        # Share of extreme values in a message: some faults show only among ordinary values.
        self._share = self._random.choice((0.0, 0.03, 0.3, 1.0))

    def message(self, type_name: str) -> Any:
        """Return a message of a type with random values."""
        if type_name in OTHERS:
            return self._value(OTHERS[type_name])
        made = get_message(type_name)()
        for name, kind in made.get_fields_and_field_types().items():
            setattr(made, name, self._value(kind, getattr(made, name)))
        return made

    # Any: the type of a field, and the field's value.
    def _value(self, kind: Any, default: Any = None) -> Any:
        if isinstance(kind, Mapping):
            return SimpleNamespace(**{name: self._value(one) for name, one in kind.items()})
        if isinstance(kind, list):
            return [self._value(kind[0]) for _ in range(self._count())]
        if kind.startswith("sequence<"):
            inner, _, most = kind[9:-1].partition(",")
            return self._sequence(inner, min(self._count(), int(most or 9)))
        if kind.endswith("]"):
            inner = kind.rpartition("[")[0]
            values = [self._value(inner) for _ in range(len(default))]
            return np.array(values, default.dtype) if hasattr(default, "dtype") else values
        if "/" in kind:
            name = kind if kind.count("/") == 2 else kind.replace("/", "/msg/")
            return self.message(name)
        return self._number_or_text(kind)

    def _count(self) -> int:
        return self._random.choice((0, 1, 2, 3, 5))

    def _sequence(self, inner: str, count: int) -> Any:
        if inner in ("uint8", "octet", "byte"):
            return self._random.randbytes(self._random.choice((0, 1, 16, 300)))
        if "/" not in inner and not inner.startswith("string"):
            kinds = {"double": "f8", "float": "f4", "boolean": "?"}
            kind = kinds.get(inner) or np.dtype(inner)
            values = [self._number_or_text(inner) for _ in range(count)]
            return np.array(values, kind)
        return [self._value(inner) for _ in range(count)]

    def _number_or_text(self, kind: str) -> Any:
        absurd = self._random.random() < self._share
        if kind in ("double", "float"):
            value = self._random.choice(FLOATS) if absurd else self._random.uniform(-2.0, 2.0)
            with np.errstate(over="ignore"):
                return value if kind == "double" else float(np.float32(value))
        if kind == "boolean":
            return self._random.random() < 0.5
        if kind in ("octet", "byte", "char"):
            return bytes([self._random.choice((0, 1, 2, 3, 255))])
        if kind.startswith(("string", "wstring")):
            return self._random.choice(TEXTS) if absurd else self._random.choice(TEXTS[:5])
        info = np.iinfo(kind)
        extremes = (info.min, info.max, info.max // 2, 255 % (info.max + 1))
        return self._random.choice(extremes) if absurd else self._random.randrange(13)


class WithoutNumbers(Absurd):
    """Generator of messages with two elements per sequence and NaN in every float field."""

    def __init__(self) -> None:
        super().__init__(0)

    def _count(self) -> int:
        return 2

    def _number_or_text(self, kind: str) -> Any:
        if kind in ("double", "float"):
            return math.nan
        if kind in ("octet", "byte", "char"):
            return b"\0"
        if kind == "boolean":
            return False
        return "map" if kind.startswith(("string", "wstring")) else 0
