"""``rclpy.parameter_service``. Parameter services of a node."""

from teleopctl import node as _node
from teleopctl.node import Node

__all__ = ["ParameterService"]


class ParameterService(_node.ParameterService):
    """The six parameter services of a node that was created without them.

    Args:
        node: Node with the parameters.
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, node._parameters)  # noqa: SLF001 -- as rclpy's, which has no other way
