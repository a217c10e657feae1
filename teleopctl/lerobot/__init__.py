"""Plug-in of LeRobot: a robot of the ROS graph as a lerobot robot, an arm as teleoperator.

lerobot loads it by its own options ``--robot.discover_packages_path=teleopctl.lerobot`` and
``--teleop.discover_packages_path=teleopctl.lerobot``. Nothing else of teleopctl imports lerobot,
which needs torch.

May import `bag`, `commander`, `interfaces`, `node` and `pictures`, and what every package may:
`base`, `errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from teleopctl.base.lazy import import_module

# lerobot looks for a class beside the module of its configuration; each needs lerobot.
_HOMES = {
    "TeleopctlRobot": "robot",
    "TeleopctlRobotConfig": "robot",
    "TeleopctlTeleoperator": "teleoperator",
    "TeleopctlTeleoperatorConfig": "teleoperator",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    return found
