"""Sensor types ``ray``, ``gpu_ray``, ``lidar``, ``gpu_lidar`` and ``sonar``."""

from __future__ import annotations

import array
import contextlib
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.errors import InvalidDescriptionError
from teleopctl.interfaces import get_message
from teleopctl.robot import Noise, Rays, RaySweep
from teleopctl.sim.sensors.base import Sensor
from teleopctl.sim.sensors.rays import RayCaster, cone, directions

if TYPE_CHECKING:
    from teleopctl.robot import SensorTag as Description

Array = npt.NDArray[np.float64]

_SCAN, _CLOUD, _RANGE = (
    f"sensor_msgs/msg/{name}" for name in ("LaserScan", "PointCloud2", "Range")
)
# Messages of Gazebo's plug-ins without an `<output_type>`.
_OUTPUTS = {
    "gazebo_ros_gpu_laser": _SCAN,
    "gazebo_ros_laser": _SCAN,
    "gazebo_ros_range": _RANGE,
    "gazebo_ros_ray_sensor": _CLOUD,
}
_RADIATION = {"ultrasound": 0, "infrared": 1}
# Number of rays in a sonar's cone: with 30 degrees, the next ray is at most 2 cm away at 1 m.
_CONE_RAYS = 700

# Points as of gz and of drivers of rotating lidars: metres, and the number of the ring from below.
_POINT = np.dtype(
    {
        "names": ["x", "y", "z", "intensity", "ring"],
        "formats": ["<f4", "<f4", "<f4", "<f4", "<u2"],
        "offsets": [0, 4, 8, 12, 16],
        "itemsize": 20,
    }
)
_FLOAT32, _UINT16 = 7, 4


class Lidar(Sensor):
    """Lidar or sonar: distances along rays from one point, as scan, cloud or range.

    Without a plug-in, a LaserScan is published on the topic and a PointCloud2 on ``TOPIC/points``,
    as from gz; with a plug-in of Gazebo classic, its ``<output_type>``. Rays of `ray` meet
    collision shapes, those of `gpu_ray` and `gpu_lidar` drawn shapes. Nothing is seen nearer than
    ``<min>``; a ray that meets nothing up to ``<max>`` gives infinity in a scan and NaN in a cloud
    (REP 117, REP 118).

    Args:
        description: The ``<sensor>`` tag.
        output: Type of the message; by default that of the description.
    """

    def __init__(self, description: Description, output: str = "") -> None:
        super().__init__(description)
        self._rays = self._described_rays()
        if deviation := self._of_plugin("gaussianNoise"):
            # The plug-in's noise adds to that of the rays.
            noise = next((n for n in map(description.noise.get, ("ray", "lidar")) if n), Noise())
            whole = replace(noise, stddev=math.hypot(noise.stddev, deviation))
            self.description = replace(description, noise={**description.noise, "ray": whole})
        self._wanted = output or self._described_output()
        self.message_type = self._wanted
        self._directions = directions(self._rays)
        if self._is_sonar:
            self._directions = cone(self._rays.horizontal.last, _CONE_RAYS)[None]
        if self._wanted == _SCAN:
            # A scan is flat: of several rings, the one that is nearest to the horizontal.
            v = self._rays.vertical
            ring = int(np.argmin(np.abs(v.first + v.step * np.arange(v.count))))
            self._directions = self._directions[ring : ring + 1]
        self._caster = RayCaster(
            self.name,
            self._directions,
            self._rays.near,
            self._rays.far,
            solid=description.type in ("ray", "sonar"),
        )

    @property
    def topic(self) -> str:
        """Name of the published topic; ends in ``/points`` for Gazebo's additional point cloud."""
        below = self._wanted == _CLOUD and not self.names.has_plugin
        return f"{super().topic}/points" if below else super().topic

    def companions(self) -> Sequence[Sensor]:
        """Return one more lidar for a scan's point cloud; empty if a plug-in sets the message."""
        if self.names.has_plugin or self._wanted != _SCAN:
            return ()
        return (Lidar(self.description, _CLOUD),)

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the site where the rays start to a MuJoCo spec, before it is compiled."""
        if spec.site(self.name) is None:
            self.add_site(spec)

    # Any: as the base class has it.
    def read(self, model: mujoco.MjModel, data: mujoco.MjData, message: Any) -> None:
        """Cast the rays, and fill a LaserScan, PointCloud2 or Range message."""
        distances = self._caster.cast(model, data)
        rays, met = self._rays, np.isfinite(distances)
        measured = self.noise("ray", "lidar", "sonar").add_noise(distances, float(data.time))
        measured = np.where(met, np.clip(measured, rays.near, rays.far), np.inf)
        if self._wanted == _SCAN:
            self._fill_scan(message, measured)
        elif self._wanted == _RANGE:
            self._fill_range(message, measured)
        else:
            self._fill_cloud(message, np.where(met, measured, np.nan))

    def _fill_scan(self, message: Any, distances: Array) -> None:
        sweep, rate = self._rays.horizontal, self.description.update_rate
        message.angle_min, message.angle_max = sweep.first, sweep.last
        message.angle_increment = sweep.step
        message.scan_time = 1.0 / rate if rate else 0.0
        message.range_min, message.range_max = self._rays.near, self._rays.far
        message.ranges = array.array("f", distances.astype("<f4").tobytes())
        message.intensities = array.array("f", bytes(4 * len(distances)))

    def _fill_range(self, message: Any, distances: Array) -> None:
        h, v = self._rays.horizontal, self._rays.vertical
        radiation = self.names.setting("radiation_type", "radiation").lower()
        message.radiation_type = _RADIATION.get(radiation, 0 if self._is_sonar else 1)
        message.field_of_view = max(h.last - h.first, v.last - v.first)
        message.min_range, message.max_range = self._rays.near, self._rays.far
        message.range = float(distances.min())

    def _fill_cloud(self, message: Any, distances: Array) -> None:
        rings, columns, _ = self._directions.shape
        points = np.zeros((rings, columns), _POINT)
        places = self._directions * distances.reshape(rings, columns, 1)
        for axis, name in enumerate("xyz"):
            points[name] = places[..., axis]
        points["ring"] = np.arange(rings)[:, None]
        message.height, message.width = rings, columns
        message.fields = _fields()
        message.point_step, message.row_step = _POINT.itemsize, _POINT.itemsize * columns
        message.is_dense = bool(np.isfinite(distances).all())
        message.data = array.array("B", points.tobytes())

    # --- the description ----------------------------------------------------------------------

    @property
    def _is_sonar(self) -> bool:
        return self.description.type == "sonar"

    def _described_rays(self) -> Rays:
        if not self._is_sonar:
            rays = self.description.rays
            if rays is None:
                raise InvalidDescriptionError("it has no <ray> or <lidar>")
            # A plug-in may limit the range of the rays further, like that of Velodyne's lidars.
            least, most = (self._of_plugin(tag) for tag in ("min_range", "max_range"))
            far = min(rays.far, most or math.inf)
            return replace(rays, near=max(rays.near, least or 0.0), far=far)
        near, far, radius = (self._of_sonar(tag) for tag in ("min", "max", "radius"))
        half = math.atan2(radius, far)
        across = RaySweep(1, -half, half)
        return Rays(across, across, near, far)

    def _of_plugin(self, tag: str) -> float | None:
        """Return the number in a tag of the sensor's plug-in, or None."""
        with contextlib.suppress(ValueError):
            return float(self.names.setting(tag))
        return None

    def _of_sonar(self, tag: str) -> float:
        try:
            return float(self.description.texts[f"sonar/{tag}"])
        except (KeyError, ValueError) as error:
            raise InvalidDescriptionError(f"<sonar> has no number <{tag}>") from error

    def _described_output(self) -> str:
        if self._is_sonar:
            return _RANGE
        requested = self.names.setting("output_type", "outputType")
        if requested:
            wanted = f"sensor_msgs/msg/{requested.rpartition('/')[2]}"
            if wanted not in (_SCAN, _CLOUD, _RANGE):
                raise InvalidDescriptionError(
                    f"<output_type> is '{requested}': one of sensor_msgs/LaserScan, "
                    "sensor_msgs/PointCloud2, sensor_msgs/Range"
                )
            return wanted
        file = self.names.plugin_file.rpartition("/")[2].removeprefix("lib").removesuffix(".so")
        return _OUTPUTS.get(file, _CLOUD if file else _SCAN)


# Any: a class that is made from its definition.
def _fields() -> list[Any]:
    field = get_message("sensor_msgs/msg/PointField")
    return [
        field(name=name, offset=offset, datatype=kind, count=1)
        for name, offset, kind in (
            ("x", 0, _FLOAT32),
            ("y", 4, _FLOAT32),
            ("z", 8, _FLOAT32),
            ("intensity", 12, _FLOAT32),
            ("ring", 16, _UINT16),
        )
    ]
