"""What Tab offers for frames."""

from __future__ import annotations

from teleopctl.errors import TeleopctlError


def frames(incomplete: str) -> list[str]:
    """Return the frames that are broadcast within a moment."""
    from teleopctl.cli.verbs.tf.frames import heard_frames

    try:
        return sorted(name for name in heard_frames() if name.startswith(incomplete))
    except TeleopctlError:
        return []
