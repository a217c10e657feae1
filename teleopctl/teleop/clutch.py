"""Clutch of a hand's pose: the first press takes the reference, so that nothing jumps."""

from __future__ import annotations

from teleopctl.tf import Transform


class PoseClutch:
    """Moves a tool as a hand moves, from where both are when the hand takes hold.

    Args:
        scale: Motion of the tool for one of the hand, in length; rotations are not scaled.
    """

    def __init__(self, scale: float = 1.0) -> None:
        self._scale = scale
        # Poses of the hand and the tool when the hand took hold.
        self._begin: tuple[Transform, Transform] | None = None

    @property
    def is_held(self) -> bool:
        """Whether the hand holds the tool."""
        return self._begin is not None

    def hold(self, hand: Transform, tool: Transform) -> Transform:
        """Return where the tool shall be; the first call takes the reference.

        Args:
            hand: Pose of the hand, in a frame whose axes are those of the root link.
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
        """Let go; the next call of `hold` takes another reference."""
        self._begin = None
