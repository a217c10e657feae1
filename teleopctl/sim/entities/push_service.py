"""``~/apply_wrench`` of mujoco_ros2_control: forces and torques on links, for a while."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service, to_nanoseconds
from teleopctl.sim.entities.pushes import Push

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.stage import Stage
    from teleopctl.sim.simulation import Simulation

_ApplyExternalWrench = get_service("mujoco_ros2_control_msgs/srv/ApplyExternalWrench")


def offer_wrench_service(node: Node, stage: Callable[[], Stage | None]) -> None:
    """Offer the service.

    Args:
        node: Whose it is.
        stage: Returns what it works with, or None while there is no robot.
    """

    # Any: messages, whose classes are made at run time.
    def answer(request: Any, response: Any) -> Any:
        there = stage()
        if there is None:
            response.success, response.message = False, "There is no robot yet"
            return response
        simulation, wrenches = there.simulation, request.wrenches.external_wrenches

        def apply() -> str:
            # All of a request is checked before any of it is done.
            reasons = [reason for wrench in wrenches if (reason := _refusal(simulation, wrench))]
            if not reasons:
                for wrench in wrenches:
                    simulation.push(_push(simulation, wrench))
            return reasons[0] if reasons else ""

        try:
            response.message = there.ask(apply)
        except TeleopctlError as error:
            response.message = error.message
        response.success = not response.message
        if response.success:
            response.message = f"Applied {len(wrenches)} wrenches"
        return response

    node.create_service(_ApplyExternalWrench, "~/apply_wrench", answer)


# Any, here and below: an ExternalWrench.
def _refusal(simulation: Simulation, wrench: Any) -> str:
    """Why a wrench cannot be applied; empty if it can."""
    link = wrench.wrench.header.frame_id
    if not link or not simulation.has_link(link):
        return f"There is no link '{link}': wrench.header.frame_id names what is pushed"
    if not np.isfinite(np.concatenate(_vectors(wrench))).all():
        return f"A number of the wrench on '{link}' is not finite"
    duration, ramp = to_nanoseconds(wrench.duration), to_nanoseconds(wrench.ramp_down_duration)
    if not 0 <= ramp <= duration:
        return "A duration is not negative, and no shorter than its ramp_down_duration"
    return ""


def _push(simulation: Simulation, wrench: Any) -> Push:
    force, torque, point = _vectors(wrench)
    step_ns = simulation.timestep_s * 1e9
    return Push(
        wrench.wrench.header.frame_id,
        force,
        torque,
        point,
        # No time at all is one step.
        max(1, round(to_nanoseconds(wrench.duration) / step_ns)),
        round(to_nanoseconds(wrench.ramp_down_duration) / step_ns),
    )


def _vectors(wrench: Any) -> list[Any]:
    """Force, torque and point of application, (3,) each."""
    parts = (wrench.wrench.wrench.force, wrench.wrench.wrench.torque, wrench.application_point)
    return [np.array([part.x, part.y, part.z]) for part in parts]
