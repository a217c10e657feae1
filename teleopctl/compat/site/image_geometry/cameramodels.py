"""``image_geometry.cameramodels``. Pinhole and stereo cameras.

Points are in the camera's optical frame: x to the right, y down, z forwards, in metres. Pixels
(u, v) are those of the rectified image. Source: sensor_msgs/msg/CameraInfo; Hartley and Zisserman,
Multiple View Geometry, chapter 6.
"""

import copy
import math
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from sensor_msgs.msg import CameraInfo, RegionOfInterest

from teleopctl.errors import UnavailableError

__all__ = ["PinholeCameraModel", "StereoCameraModel"]

# Any, here and below: matrices and images of numpy, and OpenCV's module.


def _matrix(values: Any, rows: int, columns: int) -> Any:
    """Return values as numpy's matrix class, whose product is that of matrices, as ROS 2 does."""
    return np.array(values, dtype=np.float64).reshape(rows, columns).view(np.matrix)


def _opencv() -> Any:
    try:
        import cv2  # type: ignore[import-not-found]  # an optional library
    except ImportError as error:
        raise UnavailableError(
            "rectifying images and points needs OpenCV", hint="pip install opencv-python-headless"
        ) from error
    return cv2


class PinholeCameraModel:
    """Pinhole camera: straight lines stay straight in rectified images.

    Attributes:
        K: Intrinsic matrix (3, 3) of the raw image, for binning and region of interest.
        D: Distortion coefficients (n, 1), or None.
        R: Rotation (3, 3) from the camera to the rectified camera.
        P: Projection (3, 4) to the rectified image, for binning and region of interest.
        width: Width of the full image in pixels.
        height: Height of the full image in pixels.
    """

    def __init__(self) -> None:
        self.K: Any = None
        self.D: Any = None
        self.R: Any = None
        self.P: Any = None
        self.full_K: Any = None
        self.full_P: Any = None
        self.width = 0
        self.height = 0
        self.binning_x = 1
        self.binning_y = 1
        self.resolution = (0, 0)
        self.raw_roi: RegionOfInterest | None = None
        self.tf_frame = ""
        self.stamp: Time | None = None

    def fromCameraInfo(self, msg: CameraInfo) -> None:
        """Take the calibration of a message."""
        self.full_K, self.full_P = _matrix(msg.k, 3, 3), _matrix(msg.p, 3, 4)
        self.K, self.P = self.full_K.copy(), self.full_P.copy()
        self.D = _matrix(msg.d, len(msg.d), 1) if len(msg.d) else None
        self.R = _matrix(msg.r, 3, 3)
        self.width, self.height = msg.width, msg.height
        self.resolution = (msg.width, msg.height)
        self.binning_x, self.binning_y = max(1, msg.binning_x), max(1, msg.binning_y)
        roi = self.raw_roi = copy.copy(msg.roi)
        # A region of zeros is the whole image.
        if not (roi.x_offset or roi.y_offset or roi.width or roi.height):
            roi.width, roi.height = msg.width, msg.height
        self.tf_frame, self.stamp = msg.header.frame_id, msg.header.stamp
        for matrix in (self.K, self.P):
            matrix[0, 0] /= self.binning_x
            matrix[1, 1] /= self.binning_y
            matrix[0, 2] = (matrix[0, 2] - roi.x_offset) / self.binning_x
            matrix[1, 2] = (matrix[1, 2] - roi.y_offset) / self.binning_y

    def rectifyImage(self, raw: Any, rectified: Any) -> None:
        """Write the rectified image of a raw one into an array of the same size.

        Raises:
            UnavailableError: OpenCV is not installed.
        """
        cv2 = _opencv()
        size = (self.width, self.height)
        maps = cv2.initUndistortRectifyMap(self.K, self.D, self.R, self.P, size, cv2.CV_32FC1)
        cv2.remap(raw, *maps, cv2.INTER_CUBIC, rectified)

    def rectifyPoint(self, uv_raw: tuple[float, float]) -> Any:
        """Return the rectified pixel (u, v) of a raw one.

        Raises:
            UnavailableError: OpenCV is not installed.
        """
        source = np.array(uv_raw, dtype=np.float64).reshape(1, 1, 2)
        return _opencv().undistortPoints(source, self.K, self.D, R=self.R, P=self.P)[0, 0]

    def project3dToPixel(self, point: tuple[float, float, float]) -> tuple[float, float]:
        """Return the pixel of a point; not-a-numbers for a point in the plane of the camera.

        (u, v, 1) w = P (x, y, z, 1)
        """
        u, v, w = np.asarray(self.P) @ (*point[:3], 1.0)
        return (float(u / w), float(v / w)) if w else (math.nan, math.nan)

    def projectPixelTo3dRay(self, uv: tuple[float, float]) -> tuple[float, float, float]:
        """Return the unit vector from the camera through a pixel."""
        x, y = (uv[0] - self.cx()) / self.fx(), (uv[1] - self.cy()) / self.fy()
        norm = math.sqrt(x * x + y * y + 1.0)
        return (x / norm, y / norm, 1.0 / norm)

    def getDeltaU(self, deltaX: float, Z: float) -> float:
        """Return the pixels of a length along x at a depth; infinite at depth 0."""
        return self.fx() * deltaX / Z if Z else math.inf

    def getDeltaV(self, deltaY: float, Z: float) -> float:
        """Return the pixels of a length along y at a depth; infinite at depth 0."""
        return self.fy() * deltaY / Z if Z else math.inf

    def getDeltaX(self, deltaU: float, Z: float) -> float:
        """Return the length along x of pixels at a depth."""
        return Z * deltaU / self.fx()

    def getDeltaY(self, deltaV: float, Z: float) -> float:
        """Return the length along y of pixels at a depth."""
        return Z * deltaV / self.fy()

    def fullResolution(self) -> tuple[int, int]:
        """Return width and height of the full image in pixels."""
        return self.resolution

    def intrinsicMatrix(self) -> Any:
        """Return the intrinsic matrix `K`."""
        return self.K

    def distortionCoeffs(self) -> Any:
        """Return the distortion coefficients `D`."""
        return self.D

    def rotationMatrix(self) -> Any:
        """Return the rotation `R`."""
        return self.R

    def projectionMatrix(self) -> Any:
        """Return the projection `P`."""
        return self.P

    def fullIntrinsicMatrix(self) -> Any:
        """Return the intrinsic matrix of the full image."""
        return self.full_K

    def fullProjectionMatrix(self) -> Any:
        """Return the projection to the full image."""
        return self.full_P

    def cx(self) -> float:
        """Return u of the principal point in pixels."""
        return float(self.P[0, 2])

    def cy(self) -> float:
        """Return v of the principal point in pixels."""
        return float(self.P[1, 2])

    def fx(self) -> float:
        """Return the focal length along u in pixels."""
        return float(self.P[0, 0])

    def fy(self) -> float:
        """Return the focal length along v in pixels."""
        return float(self.P[1, 1])

    def Tx(self) -> float:
        """Return the translation term of the projection along u: -fx times the baseline."""
        return float(self.P[0, 3])

    def Ty(self) -> float:
        """Return the translation term of the projection along v."""
        return float(self.P[1, 3])

    def fovX(self) -> float:
        """Return the horizontal field of view in radians."""
        return 2.0 * math.atan(self.width / (2.0 * self.fx()))

    def fovY(self) -> float:
        """Return the vertical field of view in radians."""
        return 2.0 * math.atan(self.height / (2.0 * self.fy()))

    def tfFrame(self) -> str:
        """Return the frame of the camera."""
        return self.tf_frame


class StereoCameraModel:
    """Two rectified cameras beside each other.

    Attributes:
        left: Left camera, whose frame the points are in.
        right: Right camera, whose projection has the baseline.
        Q: Matrix (4, 4) from (u, v, disparity, 1) to a point in homogeneous coordinates.
    """

    def __init__(self) -> None:
        self.left = PinholeCameraModel()
        self.right = PinholeCameraModel()
        self.Q: Any = None

    def fromCameraInfo(self, left_msg: CameraInfo, right_msg: CameraInfo) -> None:
        """Take the calibrations of two messages."""
        self.left.fromCameraInfo(left_msg)
        self.right.fromCameraInfo(right_msg)
        baseline = -self.right.Tx() / self.right.fx()
        self.Q = np.zeros((4, 4))
        self.Q[0, 0] = self.Q[1, 1] = 1.0
        self.Q[0, 3], self.Q[1, 3] = -self.right.cx(), -self.right.cy()
        self.Q[2, 3] = self.right.fx()
        self.Q[3, 2] = 1.0 / baseline

    def tfFrame(self) -> str:
        """Return the frame of the points: that of the left camera."""
        return self.left.tfFrame()

    def project3dToPixel(
        self, point: tuple[float, float, float]
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the pixels of a point in the left and the right image."""
        return self.left.project3dToPixel(point), self.right.project3dToPixel(point)

    def projectPixelTo3d(
        self, left_uv: tuple[float, float], disparity: float
    ) -> tuple[float, float, float]:
        """Return the point of a pixel of the left image; zeros for a disparity of 0."""
        x, y, z, w = self.Q @ (left_uv[0], left_uv[1], disparity, 1.0)
        return (float(x / w), float(y / w), float(z / w)) if w else (0.0, 0.0, 0.0)

    def getZ(self, disparity: float) -> float:
        """Return the depth of a disparity; infinite for 0."""
        return -self.right.Tx() / disparity if disparity else math.inf

    def getDisparity(self, Z: float) -> float:
        """Return the disparity of a depth; infinite for 0."""
        return -self.right.Tx() / Z if Z else math.inf
