"""What a model takes from ``<ros2_control>`` and ``<gazebo>``: joints to drive, cameras."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from teleopctl.mujoco_model.cameras import CameraModel
from teleopctl.mujoco_model.drives import COMMAND_INTERFACES, JointSpec

if TYPE_CHECKING:
    from collections.abc import Iterable

    from teleopctl.robot.description import RobotDescription
    from teleopctl.robot.gazebo_tag import Sensor
    from teleopctl.robot.ros2_control_tag import ComponentInfo, InterfaceInfo
    from teleopctl.robot.urdf import Joint

_DEFAULT_RATE_HZ = 30.0


def joint_specs(description: RobotDescription) -> tuple[list[JointSpec], list[str]]:
    """The joints that move along or about one axis, in the order of the URDF.

    Args:
        description: The robot.

    Returns:
        The joints, and a warning for each command interface that physics cannot offer.

    Raises:
        TeleopctlError: If ``<ros2_control>`` is not well formed.
    """
    controlled: dict[str, ComponentInfo] = {
        joint.name: joint for component in description.ros2_control for joint in component.joints
    }
    specs, warnings = [], []
    for joint in description.joints.values():
        if not joint.is_single_axis:
            continue
        info = controlled.get(joint.name)
        specs.append(_joint_spec(joint, info))
        if info is not None:
            unknown = [i.name for i in info.command_interfaces if i.name not in COMMAND_INTERFACES]
            warnings += [
                f"Command interface '{joint.name}/{name}' has no meaning in simulation"
                for name in unknown
            ]
    return specs, warnings


def _joint_spec(joint: Joint, info: ComponentInfo | None) -> JointSpec:
    limit = joint.limit
    bounded = limit is not None and joint.type != "continuous" and limit.lower < limit.upper
    commands, states = (
        ((), ()) if info is None else (info.command_interfaces, info.state_interfaces)
    )
    initial = [i.initial_value for i in states if i.name == "position"]
    return JointSpec(
        name=joint.name,
        command_interfaces=_names(commands, COMMAND_INTERFACES),
        state_interfaces=_names(states, None),
        mimic=joint.mimic if info is None else info.mimic,
        lower=limit.lower if limit is not None and bounded else -math.inf,
        upper=limit.upper if limit is not None and bounded else math.inf,
        max_velocity=_positive(None if limit is None else limit.velocity),
        max_effort=_positive(None if limit is None else limit.effort),
        initial_position=initial[0] if initial and initial[0] is not None else 0.0,
    )


def _names(interfaces: Iterable[InterfaceInfo], known: tuple[str, ...] | None) -> tuple[str, ...]:
    return tuple(i.name for i in interfaces if known is None or i.name in known)


def _positive(limit: float | None) -> float:
    """A limit of zero, which many descriptions have, stands for none."""
    return limit if limit is not None and limit > 0.0 else math.inf


def camera_models(description: RobotDescription) -> list[CameraModel]:
    """The camera sensors.

    Raises:
        TeleopctlError: If a ``<gazebo>`` tag is not well formed.
    """
    return [
        _camera(sensor)
        for sensor in description.gazebo.sensors
        if sensor.type == "camera" and sensor.camera is not None
    ]


def _camera(sensor: Sensor) -> CameraModel:
    camera = sensor.camera
    assert camera is not None
    return CameraModel(
        name=_of_plugins(sensor, "camera_name") or camera.name or sensor.name,
        link=sensor.link,
        frame_id=_of_plugins(sensor, "frame_name") or sensor.frame or sensor.link,
        width=camera.width,
        height=camera.height,
        horizontal_fov=camera.horizontal_fov,
        rate_hz=sensor.update_rate or _DEFAULT_RATE_HZ,
        distortion=(camera.k1, camera.k2, camera.p1, camera.p2, camera.k3),
        pose=sensor.pose,
    )


def _of_plugins(sensor: Sensor, parameter: str) -> str:
    texts = (plugin.parameter(parameter) for plugin in sensor.plugins)
    return next((text for text in texts if text), "")
