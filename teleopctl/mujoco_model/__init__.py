"""Conversion of a robot description to a ``mujoco.MjSpec``, for simulation and kinematics.

The model needs no running simulation: cameras, kinematics and the web page use it directly.

May import `robot` and `tf`, and what every package may: `base`, `errors`, `packages` and
`plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.mujoco_model.base import (
        FixedBase as FixedBase,
        FixedBy as FixedBy,
        FreeBody as FreeBody,
        free_root as free_root,
        quaternion as quaternion,
    )
    from teleopctl.mujoco_model.cameras import (
        CAMERA_TYPES as CAMERA_TYPES,
        CameraModel as CameraModel,
    )
    from teleopctl.mujoco_model.contacts import DirectedFriction as DirectedFriction
    from teleopctl.mujoco_model.drives import (
        DRIVE_RAD_S as DRIVE_RAD_S,
        assumed_rotors_text as assumed_rotors_text,
        compensated_bodies as compensated_bodies,
        drive_name as drive_name,
        gravity_efforts as gravity_efforts,
        motor_name as motor_name,
    )
    from teleopctl.mujoco_model.joints import JointSpec as JointSpec
    from teleopctl.mujoco_model.mjcf import ActuatorTransmission as ActuatorTransmission
    from teleopctl.mujoco_model.model import (
        RobotModel as RobotModel,
        build_model as build_model,
        initial_positions as initial_positions,
    )
    from teleopctl.mujoco_model.surroundings.state_transfer import copy_state as copy_state
    from teleopctl.mujoco_model.surroundings.surfaces import set_timestep as set_timestep
    from teleopctl.mujoco_model.surroundings.things import (
        NewObject as NewObject,
        with_objects as with_objects,
        with_world as with_world,
        without_objects as without_objects,
    )
    from teleopctl.mujoco_model.surroundings.world import (
        WORLD_PREFIX as WORLD_PREFIX,
        WorldObject as WorldObject,
    )
    from teleopctl.mujoco_model.tag_support import (
        gazebo_only_tags as gazebo_only_tags,
        unsupported_tags as unsupported_tags,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
