"""Node parameters for sensors (``seed``, ``gps_origin``) and root link (``fixed_base`` …)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message
from teleopctl.robot import Pose
from teleopctl.sim.request_numbers import invalid_number_reason

if TYPE_CHECKING:
    from teleopctl.node import Node, Parameter

# Default of ``gps_origin``: the origin in the world's file counts.
_UNSET = [0.0] * 3
_FIXED_BASE = {"auto": None, "true": True, "false": False}


class SensorSettings(TypedDict):
    """Keyword arguments of `simulate` for sensors: noise seed and GPS origin."""

    seed: int
    gps_origin: Sequence[float]


def declare_sensor_settings(node: Node) -> None:
    """Declare the parameters ``seed`` and ``gps_origin`` on a node."""
    at_start = get_message("rcl_interfaces/msg/ParameterDescriptor")(read_only=True)
    node.declare_parameter("seed", 0, at_start)
    node.declare_parameter("gps_origin", _UNSET, at_start)


def sensor_settings(node: Node) -> SensorSettings:
    """Return a node's parameters ``seed`` and ``gps_origin`` for `simulate`; raise if invalid.

    Raises:
        InvalidParameterError: A value is invalid.
    """
    seed = node.get_parameter("seed").value
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise InvalidParameterError(f"Parameter 'seed' is '{seed}', expected a whole number")
    origin = float_list_parameter(node, "gps_origin", "latitude", "longitude", "altitude")
    return SensorSettings(seed=seed, gps_origin=() if origin == _UNSET else origin)


class BaseSettings(TypedDict):
    """Keyword arguments of `build_model` for the robot's root link."""

    fixed_base: bool | None
    spawn_pose: Pose


def declare_base_settings(node: Node) -> None:
    """Declare the parameters ``fixed_base`` and ``spawn_pose`` on a node."""
    descriptor = get_message("rcl_interfaces/msg/ParameterDescriptor")
    node.declare_parameter("fixed_base", "auto", descriptor(read_only=True, dynamic_typing=True))
    node.declare_parameter("spawn_pose", [0.0] * 6, descriptor(read_only=True))


def base_settings(node: Node) -> BaseSettings:
    """Return a node's ``fixed_base`` and ``spawn_pose`` for `build_model`; raise if invalid.

    Raises:
        InvalidParameterError: A value is invalid.
    """
    x, y, z, *rpy = float_list_parameter(node, "spawn_pose", "x", "y", "z", "roll", "pitch", "yaw")
    pose = Pose((x, y, z), (rpy[0], rpy[1], rpy[2]))
    fixed = read_fixed_base(node.get_parameter("fixed_base").value)
    return BaseSettings(fixed_base=fixed, spawn_pose=pose)


def read_fixed_base(value: object) -> bool | None:
    """Return a value of ``fixed_base`` as a bool, or None for ``auto``; raise for other values.

    Raises:
        InvalidParameterError: The value is none of these.
    """
    text = str(value).lower()
    if text not in _FIXED_BASE:
        raise InvalidParameterError(
            f"Parameter 'fixed_base' is '{value}', expected true, false or auto"
        )
    return _FIXED_BASE[text]


def float_list_parameter(node: Node, name: str, *parts: str) -> list[float]:
    """Return a node's list parameter as floats; raise unless it has one finite number per part.

    Args:
        node: The node.
        name: Name of the parameter.
        parts: Names of the numbers, for error messages.

    Raises:
        InvalidParameterError: The parameter is not a list of one finite number per part.
    """
    return checked_numbers(node.get_parameter(name), *parts)


def checked_numbers(parameter: Parameter, *parts: str) -> list[float]:
    """Return a list parameter, possibly not set yet, as floats; raise unless one number per part.

    Raises:
        InvalidParameterError: The parameter is not a list of one finite number per part.
    """
    values = parameter.value
    fits = not isinstance(values, str) and isinstance(values, Sequence)
    if not (
        fits
        and len(values) == len(parts)
        and all(isinstance(value, int | float) for value in values)
    ):
        expected = f"{', '.join(parts[:-1])} and {parts[-1]}"
        raise InvalidParameterError(
            f"Parameter '{parameter.name}' is {values}, expected {expected}"
        )
    if reason := invalid_number_reason(values):
        raise InvalidParameterError(
            f"Parameter '{parameter.name}' is {values}: a number of it {reason}"
        )
    return [float(value) for value in values]
