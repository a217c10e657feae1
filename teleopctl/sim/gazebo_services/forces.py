"""Forces and torques on links, as ``gazebo_ros_force_system`` has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import InvalidMessageError, NotFoundError, RefusedError
from teleopctl.interfaces import to_nanoseconds
from teleopctl.sim.entities.poses import no_sense
from teleopctl.sim.entities.pushes import Push
from teleopctl.sim.gazebo_services.links import frame_link, link_of

if TYPE_CHECKING:
    from teleopctl.sim.entities.stage import RunningSimulation
    from teleopctl.sim.simulation import Simulation

# A duration below zero is one without end: longer than anybody simulates.
_ENDLESS = 1 << 62


# Any, here and below: messages, whose classes are made at run time.
def apply_link_wrench(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """Apply a force and a torque to a link for a duration."""
    del warn

    def apply() -> bool:
        push = _push(stage.simulation, request)
        if push is not None:
            stage.simulation.push(push)
        return push is not None

    if not stage.ask(apply):
        response.status_message = "The duration is 0: nothing is done"


def clear_link_wrenches(
    stage: RunningSimulation, request: Any, response: Any, warn: Callable[[str], None]
) -> None:
    """End the wrenches on a link."""
    del response

    def clear() -> bool:
        return stage.simulation.end_pushes(link_of(stage.simulation, request.link_name))

    if not stage.ask(clear):
        warn(f"No applied wrenches on [{request.link_name}]")


def _push(simulation: Simulation, request: Any) -> Push | None:
    link = link_of(simulation, request.link_name)
    if not link:
        raise NotFoundError(f"'{request.link_name}' stands in the world: name one of its links")
    parts = request.wrench.force, request.wrench.torque, request.reference_point
    force, torque, point = (np.array([part.x, part.y, part.z]) for part in parts)
    if reason := no_sense([force, torque, point]):
        raise InvalidMessageError(f"A number of the wrench on '{link}' {reason}")
    if to_nanoseconds(request.start_time) > simulation.time_ns:
        raise RefusedError("start_time is to come: a wrench acts from now on")
    pushed = simulation.link_pose(link)
    if reference := frame_link(simulation, request.reference_frame):
        frame = simulation.link_pose(reference)
        force, torque = frame.rotation @ force, frame.rotation @ torque
        lever = frame.position + frame.rotation @ point - pushed.position
    else:
        # Along the world's axes, from the link's origin.
        lever = point
    duration = to_nanoseconds(request.duration)
    if duration == 0:
        return None
    step_ns = simulation.timestep_s * 1e9
    steps = _ENDLESS if duration < 0 else max(1, round(duration / step_ns))
    return Push(link, force, torque, pushed.rotation.T @ lever, steps)
