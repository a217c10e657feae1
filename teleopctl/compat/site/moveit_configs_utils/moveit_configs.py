"""Parameters of MoveIt by purpose."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

# Any: values of any kind.
Parameters = dict[str, Any]


@dataclass(slots=True)
class MoveItConfigs:
    """Parameters of MoveIt; each attribute is a dictionary for a node.

    Attributes:
        package_path: The configuration package.
        robot_description: URDF.
        robot_description_semantic: SRDF.
        robot_description_kinematics: Solvers of inverse kinematics.
        planning_pipelines: Planners.
        trajectory_execution: Which controllers carry trajectories out, and how.
        planning_scene_monitor: Published parts of the planning scene.
        sensors_3d: Depth cameras.
        move_group_capabilities: What ``move_group`` offers beyond its defaults, or does not.
        joint_limits: Limits in place of those in the URDF.
        moveit_cpp: Parameters of MoveItCpp.
        pilz_cartesian_limits: Limits of the Pilz planner.
    """

    package_path: Path | None = None
    robot_description: Parameters = field(default_factory=dict)
    robot_description_semantic: Parameters = field(default_factory=dict)
    robot_description_kinematics: Parameters = field(default_factory=dict)
    planning_pipelines: Parameters = field(default_factory=dict)
    trajectory_execution: Parameters = field(default_factory=dict)
    planning_scene_monitor: Parameters = field(default_factory=dict)
    sensors_3d: Parameters = field(default_factory=dict)
    move_group_capabilities: Parameters = field(
        default_factory=lambda: {"capabilities": "", "disable_capabilities": ""}
    )
    joint_limits: Parameters = field(default_factory=dict)
    moveit_cpp: Parameters = field(default_factory=dict)
    pilz_cartesian_limits: Parameters = field(default_factory=dict)

    def to_dict(self) -> Parameters:
        """Return all parameters in one dictionary, without the capabilities."""
        parameters = {
            **self.robot_description,
            **self.robot_description_semantic,
            **self.robot_description_kinematics,
            **self.planning_pipelines,
            **self.trajectory_execution,
            **self.planning_scene_monitor,
            **self.sensors_3d,
            **self.joint_limits,
            **self.moveit_cpp,
        }
        for name, limits in self.pilz_cartesian_limits.items():
            parameters[name] = {**parameters.get(name, {}), **limits}
        return parameters
