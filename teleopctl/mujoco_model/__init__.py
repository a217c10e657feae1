"""From a robot description to a ``mujoco.MjSpec``, for whoever simulates, draws or solves.

What needs the model needs no simulation: the camera, kinematics and the page take it from here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.mujoco_model.base import (
        FixedBase as FixedBase,
        FixedBy as FixedBy,
        quaternion as quaternion,
    )
    from teleopctl.mujoco_model.cameras import CameraModel as CameraModel
    from teleopctl.mujoco_model.contacts import DirectedFriction as DirectedFriction
    from teleopctl.mujoco_model.drives import (
        DRIVE_RAD_S as DRIVE_RAD_S,
        compensated_bodies as compensated_bodies,
        drive_name as drive_name,
        lifting_efforts as lifting_efforts,
        motor_name as motor_name,
        rotors_told as rotors_told,
    )
    from teleopctl.mujoco_model.free_bodies import FreeBody as FreeBody, free_root as free_root
    from teleopctl.mujoco_model.joints import JointSpec as JointSpec
    from teleopctl.mujoco_model.model import (
        RobotModel as RobotModel,
        build_model as build_model,
        initial_positions as initial_positions,
    )
    from teleopctl.mujoco_model.sensors.camera_topics import CAMERA_TYPES as CAMERA_TYPES
    from teleopctl.mujoco_model.surroundings.carrying import carry_over as carry_over
    from teleopctl.mujoco_model.surroundings.surfaces import retime as retime
    from teleopctl.mujoco_model.surroundings.thing import Thing as Thing
    from teleopctl.mujoco_model.surroundings.things import (
        Coming as Coming,
        in_world as in_world,
        with_things as with_things,
        without_things as without_things,
    )
    from teleopctl.mujoco_model.surroundings.world import WORLD_PREFIX as WORLD_PREFIX
    from teleopctl.mujoco_model.unserved import (
        gazebos_own_tags as gazebos_own_tags,
        unserved_tags as unserved_tags,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
