"""What a hand says: devices, their samples, and the mappings from samples to commands.

No kinematics: limits, collisions and stopping are servo's.

May import `interfaces` and `node`, and what every package may: `base`, `errors`, `packages` and
`plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.teleop.device import (
        STALE_S as STALE_S,
        DeviceError as DeviceError,
        HandSample as HandSample,
        TeleopDevice as TeleopDevice,
    )
    from teleopctl.teleop.mapping import (
        HandCommand as HandCommand,
        HandMapping as HandMapping,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
