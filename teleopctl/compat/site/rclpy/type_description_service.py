"""``rclpy.type_description_service``. Service that describes the types of a node."""

from teleopctl.node import Node, start_type_description_service

__all__ = ["START_TYPE_DESCRIPTION_SERVICE_PARAM", "TypeDescriptionService"]

START_TYPE_DESCRIPTION_SERVICE_PARAM = "start_type_description_service"


class TypeDescriptionService:
    """Service ``~/get_type_description`` of a node that was created without it.

    Args:
        node: Node that offers the service, unless its parameter switches it off.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._service = start_type_description_service(node)

    def destroy(self) -> None:
        """Stop offering the service."""
        if self._service is not None:
            self._node.destroy_service(self._service)
            self._service = None
