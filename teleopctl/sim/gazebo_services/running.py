"""Pause and reset, as ``gazebo_ros_init`` has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from teleopctl.sim.entities.stage import RunningSimulation


# Any, here and below: messages, whose classes are made at run time.
def pause_physics(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Pause the simulation."""
    del request, response, warn
    stage.pause()


def unpause_physics(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Resume the simulation."""
    del request, response, warn
    stage.play()


def reset_simulation(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Reset everything including time; spawned entities stay, as in Gazebo."""
    del request, response, warn
    stage.reset(time=True, state=True, spawned=False)


def reset_world(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Reset the states of all entities; time continues."""
    del request, response, warn
    stage.reset(time=False, state=True, spawned=False)
