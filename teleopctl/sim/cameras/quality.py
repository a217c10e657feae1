"""The quality at which a machine draws its cameras in time.

Multisampling costs most, then shadows, then reflections; the factors multiply. ``auto`` tries
from the best down on real frames and stays with the first quality that holds the rate.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from teleopctl.errors import UnavailableError
from teleopctl.mujoco_model import CameraModel, RobotModel
from teleopctl.sim.cameras.renderer import CameraRenderer, Quality

# The part of a frame's time that drawing may take; the rest is for sending the picture.
_SHARE = 0.75
_TIMED_FRAMES = 3

FULL = Quality("full", samples=4, shadow_size=4096, reflections=True)
HIGH = Quality("high", samples=4, shadow_size=2048, reflections=False)
MEDIUM = Quality("medium", samples=0, shadow_size=2048, reflections=False)
FAST = Quality("fast", samples=0, shadow_size=0, reflections=False)

_BEST_FIRST = (FULL, HIGH, MEDIUM, FAST)
QUALITIES = ("auto", "fast", "full")


def make_renderer(
    model: RobotModel,
    cameras: Sequence[CameraModel],
    quality: str,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[CameraRenderer, str]:
    """Return a renderer of a named quality; for ``auto``, frames are timed.

    Args:
        model: The robot.
        cameras: Which cameras.
        quality: ``full``, ``fast`` or ``auto``: the best that holds the cameras' rates.
        clock: Seconds, for the measurement.

    Returns:
        The renderer, and a sentence for the log on what was chosen and why.

    Raises:
        UnavailableError: If the quality is unknown or a system library for drawing is missing.
    """
    if quality in ("full", "fast"):
        chosen = FULL if quality == "full" else FAST
        return CameraRenderer(model, cameras, chosen), f"drawing at quality {chosen}"
    if quality != "auto":
        raise UnavailableError(
            f"Unknown quality '{quality}'", hint=f"It is one of {', '.join(QUALITIES)}"
        )
    rate_hz = max(camera.rate_hz for camera in cameras)
    budget = _SHARE / rate_hz
    for candidate in _BEST_FIRST:
        renderer = CameraRenderer(model, cameras, candidate)
        # The frames of all cameras that fall on one of the fastest.
        seconds = sum(
            _measure(renderer, camera, budget, clock) * camera.rate_hz / rate_hz
            for camera in cameras
        )
        if seconds <= budget or candidate is FAST:
            verdict = "holds" if seconds <= budget else "is too slow for"
            return renderer, (
                f"drawing at quality {candidate}: {seconds * 1e3:.0f} ms a frame "
                f"{verdict} {rate_hz:g} Hz"
            )
        renderer.close()
    raise AssertionError("the last candidate is always taken")


def _measure(
    renderer: CameraRenderer, camera: CameraModel, budget: float, clock: Callable[[], float]
) -> float:
    """Seconds for a frame, the median of a few after one that warms up."""
    picture = np.zeros((camera.height, camera.width, 3), np.uint8)

    def timed() -> float:
        started = clock()
        renderer.place({})
        renderer.colours(camera.name, picture)
        return clock() - started

    warm_up = timed()
    if warm_up > 10.0 * budget:
        # Hopeless even if half of that was the driver's compiling of shaders.
        return warm_up
    return sorted(timed() for _ in range(_TIMED_FRAMES))[_TIMED_FRAMES // 2]
