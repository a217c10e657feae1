"""Clutch for teleoperation by pose: pressing it takes a new reference, so that nothing jumps."""

from __future__ import annotations

from teleopctl.tf import Transform


class PoseClutch:
    """Clutch between the pose of an operator's device and that of the tool.

    Args:
        scale: Ratio of the tool's translation to the device's; rotations are not scaled.
    """

    def __init__(self, scale: float = 1.0) -> None:
        self._scale = scale
        # Poses of device and tool when the clutch was pressed.
        self._begin: tuple[Transform, Transform] | None = None

    @property
    def is_held(self) -> bool:
        """Whether the clutch is held."""
        return self._begin is not None

    def hold(self, hand: Transform, tool: Transform) -> Transform:
        """Return the target pose of the tool; the first call takes the reference.

        Args:
            hand: Pose of the device, in a frame whose axes are those of the root link.
            tool: Pose of the tool in the frame of the root link.
        """
        if self._begin is None:
            self._begin = hand, tool
        before, start = self._begin
        moved = tuple(
            origin + self._scale * (now - then)
            for origin, now, then in zip(
                start.translation, hand.translation, before.translation, strict=True
            )
        )
        turned = Transform(rotation=hand.rotation) @ Transform(rotation=before.rotation).inverse()
        rotation = (turned @ Transform(rotation=start.rotation)).rotation
        return Transform((moved[0], moved[1], moved[2]), rotation)

    def release(self) -> None:
        """Release the clutch; the next call of `hold` takes a new reference."""
        self._begin = None
