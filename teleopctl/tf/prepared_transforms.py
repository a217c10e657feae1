"""tf messages for the same frames each time: serialized once, then patched."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from teleopctl.interfaces import get_message, serialize, split
from teleopctl.tf.messages import transform_stamped
from teleopctl.tf.transforms import Pose7, Transform

_STAMP = struct.Struct("<iI")
_POSE_SIZE = 7 * 8
# Differs from an identity transform at time 0 in the first byte of each part.
_OTHER = Transform((1e-3, 1e-3, 1e-3), (1e-3, 1e-3, 1e-3, 1e-3))


class PreparedTransforms:
    """Serialized ``tf2_msgs/msg/TFMessage`` of which only stamps and poses change.

    At 1 kHz, filling in and serializing a message takes longer than computing the poses.

    Args:
        frames: Names of parent and child frame of each transform.
    """

    def __init__(self, frames: Sequence[tuple[str, str]]) -> None:
        message = get_message("tf2_msgs/msg/TFMessage")

        def serialized(stamps: Sequence[int], pose: Transform) -> bytes:
            return bytes(
                serialize(
                    message(
                        transforms=[
                            transform_stamped(parent, child, stamp, pose)
                            for (parent, child), stamp in zip(frames, stamps, strict=True)
                        ]
                    )
                )
            )

        count = len(frames)
        data = serialized([0] * count, Transform())
        # A stamp of 1 s and 1 ns differs in the first byte of both of its numbers.
        stamped = serialized([1_000_000_001] * count, Transform())
        posed = serialized([0] * count, _OTHER)
        stamps = [place for place, byte in enumerate(stamped) if byte != data[place]][::2]
        # The pose begins where the first number of each transform begins.
        poses: list[int] = []
        for place in [place for place, byte in enumerate(posed) if byte != data[place]]:
            if not poses or place >= poses[-1] + _POSE_SIZE:
                poses.append(place)
        # The data in front of the first stamp, and of each transform between stamp and pose.
        self._head = data[: stamps[0]] if stamps else data
        self._names = [
            data[stamp + _STAMP.size : pose] for stamp, pose in zip(stamps, poses, strict=True)
        ]
        # One call for all of it: a call for each stamp and pose takes twice as long.
        parts = [f"{_STAMP.size}s{len(names)}s7d" for names in self._names]
        self._layout = struct.Struct(f"<{len(self._head)}s{''.join(parts)}")

    def serialized(self, stamp_ns: int, poses: Sequence[Pose7]) -> bytes:
        """Return the message with a stamp of all transforms, in nanoseconds, and their poses."""
        stamp = _STAMP.pack(*split(stamp_ns))
        parts: list[bytes | float] = [self._head]
        for names, pose in zip(self._names, poses, strict=True):
            parts += (stamp, names, *pose)
        return self._layout.pack(*parts)
