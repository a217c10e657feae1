"""``tf2_ros::StaticTransformBroadcasterNode``: a transform that stands in parameters."""

from __future__ import annotations

from teleopctl.errors import InvalidParameterError
from teleopctl.node import Node
from teleopctl.nodes.tf2.static_transform_publisher import broadcast
from teleopctl.tf import Transform, normalize


class StaticTransformBroadcasterNode(Node):
    """Publishes one static transform.

    Raises:
        InvalidParameterError: The frames are the same, or the rotation is none.
    """

    def __init__(self) -> None:
        super().__init__("static_transform_publisher")
        move = (
            self._number("translation.x"),
            self._number("translation.y"),
            self._number("translation.z"),
        )
        turn = (
            self._number("rotation.x"),
            self._number("rotation.y"),
            self._number("rotation.z"),
            self._number("rotation.w", 1.0),
        )
        frame = str(self.declare_parameter("frame_id", "/frame").value)
        child = str(self.declare_parameter("child_frame_id", "/child").value)
        if frame == child:
            raise InvalidParameterError(
                f"cannot publish static transform from '{frame}' to '{child}', exiting"
            )
        try:
            transform = Transform(move, normalize(turn))
        except ZeroDivisionError:
            raise InvalidParameterError("the quaternion is zero") from None
        self._broadcaster = broadcast(self, frame, child, transform)

    def _number(self, name: str, default: float = 0.0) -> float:
        return float(self.declare_parameter(name, default).value)
