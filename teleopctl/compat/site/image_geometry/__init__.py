"""``image_geometry``. Cameras by their calibration: pixels and points in space."""

from image_geometry.cameramodels import PinholeCameraModel, StereoCameraModel

__all__ = ["PinholeCameraModel", "StereoCameraModel"]
