"""Pictures of a robot model, and the quality at which a machine draws them in time.

Multisampling costs most, then shadows, then reflections; the factors multiply. ``auto`` tries
from the best down on real frames and stays with the first quality that holds the rate.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import UnavailableError
from teleopctl.mujoco_model import CameraModel, RobotModel
from teleopctl.sim.gl_backend import missing_library

# The part of a frame's time that drawing may take; the rest is for sending the picture.
_SHARE = 0.75
_TIMED_FRAMES = 3


@dataclass(frozen=True)
class Quality:
    """How pictures are drawn.

    Attributes:
        name: What it is called in the log.
        samples: Samples per pixel for smooth edges, 0 for one.
        shadow_size: Side of the shadow map in texels, 0 for no shadows.
        reflections: Whether the ground reflects.
    """

    name: str
    samples: int
    shadow_size: int
    reflections: bool

    def __str__(self) -> str:
        smooth = f"{self.samples}x multisampling" if self.samples else "no multisampling"
        shadows = f"shadows {self.shadow_size}" if self.shadow_size else "no shadows"
        mirror = "reflections" if self.reflections else "no reflections"
        return f"{self.name} ({smooth}, {shadows}, {mirror})"


FULL = Quality("full", samples=4, shadow_size=4096, reflections=True)
HIGH = Quality("high", samples=4, shadow_size=2048, reflections=False)
MEDIUM = Quality("medium", samples=0, shadow_size=2048, reflections=False)
FAST = Quality("fast", samples=0, shadow_size=0, reflections=False)

Picture = npt.NDArray[np.uint8]

_BEST_FIRST = (FULL, HIGH, MEDIUM, FAST)
QUALITIES = ("auto", "fast", "full")


class CameraRenderer:
    """Draws what a camera of a model sees. All use is bound to the thread that makes it.

    Args:
        model: The robot.
        camera: Which camera.
        quality: How to draw.
        image: Where to draw: height x width x 3, red green blue.

    Attributes:
        quality: How it draws.
        image: The picture drawn last, in the array that was given.

    Raises:
        TeleopctlError: If a system library for drawing is missing.
    """

    def __init__(
        self, model: RobotModel, camera: CameraModel, quality: Quality, image: Picture
    ) -> None:
        self.quality = quality
        self.image = image
        self._camera = camera.name
        self._m: Any = model.mj_model
        self._d: Any = mujoco.MjData(self._m)
        self._m.vis.quality.offsamples = quality.samples
        self._m.vis.quality.shadowsize = quality.shadow_size
        try:
            self._renderer = mujoco.Renderer(self._m, camera.height, camera.width)
        except (ImportError, AttributeError, RuntimeError, mujoco.FatalError) as error:
            raise missing_library(error) from error
        flags = self._renderer.scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = quality.shadow_size > 0
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = quality.reflections
        self._address = {
            joint.name: int(self._m.joint(joint.name).qposadr[0]) for joint in model.joints
        }
        self._free = {
            body.link: int(self._m.joint(body.joint).qposadr[0]) for body in model.free_bodies
        }

    def draw(
        self,
        positions: Mapping[str, float],
        bodies: Mapping[str, Sequence[float]] = MappingProxyType({}),
    ) -> None:
        """Draw the robot in a pose into `image`.

        Args:
            positions: Joint positions (rad or m) by name; unknown names are passed over and
                joints that are not named stay where they were.
            bodies: Where free bodies are in the world, by link: x y z in metres, then the
                rotation w x y z; taken in the same way.
        """
        for name, position in positions.items():
            address = self._address.get(name)
            if address is not None:
                self._d.qpos[address] = position
        for link, pose in bodies.items():
            start = self._free.get(link)
            if start is not None:
                self._d.qpos[start : start + 7] = pose
        mujoco.mj_kinematics(self._m, self._d)
        mujoco.mj_comPos(self._m, self._d)
        mujoco.mj_camlight(self._m, self._d)
        self._renderer.update_scene(self._d, camera=self._camera)
        self._renderer.render(out=self.image)

    def close(self) -> None:
        """Free what the graphics driver holds."""
        self._renderer.close()


def make_renderer(
    model: RobotModel,
    camera: CameraModel,
    quality: str,
    image: Picture,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[CameraRenderer, str]:
    """Make a renderer of a named quality, measuring frames for ``auto``.

    Args:
        model: The robot.
        camera: Which camera.
        quality: ``full``, ``fast`` or ``auto``: the best that holds the camera's rate.
        image: Where to draw: height x width x 3, red green blue.
        clock: Seconds, for the measurement.

    Returns:
        The renderer, and a sentence for the log on what was chosen and why.

    Raises:
        UnavailableError: If the quality is unknown or a system library for drawing is missing.
    """
    if quality == "full":
        return CameraRenderer(model, camera, FULL, image), f"drawing at quality {FULL}"
    if quality == "fast":
        return CameraRenderer(model, camera, FAST, image), f"drawing at quality {FAST}"
    if quality != "auto":
        raise UnavailableError(
            f"Unknown quality '{quality}'", hint=f"It is one of {', '.join(QUALITIES)}"
        )
    budget = _SHARE / camera.rate_hz
    for candidate in _BEST_FIRST:
        renderer = CameraRenderer(model, camera, candidate, image)
        seconds = _measure(renderer, budget, clock)
        if seconds <= budget or candidate is FAST:
            verdict = "holds" if seconds <= budget else "is too slow for"
            return renderer, (
                f"drawing at quality {candidate}: {seconds * 1e3:.0f} ms a frame "
                f"{verdict} {camera.rate_hz:g} Hz"
            )
        renderer.close()
    raise AssertionError("the last candidate is always taken")


def _measure(renderer: CameraRenderer, budget: float, clock: Callable[[], float]) -> float:
    """Seconds for a frame, the median of a few after one that warms up."""
    started = clock()
    renderer.draw({})
    warm_up = clock() - started
    if warm_up > 10.0 * budget:
        # Hopeless even if half of that was the driver's compiling of shaders.
        return warm_up
    times = []
    for _ in range(_TIMED_FRAMES):
        started = clock()
        renderer.draw({})
        times.append(clock() - started)
    return sorted(times)[len(times) // 2]
