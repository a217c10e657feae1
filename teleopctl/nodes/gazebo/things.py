"""Things beside the robot: into the simulator and out of it, by its services."""

from __future__ import annotations

import time
from typing import Any, ClassVar

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service
from teleopctl.node import Client, Node, SingleThreadedExecutor
from teleopctl.nodes.gazebo.entity import GazeboEntity
from teleopctl.tf import quaternion_from_rpy

# As long as the services of simulators take at most: a model is compiled, the loop asked to wait.
_PATIENCE_S = 30.0


class Things:
    """Spawns and deletes entities other than the robot.

    It has a node of its own, since the one that is asked for things waits meanwhile.

    Attributes:
        entities: What is there by its name.
    """

    def __init__(self) -> None:
        self.entities: dict[str, GazeboEntity] = {}
        self._node = Node("_gazebo_things", use_global_arguments=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._clients: dict[str, Client[Any, Any]] = {}

    # SpawnEntity's field for a URI is in another message from simulation_interfaces 2 on.
    _SERVICES: ClassVar = {"spawn_entity": "SpawnEntity", "delete_entity": "DeleteEntity"}

    def close(self) -> None:
        """Destroy the node."""
        self._executor.shutdown()
        self._node.destroy_node()

    def spawn(self, entity: GazeboEntity) -> str:
        """Spawn an entity; return why that failed, or an empty text."""
        request = get_service("simulation_interfaces/srv/SpawnEntity").Request(
            name=entity.name, allow_renaming=entity.renames
        )
        resource = getattr(request, "entity_resource", request)
        if entity.file:
            resource.uri = entity.file
        else:
            resource.resource_string = entity.text
        pose = request.initial_pose.pose
        x, y, z, roll, pitch, yaw = entity.pose
        pose.position.x, pose.position.y, pose.position.z = x, y, z
        turn = quaternion_from_rpy(roll, pitch, yaw)
        for axis, value in zip("xyzw", turn, strict=True):
            setattr(pose.orientation, axis, value)
        response, reason = self._call("spawn_entity", request)
        if not reason:
            self.entities[str(response.entity_name)] = entity
        return reason

    def delete(self, name: str) -> str:
        """Delete an entity; return why that failed, or an empty text."""
        request = get_service("simulation_interfaces/srv/DeleteEntity").Request(entity=name)
        _, reason = self._call("delete_entity", request)
        if not reason:
            self.entities.pop(name, None)
        return reason

    # Any: messages, whose classes are made at run time.
    def _call(self, name: str, request: Any) -> tuple[Any, str]:
        """Call a service; returns the response, and why it was refused, or nothing."""
        client = self._clients.get(name)
        if client is None:
            kind = get_service(f"simulation_interfaces/srv/{self._SERVICES[name]}")
            client = self._clients[name] = self._node.create_client(kind, f"/{name}")
        deadline = time.monotonic() + _PATIENCE_S
        if not client.wait_for_service(_PATIENCE_S):
            return None, f"the simulator does not offer /{name}"
        future = client.call_async(request)
        self._executor.spin_until_future_complete(future, max(0.0, deadline - time.monotonic()))
        if not future.done():
            return None, f"the simulator has not answered on /{name}"
        try:
            response = future.result()
        except TeleopctlError as error:
            return None, error.message
        assert response is not None
        result = response.result
        return response, "" if result.result == result.RESULT_OK else str(result.error_message)
