"""Simulation: MuJoCo models built from the robot description, stepped in lockstep.

May import `interfaces`, `mujoco_model`, `node`, `robot`, `tf` and `wire`, and what every package
may: `base`, `errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.sim.building import SimulatedRobot as SimulatedRobot, simulate as simulate
    from teleopctl.sim.cameras.channel import CameraPublishers as CameraPublishers
    from teleopctl.sim.cameras.model_topic import (
        MODEL_TOPIC as MODEL_TOPIC,
        model_from_message as model_from_message,
    )
    from teleopctl.sim.cameras.renderer import (
        CameraRenderer as CameraRenderer,
        make_renderer as make_renderer,
    )
    from teleopctl.sim.gl_backend import (
        check_drawing as check_drawing,
        choose_backend as choose_backend,
    )
    from teleopctl.sim.node import MujocoSim as MujocoSim
    from teleopctl.sim.pacing import PeriodicSchedule as PeriodicSchedule
    from teleopctl.sim.ports import (
        CHANGES_TOPIC as CHANGES_TOPIC,
        JointStateView as JointStateView,
    )
    from teleopctl.sim.replay import (
        SimulationReplay as SimulationReplay,
        run_in_lockstep as run_in_lockstep,
    )
    from teleopctl.sim.sensors.base import Sensor as Sensor
    from teleopctl.sim.sensors.imu import Imu as Imu
    from teleopctl.sim.sensors.settings import (
        base_settings as base_settings,
        declare_base_settings as declare_base_settings,
        read_fixed_base as read_fixed_base,
    )
    from teleopctl.sim.simulation import Simulation as Simulation
    from teleopctl.sim.state.saved_state import SavedState as SavedState
    from teleopctl.sim.world_markers import WORLD_MARKERS_TOPIC as WORLD_MARKERS_TOPIC
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
