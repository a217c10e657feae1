"""Points on the earth's ellipsoid (WGS 84), for satellite navigation and air pressure."""

from __future__ import annotations

import math
from typing import NamedTuple

_EQUATOR_M = 6_378_137.0
_FLATTENING = 1.0 / 298.257223563
_ECCENTRICITY2 = _FLATTENING * (2.0 - _FLATTENING)
# Each iteration gains about three digits.
_ITERATIONS = 6


class GeoPoint(NamedTuple):
    """Point on the earth: latitude and longitude in degrees, metres above the ellipsoid."""

    latitude: float = 0.0
    longitude: float = 0.0
    altitude_m: float = 0.0

    def offset(self, east: float, north: float, up: float) -> GeoPoint:
        """Return the point that is so many metres to the east, north and up of this one."""
        lat, lon = math.radians(self.latitude), math.radians(self.longitude)
        radius = _across(lat)
        # From the earth's centre, along its own axes (ECEF).
        outwards = math.cos(lat) * up - math.sin(lat) * north
        along = (radius + self.altitude_m) * math.cos(lat) + outwards
        x = along * math.cos(lon) - math.sin(lon) * east
        y = along * math.sin(lon) + math.cos(lon) * east
        z = (radius * (1.0 - _ECCENTRICITY2) + self.altitude_m) * math.sin(lat)
        z += math.cos(lat) * north + math.sin(lat) * up
        return _on_ellipsoid(x, y, z)


def _across(latitude: float) -> float:
    """Return the radius of curvature across the meridian, in metres, at a latitude in radians."""
    return _EQUATOR_M / math.sqrt(1.0 - _ECCENTRICITY2 * math.sin(latitude) ** 2)


def _on_ellipsoid(x: float, y: float, z: float) -> GeoPoint:
    """Return the point at ECEF coordinates in metres, by Bowring's iteration."""
    distance = math.hypot(x, y)
    lat = math.atan2(z, distance * (1.0 - _ECCENTRICITY2))
    for _ in range(_ITERATIONS):
        lat = math.atan2(z + _ECCENTRICITY2 * _across(lat) * math.sin(lat), distance)
    radius = _across(lat)
    altitude = distance * math.cos(lat) + z * math.sin(lat)
    altitude -= radius * (1.0 - _ECCENTRICITY2 * math.sin(lat) ** 2)
    return GeoPoint(math.degrees(lat), math.degrees(math.atan2(y, x)), altitude)
