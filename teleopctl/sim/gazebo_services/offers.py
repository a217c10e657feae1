"""How the services of Gazebo classic are offered, and how they answer what cannot be done."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from teleopctl.errors import RefusedError
from teleopctl.interfaces import get_service
from teleopctl.sim.entities.answers import NO_ROBOT, FindStage, Refusal, told
from teleopctl.sim.gazebo_services.entities import (
    delete_entity,
    get_entity_state,
    get_model_list,
    set_entity_state,
    spawn_entity,
)
from teleopctl.sim.gazebo_services.forces import apply_link_wrench, clear_link_wrenches
from teleopctl.sim.gazebo_services.running import (
    pause_physics,
    reset_simulation,
    reset_world,
    unpause_physics,
)
from teleopctl.wire import EntityKind

if TYPE_CHECKING:
    from teleopctl.node import Node
    from teleopctl.sim.entities.stage import RunningSimulation

# Any, here and below: messages, whose classes are made at run time. Warnings go to the last one.
# What goes on for long is a coroutine.
Handler = Callable[["RunningSimulation", Any, Any, Callable[[str], None]], "Awaitable[None] | None"]

_EMPTY = "std_srvs/srv/Empty"
_ALWAYS: dict[str, tuple[str, Handler]] = {
    "get_model_list": ("gazebo_msgs/srv/GetModelList", get_model_list),
    "apply_link_wrench": ("gazebo_msgs/srv/ApplyLinkWrench", apply_link_wrench),
    "clear_link_wrenches": ("gazebo_msgs/srv/LinkRequest", clear_link_wrenches),
    "pause_physics": (_EMPTY, pause_physics),
    "unpause_physics": (_EMPTY, unpause_physics),
    "reset_world": (_EMPTY, reset_world),
    # Worlds mostly give the namespace /gazebo to the plug-in that has these.
    "gazebo/get_entity_state": ("gazebo_msgs/srv/GetEntityState", get_entity_state),
    "gazebo/set_entity_state": ("gazebo_msgs/srv/SetEntityState", set_entity_state),
}
# simulation_interfaces has services of the same names.
_WHEN_ASKED_FOR: dict[str, tuple[str, Handler]] = {
    "spawn_entity": ("gazebo_msgs/srv/SpawnEntity", spawn_entity),
    "delete_entity": ("gazebo_msgs/srv/DeleteEntity", delete_entity),
    "get_entity_state": ("gazebo_msgs/srv/GetEntityState", get_entity_state),
    "set_entity_state": ("gazebo_msgs/srv/SetEntityState", set_entity_state),
    "reset_simulation": (_EMPTY, reset_simulation),
}


class GazeboServices:
    """Offers the services of gazebo_ros.

    Those whose names are also names of simulation_interfaces are offered once a program asks for
    them by Gazebo's type, and nobody else answers it: tools that know one type of a name, which is
    most of them, go on with the standard's.

    Args:
        node: Whose they are.
        find_stage: See `FindStage`.
    """

    def __init__(self, node: Node, find_stage: FindStage) -> None:
        self._node, self._find_stage = node, find_stage
        self._waiting = dict(_WHEN_ASKED_FOR)
        for name, (type_name, handler) in _ALWAYS.items():
            self._offer(name, type_name, handler)
        node.add_graph_callback(self._look)
        self._look()

    def _look(self) -> None:
        """Offer what is asked for; called after each change of the graph, on another thread."""
        for name, (type_name, handler) in list(self._waiting.items()):
            full = self._node.resolve_service_name(name)
            if not self._node.matched(EntityKind.SC, full, type_name):
                continue
            if self._node.matched(EntityKind.SS, full, type_name):
                continue
            # Two threads may have come here; what is offered is a change of the graph itself.
            if self._waiting.pop(name, None) is not None:
                self._offer(name, type_name, handler)

    def _offer(self, name: str, type_name: str, handler: Handler) -> None:
        logger = self._node.get_logger()

        def warn(words: str) -> None:
            logger.warning(f"{name}: {words}")

        async def answer(request: Any, response: Any) -> Any:
            text, done = "", False
            try:
                stage = self._find_stage()
                if stage is None:
                    raise RefusedError(NO_ROBOT)
                if (outcome := handler(stage, request, response, warn)) is not None:
                    await outcome
                done = True
            except Refusal as refusal:
                text = str(refusal)
            except Exception as error:  # noqa: BLE001 - no request ends the simulation
                text = told(self._node, error)
            if not done:
                logger.error(f"{name}: {text}")
            if hasattr(response, "success"):
                response.success = done
            if text and hasattr(response, "status_message"):
                response.status_message = text
            return response

        self._node.create_service(get_service(type_name), name, answer)
