"""Parameters of ``move_group``, with joint limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from teleopctl.commander import ActionKind, Controller
from teleopctl.errors import UsageError
from teleopctl.node import Node, Parameter
from teleopctl.robot import JointLimits, Joints

LIMITS = "robot_description_planning.joint_limits"
CONTROLLERS = "moveit_simple_controller_manager"

# Parameters that have an effect, by name or by beginning.
_USED = (
    "robot_description",
    "robot_description_semantic",
    "srdf",
    f"{LIMITS}.",
    "robot_description_planning.default_robot_padding",
    "allow_trajectory_execution",
    "trajectory_execution.execution_duration_monitoring",
    "trajectory_execution.allowed_execution_duration_scaling",
    "trajectory_execution.allowed_goal_duration_margin",
    "trajectory_execution.allowed_start_tolerance",
    f"{CONTROLLERS}.",
    "publish_robot_description",
    "publish_robot_description_semantic",
    "publish_planning_scene_hz",
    "planning_scene_monitor.publish_planning_scene_hz",
    "world_from_simulation",
    "floor",
    "use_sim_time",
    "start_type_description_service",
    "qos_overrides.",
)
# File of MoveIt's configuration, beginnings of its parameters, and why they have no effect.
_WITHOUT_EFFECT = (
    (
        "kinematics.yaml",
        ("robot_description_kinematics.",),
        "inverse kinematics is solved by the robot's own model, for every group",
    ),
    (
        "pilz_cartesian_limits.yaml",
        ("robot_description_planning.cartesian_limits.",),
        "the limits of the joints hold, and max_cartesian_speed of a request",
    ),
    (
        "joint_limits.yaml",
        ("robot_description_planning.default_",),
        "each request has its own scaling factors",
    ),
    (
        "ompl_planning.yaml",
        ("ompl.", "planning_pipelines.ompl."),
        "planners run with their defaults; type of planner_configs is used",
    ),
    ("chomp_planning.yaml", ("chomp.", "planning_pipelines.chomp."), "CHOMP is not included"),
    ("stomp_planning.yaml", ("stomp.", "planning_pipelines.stomp."), "STOMP is not included"),
    (
        "pilz_industrial_motion_planner_planning.yaml",
        ("pilz_industrial_motion_planner.", "planning_pipelines.pilz"),
        "PTP and LIN are planned with teleopctl's lines and planners",
    ),
    (
        "moveit_cpp.yaml or launch file",
        ("planning_pipelines", "default_planning_pipeline"),
        "there is one pipeline, with OMPL's planners, and the names of the others are understood",
    ),
    (
        "moveit_controllers.yaml",
        ("trajectory_execution.", "moveit_manage_controllers", "moveit_controller_manager"),
        "controllers are not switched, and found by their manager where none is configured",
    ),
    (
        "sensors_3d.yaml",
        ("sensors", "octomap_", "default_sensor", "kinect_", "realsense"),
        "there is no octomap: give obstacles as collision objects",
    ),
    (
        "launch file",
        ("capabilities", "disable_capabilities"),
        "the services and actions of MoveIt's default capabilities are always there",
    ),
    (
        "launch file",
        (
            "publish_",
            "planning_scene_monitor",
            "monitor_dynamics",
            "planning_scene_monitor_options",
        ),
        "scene, geometry and state are always published on monitored_planning_scene",
    ),
)


def setting(
    node: Node, name: str, default: bool | float | str | list[str] | None = None
) -> Any:  # Any: the value of a parameter
    """Return the value of a parameter; a default if it is not set."""
    value = node.get_parameter_or(name, Parameter("", value=default)).value
    return default if value is None else value


def mention_unused(node: Node) -> None:
    """Log which parameters have no effect and why, one line for each file of a configuration."""
    log = node.get_logger()
    names = [name for name in node.get_parameter_overrides() if not _is_used(name)]
    found: dict[tuple[str, str], list[str]] = {}
    unknown = []
    for name in names:
        for file, beginnings, why in _WITHOUT_EFFECT:
            if name.startswith(beginnings) or (
                file == "kinematics.yaml" and ".kinematics_solver" in name
            ):
                found.setdefault((file, why), []).append(name)
                break
        else:
            unknown.append(name)
    for (file, why), given in found.items():
        if file == "kinematics.yaml":
            # One line for each group, with or without the prefix of its namespace.
            for group in dict.fromkeys(name.rpartition(".")[0] for name in given):
                own = [name for name in given if name.rpartition(".")[0] == group]
                log.info(f"{_short(own)} of {file} have no effect: {why}")
            continue
        log.info(f"{_short(given)} of {file} have no effect: {why}")
    if unknown:
        log.warning(f"Unknown parameters, which have no effect: {', '.join(unknown)}")


def _is_used(name: str) -> bool:
    return any(name == used or (used[-1] == "." and name.startswith(used)) for used in _USED)


def _short(names: list[str]) -> str:
    first = ", ".join(f"'{name}'" for name in names[:2])
    more = len(names) - 2
    return f"Parameters {first} and {more} more" if more > 0 else f"Parameters {first}"


def limited_joints(node: Node, joints: Joints) -> Joints:
    """Return joints with the limits of ``joint_limits.yaml`` too; the narrower limit holds.

    Raises:
        UsageError: A limit is not above 0, or a range is empty.
    """
    return joints.with_limits(
        {name: _limited(node, name, joint.limits) for name, joint in joints.items()}
    )


def _limited(node: Node, joint: str, limits: JointLimits) -> JointLimits:
    # Any: the value of a parameter.
    def value(name: str) -> Any:
        return setting(node, f"{LIMITS}.{joint}.{name}")

    def most(quantity: str, own: float) -> float:
        if not value(f"has_{quantity}_limits"):
            return own
        given = value(f"max_{quantity}")
        if not isinstance(given, (int, float)) or not given > 0.0:
            raise UsageError(
                f"Parameter '{LIMITS}.{joint}.max_{quantity}' must be above 0, got {given!r}"
            )
        return min(float(given), own)

    acceleration = most("acceleration", limits.acceleration)
    lower, upper = limits.lower, limits.upper
    if value("has_position_limits"):
        least, greatest = value("min_position"), value("max_position")
        if not all(isinstance(v, (int, float)) for v in (least, greatest)) or not least < greatest:
            raise UsageError(
                f"Parameters '{LIMITS}.{joint}.min_position' and 'max_position' are no range: "
                f"{least!r} and {greatest!r}"
            )
        lower, upper = max(lower, float(least)), min(upper, float(greatest))
    return replace(
        limits,
        lower=lower,
        upper=upper,
        velocity=most("velocity", limits.velocity),
        acceleration=acceleration,
        deceleration=min(acceleration, limits.deceleration),
        jerk=most("jerk", limits.jerk),
    )


def configured_controllers(node: Node) -> list[Controller]:
    """Return the controllers of the parameters ``moveit_simple_controller_manager``."""

    # Any: the value of a parameter.
    def value(name: str, default: bool | float | str | list[str]) -> Any:
        return setting(node, f"{CONTROLLERS}.{name}", default)

    controllers = []
    log = node.get_logger()
    for name in value("controller_names", []):
        namespace, kind = value(f"{name}.action_ns", ""), value(f"{name}.type", "")
        joints = tuple(value(f"{name}.joints", []))
        if kind not in set(ActionKind) or not joints:
            log.error(
                f"Controller '{name}' of {CONTROLLERS} has the type '{kind}' and the joints "
                f"{list(joints)}: it needs joints and one of {', '.join(ActionKind)}"
            )
            continue
        command = value(f"{name}.command_joint", "")
        if kind == ActionKind.GRIPPER and command:
            joints = (command, *(joint for joint in joints if joint != command))
        controllers.append(
            Controller(
                name,
                joints,
                f"{name}/{namespace}" if namespace else name,
                ActionKind(kind),
                is_default=bool(value(f"{name}.default", default=False)),
                max_effort=float(value(f"{name}.max_effort", 0.0)),
            )
        )
    return controllers
