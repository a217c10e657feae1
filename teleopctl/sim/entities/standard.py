"""The standard services of simulators, `simulation_interfaces`, as far as one robot has them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.node import Clock
from teleopctl.sim.entities.answers import FindStage, SimulationServices
from teleopctl.sim.entities.entity_services import offer_entity_services
from teleopctl.sim.entities.pose_services import PoseServices
from teleopctl.sim.entities.push_service import offer_wrench_service
from teleopctl.sim.entities.run_services import RunServices
from teleopctl.sim.entities.spawn_services import SpawnServices
from teleopctl.sim.entities.world_services import WorldServices

if TYPE_CHECKING:
    from teleopctl.node import Node

# Until the answer that the simulator ends is with whoever asked, in seconds.
_FAREWELL_S = 0.2


def offer_standard_services(node: Node, find_stage: FindStage) -> None:
    """Offer the services of simulation_interfaces and mujoco_ros2_control's wrench service.

    Args:
        node: Whose they are.
        find_stage: See `FindStage`.
    """
    desk = SimulationServices(node, find_stage)

    def end() -> None:
        node.get_logger().info("Asked to quit")
        # By the wall: simulated time may stand still.
        node.create_timer(_FAREWELL_S, lambda: node.context.try_shutdown(), clock=Clock())

    offer_wrench_service(node, find_stage)
    offer_entity_services(desk)
    SpawnServices(desk)
    WorldServices(desk)
    PoseServices(desk)
    RunServices(desk, end)
