"""tf messages for the same frames each time: serialized once, then patched."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from teleopctl.interfaces import get_message, serialize, split
from teleopctl.tf.messages import transform_stamped
from teleopctl.tf.transforms import Pose7, Transform

_STAMP = struct.Struct("<iI")
_POSE = struct.Struct("<7d")
# Differs from an identity transform at time 0 in the first byte of each part.
_OTHER = Transform((1e-3, 1e-3, 1e-3), (1e-3, 1e-3, 1e-3, 1e-3))


class PreparedTransforms:
    """Serialized ``tf2_msgs/msg/TFMessage`` whose stamps and poses are changed in place.

    At 1 kHz, filling in and serializing a message takes longer than computing the poses.

    Args:
        frames: Names of parent and child frame of each transform.

    Attributes:
        data: Serialized message, to be published.
    """

    def __init__(self, frames: Sequence[tuple[str, str]]) -> None:
        message = get_message("tf2_msgs/msg/TFMessage")

        def serialized(stamps: Sequence[int], pose: Transform) -> bytearray:
            return serialize(
                message(
                    transforms=[
                        transform_stamped(parent, child, stamp, pose)
                        for (parent, child), stamp in zip(frames, stamps, strict=True)
                    ]
                )
            )

        count = len(frames)
        self.data = serialized([0] * count, Transform())
        # A stamp of 1 s and 1 ns differs in the first byte of both of its numbers.
        stamped = serialized([1_000_000_001] * count, Transform())
        posed = serialized([0] * count, _OTHER)
        stamps = [place for place, byte in enumerate(stamped) if byte != self.data[place]]
        changed = [place for place, byte in enumerate(posed) if byte != self.data[place]]
        self._stamps = stamps[::2]
        # The pose begins where the first number of each transform begins.
        self._poses: list[int] = []
        for place in changed:
            if not self._poses or place >= self._poses[-1] + _POSE.size:
                self._poses.append(place)

    def set(self, stamp_ns: int, poses: Sequence[Pose7]) -> None:
        """Set the stamp of all transforms, in nanoseconds, and the pose of each."""
        data, sec_nanosec = self.data, split(stamp_ns)
        for stamp, place, pose in zip(self._stamps, self._poses, poses, strict=True):
            _STAMP.pack_into(data, stamp, *sec_nanosec)
            _POSE.pack_into(data, place, *pose)
