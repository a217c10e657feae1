"""Entities of the Gazebo programs: their parameters, and services that spawn and delete them."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service
from teleopctl.node import Client, Node, Parameter, SingleThreadedExecutor
from teleopctl.robot import RobotDescription, model_kind, read_model
from teleopctl.tf import quaternion_from_rpy, rpy_from_quaternion

if TYPE_CHECKING:
    from teleopctl.node import Node

# Parameters of the node `gazebo`: description of the entity to spawn, and its other properties.
DESCRIPTION = "robot_description"
POSE = "robot_pose"
_NAME, _FILE, _TOPIC, _RENAMES = "entity_name", "entity_file", "entity_topic", "entity_renames"
NOWHERE = (0.0,) * 6


class GazeboEntity(NamedTuple):
    """Entity that a Gazebo program spawns: description, name, pose; without text, to delete.

    Attributes:
        text: URDF or SDF text; empty to delete the entity.
        name: Name of the entity; empty for the name in its description.
        file: Path of the file with the text; empty for no file.
        topic: Topic on which the text was received; empty for no topic.
        renames: Whether the entity may be renamed if its name is taken.
        pose: Initial pose: x, y, z (m), roll, pitch, yaw (rad).
    """

    text: str = ""
    name: str = ""
    file: str = ""
    topic: str = ""
    renames: bool = False
    pose: tuple[float, ...] = NOWHERE

    # Any: parameter values have several types.
    @classmethod
    def of_parameters(cls, values: Mapping[str, Any]) -> GazeboEntity:
        """Return the `GazeboEntity` for parameter values of the node ``gazebo``, by name."""
        return cls(
            str(values[DESCRIPTION] or ""),
            str(values.get(_NAME) or ""),
            str(values.get(_FILE) or ""),
            str(values.get(_TOPIC) or ""),
            bool(values.get(_RENAMES)),
            tuple(values.get(POSE) or NOWHERE),
        )

    def as_parameters(self) -> list[Parameter]:
        """Return the entity as parameters of the node ``gazebo``, for `of_parameters`."""
        return [
            Parameter(DESCRIPTION, value=self.text),
            Parameter(_NAME, value=self.name),
            Parameter(_FILE, value=self.file),
            Parameter(_TOPIC, value=self.topic),
            Parameter(_RENAMES, value=self.renames),
            Parameter(POSE, value=list(self.pose)),
        ]

    def urdf(self, folder: Path) -> str:
        """Return the entity's description as URDF, converted from SDF if needed.

        Args:
            folder: Folder for a temporary file with the SDF text.

        Raises:
            InvalidDescriptionError: The SDF cannot be read.
        """
        if self.file and model_kind(self.file) == "sdf":
            return read_model(self.file).text
        if "<sdf" not in self.text:
            return self.text
        file = Path(tempfile.mkdtemp(dir=folder)) / "model.sdf"
        file.write_text(self.text, "utf-8")
        return read_model(file).text if model_kind(file) == "sdf" else self.text

    def robot_rank(self, description: RobotDescription) -> tuple[bool, bool]:
        """Return a sort key for the likeliest robot: has controllers or sensors, is from a topic.

        Returns:
            Whether the description has controllers, plug-ins or sensors, and whether it comes from
            a topic.
        """
        gazebo = description.gazebo
        is_active = bool(description.ros2_control or gazebo.plugins or gazebo.sensors)
        return is_active, bool(self.topic)


_SpawnEntity = get_service("gazebo_msgs/srv/SpawnEntity")
_DeleteEntity = get_service("gazebo_msgs/srv/DeleteEntity")
_WORLD = ("", "world", "map", "/map")


def offer_spawn_services(node: Node, apply_entity: Callable[[GazeboEntity], str]) -> None:
    """Create services ``/spawn_entity`` and ``/delete_entity`` that call ``apply_entity``.

    Args:
        node: Node that serves the two services.
        apply_entity: Function that spawns an entity, or deletes an entity without a description,
            and returns the reason of a failure, empty on success.
    """

    # Any, here and below: messages, whose classes are created at run time.
    def spawn(request: Any, response: Any) -> Any:
        frame, name = request.reference_frame, request.name
        if frame not in _WORLD:
            reason = f"Reference frame [{frame}] is unknown: only world is supported"
        elif not request.xml:
            reason = "Failed to parse XML string: it is empty"
        else:
            if request.robot_namespace:
                node.get_logger().warning(f"Without effect here: {request.robot_namespace=!s}")
            place, turn = request.initial_pose.position, request.initial_pose.orientation
            rpy = rpy_from_quaternion((turn.x, turn.y, turn.z, turn.w))
            pose = (place.x, place.y, place.z, *rpy)
            entity = GazeboEntity(text=request.xml, name=name, pose=pose, renames=not name)
            reason = apply_entity(entity)
        response.success = not reason
        response.status_message = (
            reason or f"SpawnEntity: Successfully spawned entity [{request.name}]"
        )
        return response

    def delete(request: Any, response: Any) -> Any:
        reason = apply_entity(GazeboEntity(name=request.name))
        response.success = not reason
        response.status_message = reason or f"Successfully deleted entity [{request.name}]"
        return response

    node.create_service(_SpawnEntity, "/spawn_entity", spawn)
    node.create_service(_DeleteEntity, "/delete_entity", delete)


# Longest wait for the simulator's services, in seconds: they compile a model between two steps.
_TIMEOUT_S = 30.0


class ObjectSpawner:
    """Client of the simulator that spawns and deletes all entities except the robot.

    The clients have a node of their own, since the node ``gazebo`` waits for their responses in its
    own service callbacks.

    Attributes:
        entities: Spawned entities by name.
    """

    def __init__(self) -> None:
        self.entities: dict[str, GazeboEntity] = {}
        self._node = Node("_gazebo_things", use_global_arguments=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._clients: dict[str, Client[Any, Any]] = {}

    # From simulation_interfaces 2 on, SpawnEntity has the URI in a nested message.
    _SERVICES: ClassVar = {"spawn_entity": "SpawnEntity", "delete_entity": "DeleteEntity"}

    def close(self) -> None:
        """Destroy the node whose service clients call the simulator."""
        self._executor.shutdown()
        self._node.destroy_node()

    def spawn(self, entity: GazeboEntity) -> str:
        """Spawn an entity in the simulator; return the reason of a failure, empty on success."""
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
        """Delete an entity from the simulator; return the reason of a failure, empty on success."""
        request = get_service("simulation_interfaces/srv/DeleteEntity").Request(entity=name)
        _, reason = self._call("delete_entity", request)
        if not reason:
            self.entities.pop(name, None)
        return reason

    # Any: messages, whose classes are created at run time.
    def _call(self, name: str, request: Any) -> tuple[Any, str]:
        """Call a service; return the response and the reason of a failure, empty on success."""
        client = self._clients.get(name)
        if client is None:
            kind = get_service(f"simulation_interfaces/srv/{self._SERVICES[name]}")
            client = self._clients[name] = self._node.create_client(kind, f"/{name}")
        deadline = time.monotonic() + _TIMEOUT_S
        if not client.wait_for_service(_TIMEOUT_S):
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
