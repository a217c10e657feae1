"""Ray casting from a sensor's site to the shapes of the model."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mujoco
import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from teleopctl.robot import Rays

Array = npt.NDArray[np.float64]

# Shapes in groups below this number are drawn; others are for physics alone.
_DRAWN_GROUPS = 3
_SEEN, _UNSEEN = 0, 1
_MASK = np.array([1, 0, 0, 0, 0, 0], np.uint8)
# The sunflower's angle: no two rays of a cone have the same azimuth.
_GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
# Rays that test whether a sensor is within a shape; askew, so as not to run along edges.
_FEELERS = np.array([[1, 0.13, 0.07], [0.11, 1, 0.05], [0.03, 0.17, 1]])
_FEELERS = np.concatenate([_FEELERS, -_FEELERS]) / np.linalg.norm(_FEELERS[0])


def directions(rays: Rays) -> Array:
    """Return the unit vectors of a lidar's rays, (vertical count, horizontal count, 3)."""
    h, v = rays.horizontal, rays.vertical
    azimuth = h.first + h.step * np.arange(h.count)
    elevation = (v.first + v.step * np.arange(v.count))[:, None]
    parts = (
        np.cos(elevation) * np.cos(azimuth),
        np.cos(elevation) * np.sin(azimuth),
        np.broadcast_to(np.sin(elevation), (v.count, h.count)),
    )
    return np.stack(parts, axis=-1)


def cone(half_angle: float, count: int) -> Array:
    """Return unit vectors that fill a cone along -z evenly, (count, 3).

    The first vector is the axis, the last vectors are at the rim.
    """
    number = np.arange(count)
    from_axis = half_angle * np.sqrt(number / (count - 1))
    around = number * _GOLDEN_ANGLE
    parts = (
        np.sin(from_axis) * np.cos(around),
        np.sin(from_axis) * np.sin(around),
        -np.cos(from_axis),
    )
    return np.stack(parts, axis=-1)


class RayCaster:
    """Caster of a fixed set of rays from a site of the model.

    Rays begin at the distance ``near`` and meet no nearer shapes. They do not meet shapes of the
    sensor's own link that enclose the sensor either: a lidar looks out of its own housing. All
    other shapes of the robot are met.

    Args:
        site: Name of the sensor's site, in whose axes the rays are.
        rays: Unit vectors, (n, 3).
        near: Distance at which rays begin, in metres.
        far: Distance at which rays end, in metres.
        solid: Whether rays meet collision shapes, as with Gazebo's `ray`, rather than drawn shapes,
            as with its `gpu_lidar`.
    """

    def __init__(self, site: str, rays: Array, near: float, far: float, *, solid: bool) -> None:
        self._site = site
        self._rays = rays.reshape(-1, 3)
        self._near = near
        self._far = far
        self._solid = solid
        self._model: mujoco.MjModel | None = None
        self._geoms = np.zeros(len(self._rays), np.int32)
        self._distances = np.zeros(len(self._rays))

    def cast(self, model: mujoco.MjModel, data: mujoco.MjData) -> Array:
        """Return each ray's distance to the nearest shape, in metres, (n,); infinite for none."""
        if model is not self._model:
            self._model, self._groups = model, self._groups_for(model, data)
        site = data.site(self._site)
        origin, rotation = np.array(site.xpos), site.xmat.reshape(3, 3)
        rays = self._rays @ rotation.T
        before = model.geom_group.copy()
        # The shapes that rays meet are selected by groups, which physics does not use.
        model.geom_group[:] = self._groups
        try:
            far = self._far if np.isfinite(self._far) else mujoco.mjMAXVAL
            mujoco.mj_multiRay(
                model, data, origin, rays.ravel(), _MASK, True, -1,
                self._geoms, self._distances, None, len(rays), far,
            )  # fmt: skip
            found: Array = np.where(self._distances < 0.0, np.inf, self._distances)
            for ray in np.flatnonzero(found < self._near):
                found[ray] = self._beyond(model, data, origin, rays[ray])
        finally:
            model.geom_group[:] = before
        found[found > self._far] = np.inf
        return found

    def _beyond(
        self, model: mujoco.MjModel, data: mujoco.MjData, origin: Array, ray: Array
    ) -> float:
        """Return the distance to the nearest shape beyond ``near`` on a ray; infinite for none."""
        start = origin + self._near * ray
        distance = mujoco.mj_ray(model, data, start, ray, _MASK, True, -1, None)
        return self._near + distance if distance >= 0.0 else np.inf

    def _groups_for(self, model: mujoco.MjModel, data: mujoco.MjData) -> npt.NDArray[np.int32]:
        if self._solid:
            seen = (model.geom_contype | model.geom_conaffinity) != 0
        else:
            seen = model.geom_group < _DRAWN_GROUPS
        groups = np.where(seen, _SEEN, _UNSEEN).astype(np.int32)
        body = model.site(self._site).bodyid[0]
        carrier = model.body_weldid[body]
        # A fixed sensor may be in a room, whose walls are welded to the world like the sensor.
        near_by = model.body_weldid[model.geom_bodyid] == carrier
        own = near_by if carrier != 0 else model.geom_bodyid == body
        for geom in np.flatnonzero(seen & own) if body != 0 else ():
            if self._is_inside(model, data, int(geom)):
                groups[geom] = _UNSEEN
        return groups

    def _is_inside(self, model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> bool:
        """Whether a shape encloses the sensor: all test rays meet it."""
        origin = np.array(data.site(self._site).xpos)
        place, turn = data.geom_xpos[geom], data.geom_xmat[geom]
        kind = model.geom_type[geom]
        for ray in _FEELERS:
            if kind == mujoco.mjtGeom.mjGEOM_MESH:
                distance = mujoco.mj_rayMesh(model, data, geom, origin, ray)
            elif kind in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
                return False
            else:
                distance = mujoco.mju_rayGeom(
                    place, turn, model.geom_size[geom], origin, ray, int(kind)
                )
            if distance < 0.0:
                return False
        return True
