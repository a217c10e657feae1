"""Teleoperation devices, their samples, and mappings from samples to motion commands.

No kinematics: limits, collisions and stopping are servo's.

May import `interfaces`, `node` and `tf`, and what every package may: `base`, `errors`, `packages`
and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.teleop.clutch import PoseClutch as PoseClutch
    from teleopctl.teleop.device import (
        STALE_S as STALE_S,
        DeviceError as DeviceError,
        HandSample as HandSample,
        TeleopDevice as TeleopDevice,
    )
    from teleopctl.teleop.held_keys import HeldKeys as HeldKeys
    from teleopctl.teleop.joystick import (
        Joystick as Joystick,
        JoystickInfo as JoystickInfo,
        choose_joystick as choose_joystick,
        find_joysticks as find_joysticks,
        keep_open as keep_open,
        open_joystick as open_joystick,
    )
    from teleopctl.teleop.leader import (
        JointFollowing as JointFollowing,
        LeaderMapping as LeaderMapping,
        LeaderState as LeaderState,
    )
    from teleopctl.teleop.mapping import (
        ANGULAR as ANGULAR,
        EPISODE as EPISODE,
        EPISODE_STEPS as EPISODE_STEPS,
        LINEAR as LINEAR,
        HandCommand as HandCommand,
        HandMapping as HandMapping,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
