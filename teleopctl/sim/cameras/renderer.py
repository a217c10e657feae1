"""Renderer of a robot's cameras, and the choice of a quality that holds their rates.

All cameras are rendered from one model with one OpenGL context. Multisampling costs most, then
shadows, then reflections; the factors multiply. Quality ``auto`` renders real frames from the best
quality down, and uses the first quality that holds the rate.
"""

from __future__ import annotations

import math
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
from teleopctl.sim.cameras.lens import Face, Projection, camera_projection
from teleopctl.sim.gl_backend import missing_library
from teleopctl.sim.mjcf import BallJoints

Picture = npt.NDArray[np.uint8]
Depths = npt.NDArray[np.float32]
Labels = npt.NDArray[np.uint16]

# MuJoCo draws the sky as a sphere at this fraction of the far plane's distance.
_SKY = 0.7


@dataclass(frozen=True)
class Quality:
    """Rendering quality: samples per pixel, shadow map and reflections.

    Attributes:
        name: Name of the quality in the log.
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


@dataclass(frozen=True)
class _Camera:
    """A camera with its projection and the buffers of its images."""

    model: CameraModel
    view: Projection
    colours: Picture
    depths: Depths
    look: Any


class CameraRenderer:
    """Renderer of a model's cameras with one OpenGL context, bound to the creating thread.

    Images are upright, of the camera's height and width, and distorted by its lens.

    Args:
        model: Model of the robot and its world.
        cameras: Cameras to render.
        quality: Rendering quality.

    Attributes:
        quality: Rendering quality.

    Raises:
        TeleopctlError: If a system library for drawing is missing.
    """

    def __init__(self, model: RobotModel, cameras: Sequence[CameraModel], quality: Quality) -> None:
        self.quality = quality
        self._m: Any = model.mj_model
        self._d: Any = mujoco.MjData(self._m)
        views = {camera.name: camera_projection(camera) for camera in cameras}
        offscreen = self._m.vis.global_
        drawn = [part for view in views.values() for part in view.drawn]
        offscreen.offwidth = max(part.width for part in drawn)
        offscreen.offheight = max(part.height for part in drawn)
        # Averaged over samples, the labels of two bodies would be that of a third.
        labels = any(camera.sees(what) for camera in cameras for what in ("labels", "boxes"))
        self._m.vis.quality.offsamples = 0 if labels else quality.samples
        self._m.vis.quality.shadowsize = quality.shadow_size
        try:
            self._gl = mujoco.GLContext(offscreen.offwidth, offscreen.offheight)
            self._gl.make_current()
            self._context = mujoco.MjrContext(self._m, mujoco.mjtFontScale.mjFONTSCALE_100)
        except (ImportError, AttributeError, RuntimeError, mujoco.FatalError) as error:
            raise missing_library(error) from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        # Twice the shapes: reflections, labels and the like are shapes too.
        self._scene = mujoco.MjvScene(self._m, 2 * self._m.ngeom + 1000)
        self._options = mujoco.MjvOption()
        self._perturbation = mujoco.MjvPerturb()
        self._cameras = {
            camera.name: self._camera(camera, views[camera.name]) for camera in cameras
        }
        self._address = {
            joint.name: int(self._m.joint(joint.name).qposadr[0])
            for joint in model.joints
            if not joint.ball
        }
        self._balls = BallJoints(model.joints)
        self._free = {
            body.link: int(self._m.joint(body.joint).qposadr[0]) for body in model.free_bodies
        }

    def place(
        self,
        positions: Mapping[str, float],
        bodies: Mapping[str, Sequence[float]] = MappingProxyType({}),
    ) -> None:
        """Set the joint positions and free bodies' poses that the next images show.

        Args:
            positions: Joint positions (rad or m) by name; unknown names are ignored, and joints
                without a name here keep their positions.
            bodies: Poses of free bodies in the world, by link: x y z in metres, then the rotation
                w x y z; unknown links are ignored, and other bodies keep their poses.
        """
        for name, position in positions.items():
            address = self._address.get(name)
            if address is not None:
                self._d.qpos[address] = position
        self._balls.put(self._d, positions)
        for link, pose in bodies.items():
            start = self._free.get(link)
            if start is not None:
                self._d.qpos[start : start + 7] = pose
        mujoco.mj_kinematics(self._m, self._d)
        mujoco.mj_comPos(self._m, self._d)
        mujoco.mj_camlight(self._m, self._d)

    def colours(self, camera: str, image: Picture) -> None:
        """Render a named camera's RGB image into the array ``image``, (height, width, 3)."""
        found = self._cameras[camera]
        flat, start = found.colours.reshape(-1, 3), 0
        for part in found.view.drawn:
            self._draw(found, part, measuring=False)
            end = start + part.width * part.height
            mujoco.mjr_readPixels(flat[start:end], None, _rectangle(part), self._context)
            start = end
        _through_lens(found, found.colours, image)

    def colours_and_depths(self, camera: str, image: Picture) -> Depths:
        """Render a named camera's RGB image into ``image``; return depths along the optical axis.

        Returns:
            Depths in metres, (height, width); infinite where nothing is visible.
        """
        found = self._cameras[camera]
        self._draw(found, found.view, measuring=True)
        rectangle = _rectangle(found.view)
        mujoco.mjr_readPixels(found.colours, found.depths, rectangle, self._context)
        _through_lens(found, found.colours, image)
        near, far = np.float32(found.model.near), np.float32(_drawn_far(found))
        buffer = np.zeros((found.model.height, found.model.width), np.float32)
        _through_lens(found, found.depths, buffer)
        # OpenGL's depth is 1 at the near plane and 0 at the far one, and falls with 1/z.
        depths: Depths = near * far / (near + buffer * (far - near))
        depths[depths > found.model.far] = np.inf
        return depths

    def labels(self, camera: str) -> Labels:
        """Render a named camera; return the body index that each pixel shows, 0 for background."""
        found, flags = self._cameras[camera], self._scene.flags
        before = flags.copy()
        flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = True
        flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
        try:
            self._draw(found, found.view, measuring=True)
        finally:
            np.copyto(flags, before)
        mujoco.mjr_readPixels(found.colours, None, _rectangle(found.view), self._context)
        low, middle, high = (found.colours[..., part].astype(np.int64) for part in range(3))
        shapes = low + (middle << 8) + (high << 16)
        bodies = np.zeros(self._scene.ngeom + 1, np.uint16)
        for shape in self._scene.geoms[: self._scene.ngeom]:
            if shape.segid >= 0 and shape.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                bodies[shape.segid + 1] = self._m.geom_bodyid[shape.objid]
        labels = np.zeros((found.model.height, found.model.width), np.uint16)
        _through_lens(found, bodies[np.minimum(shapes, self._scene.ngeom)], labels)
        return labels

    def close(self) -> None:
        """Free the renderer's OpenGL context."""
        self._gl.make_current()
        self._context.free()
        self._gl.free()

    def _camera(self, camera: CameraModel, view: Projection) -> _Camera:
        look = mujoco.MjvCamera()
        look.type = mujoco.mjtCamera.mjCAMERA_FIXED
        look.fixedcamid = self._m.camera(camera.name).id
        return _Camera(
            camera,
            view,
            np.zeros((view.height, view.width, 3), np.uint8),
            np.zeros((view.height, view.width), np.float32),
            look,
        )

    def _draw(self, camera: _Camera, view: Projection | Face, *, measuring: bool) -> None:
        self._gl.make_current()
        mujoco.mjv_updateScene(
            self._m, self._d, self._options, self._perturbation, camera.look,
            mujoco.mjtCatBit.mjCAT_ALL, self._scene,
        )  # fmt: skip
        near = camera.model.near
        for eye in self._scene.camera:
            eye.frustum_near, eye.frustum_far = near, _drawn_far(camera)
            eye.frustum_center = near * (view.left + view.right) / 2.0
            eye.frustum_width = near * (view.right - view.left) / 2.0
            eye.frustum_bottom, eye.frustum_top = near * view.bottom, near * view.top
            if isinstance(view, Face):
                ahead, up = np.array(eye.forward), np.array(eye.up)
                # The optical frame's axes in the world.
                axes = np.stack([np.cross(ahead, up), -up, ahead], axis=-1)
                eye.forward, eye.up = axes @ view.ahead, axes @ view.up
        flags = self._scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = self.quality.shadow_size > 0
        # Mirror images would be measured.
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = self.quality.reflections and not measuring
        mujoco.mjr_render(_rectangle(view), self._scene, self._context)


# Any: a type of MuJoCo's, which has no static one.
def _rectangle(part: Projection | Face) -> Any:
    return mujoco.MjrRect(0, 0, part.width, part.height)


def _drawn_far(camera: _Camera) -> float:
    """Return the far plane's distance at which the sky is behind all that the camera shows."""
    view = camera.view
    x, y = max(-view.left, view.right), max(-view.bottom, view.top)
    return camera.model.far * math.sqrt(1.0 + x * x + y * y) / _SKY


def _through_lens(camera: _Camera, drawn: npt.NDArray[Any], image: npt.NDArray[Any]) -> None:
    """Flip an image from OpenGL upright, and write it into another one through the lens."""
    pixels = camera.view.pixels
    if pixels is None:
        image[:] = drawn[::-1]
        return
    parts = image.shape[2:]
    count = camera.view.width * camera.view.height
    upright = np.zeros((count + 1, *parts), drawn.dtype)
    # The pixels of a cube's faces are numbered from their lowest rows on, as OpenGL draws them.
    turned = drawn if camera.view.faces else drawn[::-1]
    upright[:count] = turned.reshape(count, *parts)
    np.take(upright, pixels, axis=0, out=image.reshape(-1, *parts))


# Fraction of a frame's period that rendering may take; the rest is for publishing the image.
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
    """Return a renderer and a log line; quality ``auto`` takes the best that holds the frame rates.

    Args:
        model: Model of the robot and its world.
        cameras: Cameras to render.
        quality: ``full``, ``fast`` or ``auto``: the best that holds the cameras' rates.
        clock: Returns a time in seconds, for the measurement.

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
            f"Unknown quality '{quality}'", hint=f"Expected one of {', '.join(QUALITIES)}"
        )
    rate_hz = max(camera.rate_hz for camera in cameras)
    budget = _SHARE / rate_hz
    for candidate in _BEST_FIRST:
        renderer = CameraRenderer(model, cameras, candidate)
        # Time of all cameras per frame of the fastest camera.
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
    """Return the time of a frame in seconds, the median of a few after a warm-up frame."""
    picture = np.zeros((camera.height, camera.width, 3), np.uint8)

    def timed() -> float:
        started = clock()
        renderer.place({})
        renderer.colours(camera.name, picture)
        return clock() - started

    warm_up = timed()
    if warm_up > 10.0 * budget:
        # Too slow even if half of the time was for the driver to compile shaders.
        return warm_up
    return sorted(timed() for _ in range(_TIMED_FRAMES))[_TIMED_FRAMES // 2]
