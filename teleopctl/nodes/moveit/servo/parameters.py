"""Parameters of ``servo_node``, with MoveIt Servo's names, defaults and ranges."""

from __future__ import annotations

import math
from typing import Any

from teleopctl.errors import InvalidParameterError
from teleopctl.interfaces import get_message
from teleopctl.kinematics import ServoSettings, Thresholds
from teleopctl.node import Node, Parameter

PREFIX = "moveit_servo"
"""Namespace in which MoveIt's launch files set servo's parameters."""
TASKS = ("auto", "position", "axis", "pose")

_AT_START = {
    "publish_period": 0.01,
    "max_expected_latency": 0.1,
    "move_group_name": "",
    "pose_command_in_topic": "~/pose_target_cmds",
    "cartesian_command_in_topic": "~/delta_twist_cmds",
    "joint_command_in_topic": "~/delta_joint_cmds",
    "status_topic": "~/status",
    "command_out_topic": "",
    "command_out_type": "",
    "joint_topic": "/joint_states",
    "task": "auto",
    "needs_arm": True,
}
_AT_RUNTIME: dict[str, Any] = {
    "command_in_type": "unitless",
    "scale.linear": 0.4,
    "scale.rotational": 0.8,
    "scale.joint": 0.5,
    "incoming_command_timeout": 0.1,
    "apply_twist_commands_about_ee_frame": True,
    "pose_tracking.linear_tolerance": 0.001,
    "pose_tracking.angular_tolerance": 0.01,
    "publish_joint_positions": True,
    "publish_joint_velocities": True,
    "check_collisions": True,
    "self_collision_proximity_threshold": 0.01,
    "scene_collision_proximity_threshold": 0.02,
    "lower_singularity_threshold": 17.0,
    "hard_stop_singularity_threshold": 30.0,
    "halt_all_joints_in_joint_mode": True,
    "halt_all_joints_in_cartesian_mode": True,
    "joint_limit_margins": [0.1],
}
# Parameters of MoveIt Servo that have no effect here, and why.
_WITHOUT_EFFECT = {
    "thread_priority": "the loop has the priority of its process",
    "active_subgroup": "set move_group_name to the group",
    "publish_joint_accelerations": "controllers take positions and velocities",
    "monitored_planning_scene_topic": "the scene of a move_group is followed, if one runs",
    "check_octomap_collisions": "there is no octomap",
    "is_primary_planning_scene_monitor": "there is no planning scene monitor",
    "use_smoothing": "each step keeps the joints' acceleration limits instead",
    "smoothing_filter_plugin_name": "each step keeps the joints' acceleration limits instead",
    "collision_check_rate": "collisions are checked in every step",
    "leaving_singularity_threshold_multiplier": "leaving a singularity is not slowed down",
    "singularity_step_scale": "the derivative of the Jacobian is used instead",
    "override_velocity_scaling_factor": "speeds are not overridden",
}
_CHOICES = {
    "command_in_type": ("unitless", "speed_units"),
    "command_out_type": ("", "trajectory_msgs/JointTrajectory", "std_msgs/Float64MultiArray"),
    "task": TASKS,
}
_POSITIVE = {
    *("publish_period", "pose_tracking.linear_tolerance", "pose_tracking.angular_tolerance"),
    *("lower_singularity_threshold", "hard_stop_singularity_threshold"),
    *("self_collision_proximity_threshold", "scene_collision_proximity_threshold"),
    *("incoming_command_timeout", "scale.linear", "scale.rotational", "scale.joint"),
}

# Any: message classes are generated at run time from definitions.
_Result: Any = get_message("rcl_interfaces/msg/SetParametersResult")
_Descriptor: Any = get_message("rcl_interfaces/msg/ParameterDescriptor")


class ServoParameters:
    """Parameters of a servo node, declared below ``moveit_servo``.

    A parameter that is given without that namespace is taken as well.

    Args:
        node: The node.

    Raises:
        InvalidParameterError: A value has the wrong type or is out of range.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        overrides = node.get_parameter_overrides()
        for name, default in {**_AT_START, **_AT_RUNTIME}.items():
            full = f"{PREFIX}.{name}"
            if not node.has_parameter(full):
                short = overrides.get(name)
                given = default if short is None else short.value
                node.declare_parameter(full, given, _Descriptor(read_only=name in _AT_START))
            if problem := _problem(name, default, node.get_parameter(full).value):
                raise InvalidParameterError(f"Parameter '{full}' {problem}")
        for full in overrides:
            name = full.removeprefix(f"{PREFIX}.")
            if name in _WITHOUT_EFFECT:
                node.get_logger().info(f"Parameter '{full}' has no effect: {_WITHOUT_EFFECT[name]}")
            elif full.startswith(f"{PREFIX}.") and name not in {**_AT_START, **_AT_RUNTIME}:
                node.get_logger().warning(f"Parameter '{full}' is unknown and has no effect")
        node.add_on_set_parameters_callback(self._check)

    # Any: the value of a parameter.
    def __getitem__(self, name: str) -> Any:
        return self._node.get_parameter(f"{PREFIX}.{name}").value

    def settings(self) -> ServoSettings:
        """Return the settings of servo's steps."""
        return ServoSettings(
            joint_limit_margins=tuple(float(value) for value in self["joint_limit_margins"]),
            self_collision_proximity_threshold=float(self["self_collision_proximity_threshold"]),
            scene_collision_proximity_threshold=float(self["scene_collision_proximity_threshold"]),
            thresholds=Thresholds(
                float(self["lower_singularity_threshold"]),
                float(self["hard_stop_singularity_threshold"]),
            ),
            halt_all_joints_in_joint_mode=bool(self["halt_all_joints_in_joint_mode"]),
            halt_all_joints_in_cartesian_mode=bool(self["halt_all_joints_in_cartesian_mode"]),
            linear=float(self["scale.linear"]),
            rotational=float(self["scale.rotational"]),
            linear_tolerance=float(self["pose_tracking.linear_tolerance"]),
            angular_tolerance=float(self["pose_tracking.angular_tolerance"]),
        )

    def _check(self, parameters: list[Parameter]) -> Any:
        for parameter in parameters:
            name = parameter.name.removeprefix(f"{PREFIX}.")
            if not parameter.name.startswith(f"{PREFIX}.") or name not in _AT_RUNTIME:
                continue
            if problem := _problem(name, _AT_RUNTIME[name], parameter.value):
                return _Result(successful=False, reason=f"Parameter '{parameter.name}' {problem}")
        return _Result(successful=True)


def _problem(name: str, default: object, value: object) -> str:
    """Return why a value is not accepted, as the end of a sentence; empty if it is."""
    if name in _CHOICES:
        if value in _CHOICES[name]:
            return ""
        return f"must be one of {', '.join(filter(None, _CHOICES[name]))}, got {value!r}"
    if isinstance(default, (bool, str)):
        return (
            "" if isinstance(value, type(default)) else f"must be a {_kind(default)}, got {value!r}"
        )
    if isinstance(default, list):
        try:
            numbers = [float(each) for each in value]  # type: ignore[attr-defined]
        except (TypeError, ValueError):
            return f"must be a list of numbers, got {value!r}"
        good = numbers and all(number >= 0.0 and math.isfinite(number) for number in numbers)
        return "" if good else f"must have numbers of 0 or more, got {numbers}"
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return f"must be a number, got {value!r}"
    if name in _POSITIVE and value <= 0.0:
        return f"must be above 0, got {value:g}"
    return ""


def _kind(default: object) -> str:
    return "truth value" if isinstance(default, bool) else "string"
