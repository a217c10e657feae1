"""All services of simulation_interfaces, and the wrench service of mujoco_ros2_control."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from teleopctl.errors import RefusedError
from teleopctl.interfaces import to_nanoseconds
from teleopctl.node import Clock
from teleopctl.sim.entities.entity_services import PoseServices, offer_entity_services
from teleopctl.sim.entities.pushes import Push
from teleopctl.sim.entities.run_services import RunServices
from teleopctl.sim.entities.service_base import (
    FindRunning,
    SimulationServices,
    offer_message_service,
)
from teleopctl.sim.entities.spawn_services import SpawnServices, WorldServices
from teleopctl.sim.request_numbers import invalid_number_reason

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.running_simulation import RunningSimulation
    from teleopctl.sim.simulation import Simulation


def offer_wrench_service(node: Node, find_running: FindRunning) -> None:
    """Create the service ``~/apply_wrench``, which applies external wrenches to links.

    Args:
        node: Node of the service.
        find_running: See `FindRunning`.
    """
    offer_message_service(node, find_running, "ApplyExternalWrench", "~/apply_wrench", _apply)


# Any, here and below: messages, whose classes are made at run time.
def _apply(running: RunningSimulation, request: Any) -> str:
    simulation, wrenches = running.simulation, request.wrenches.external_wrenches

    def push() -> None:
        # The whole request is checked before any wrench is applied.
        for wrench in wrenches:
            if reason := _refusal(simulation, wrench):
                raise RefusedError(reason)
        for wrench in wrenches:
            simulation.push(_push(simulation, wrench))

    running.call(push)
    return f"Applied {len(wrenches)} wrenches"


def _refusal(simulation: Simulation, wrench: Any) -> str:
    """Return why a wrench cannot be applied; empty if it can."""
    link = wrench.wrench.header.frame_id
    if not link or not simulation.has_link(link):
        return f"There is no link '{link}': wrench.header.frame_id must name a link"
    if reason := invalid_number_reason(np.concatenate(_vectors(wrench))):
        return f"A number of the wrench on '{link}' {reason}"
    duration, ramp = to_nanoseconds(wrench.duration), to_nanoseconds(wrench.ramp_down_duration)
    if not 0 <= ramp <= duration:
        return "The duration is negative, or shorter than the ramp_down_duration"
    return ""


def _push(simulation: Simulation, wrench: Any) -> Push:
    force, torque, point = _vectors(wrench)
    step_ns = simulation.timestep_s * 1e9
    return Push(
        wrench.wrench.header.frame_id,
        force,
        torque,
        point,
        # A duration of zero means one step.
        max(1, round(to_nanoseconds(wrench.duration) / step_ns)),
        round(to_nanoseconds(wrench.ramp_down_duration) / step_ns),
    )


def _vectors(wrench: Any) -> list[Any]:
    """Return force, torque and point of application, (3,) each."""
    parts = (wrench.wrench.wrench.force, wrench.wrench.wrench.torque, wrench.application_point)
    return [np.array([part.x, part.y, part.z]) for part in parts]


# Seconds for the response to reach the client before the simulator ends.
_FAREWELL_S = 0.2


def offer_standard_services(node: Node, find_running: FindRunning) -> None:
    """Create all services of simulation_interfaces, and ``~/apply_wrench``, on a node.

    Args:
        node: Node of the services.
        find_running: See `FindRunning`.
    """
    services = SimulationServices(node, find_running)

    def end() -> None:
        node.get_logger().info("Shutdown requested")
        # On the wall clock: simulated time may stand still.
        node.create_timer(_FAREWELL_S, lambda: node.context.try_shutdown(), clock=Clock())

    offer_wrench_service(node, find_running)
    offer_entity_services(services)
    SpawnServices(services)
    WorldServices(services)
    PoseServices(services)
    RunServices(services, end)
