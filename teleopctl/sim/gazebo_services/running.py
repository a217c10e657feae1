"""Pause and reset, as ``gazebo_ros_init`` has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from teleopctl.sim.entities.stage import Stage


# Any, here and below: messages, whose classes are made at run time.
def pause_physics(stage: Stage, request: Any, response: Any, warn: Callable[[str], None]) -> None:
    """Let time stand still."""
    del request, response, warn
    stage.pause()


def unpause_physics(stage: Stage, request: Any, response: Any, warn: Callable[[str], None]) -> None:
    """Let time go on."""
    del request, response, warn
    stage.play()


def reset_simulation(
    stage: Stage, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Begin anew, time too; what was spawned stays, as in Gazebo."""
    del request, response, warn
    stage.reset(time=True, state=True, spawned=False)


def reset_world(stage: Stage, request: Any, response: Any, warn: Callable[[str], None]) -> None:
    """Put everything back to where it was at the start; time goes on."""
    del request, response, warn
    stage.reset(time=False, state=True, spawned=False)
