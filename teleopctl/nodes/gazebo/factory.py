"""``/spawn_entity`` and ``/delete_entity`` of Gazebo classic, also before there is a simulator."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from teleopctl.interfaces import get_service
from teleopctl.nodes.gazebo.entity import GazeboEntity
from teleopctl.tf import rpy_from_quaternion

if TYPE_CHECKING:
    from teleopctl.node import Node

_SpawnEntity = get_service("gazebo_msgs/srv/SpawnEntity")
_DeleteEntity = get_service("gazebo_msgs/srv/DeleteEntity")
_WORLD = ("", "world", "map", "/map")


def offer_factory(node: Node, hand_over: Callable[[GazeboEntity], str]) -> None:
    """Offer the services by which ``spawn_entity.py`` spawns.

    Args:
        node: Whose they are.
        hand_over: Puts an entity into the world, or takes out one without a description; returns
            why that was not done, or nothing.
    """

    # Any, here and below: messages, whose classes are made at run time.
    def spawn(request: Any, response: Any) -> Any:
        frame, name = request.reference_frame, request.name
        if frame not in _WORLD:
            reason = f"Reference frame [{frame}] is unknown here: there is the world's"
        elif not request.xml:
            reason = "Failed to parse XML string: it is empty"
        else:
            if request.robot_namespace:
                node.get_logger().warning(f"Without effect here: {request.robot_namespace=!s}")
            place, turn = request.initial_pose.position, request.initial_pose.orientation
            rpy = rpy_from_quaternion((turn.x, turn.y, turn.z, turn.w))
            pose = (place.x, place.y, place.z, *rpy)
            entity = GazeboEntity(text=request.xml, name=name, pose=pose, renames=not name)
            reason = hand_over(entity)
        response.success = not reason
        response.status_message = (
            reason or f"SpawnEntity: Successfully spawned entity [{request.name}]"
        )
        return response

    def delete(request: Any, response: Any) -> Any:
        reason = hand_over(GazeboEntity(name=request.name))
        response.success = not reason
        response.status_message = reason or f"Successfully deleted entity [{request.name}]"
        return response

    node.create_service(_SpawnEntity, "/spawn_entity", spawn)
    node.create_service(_DeleteEntity, "/delete_entity", delete)
