"""What a lens does to a picture: the model ``plumb_bob`` of sensor_msgs/CameraInfo.

A point of the scene at (X, Y, Z) in the optical frame is at x = X/Z, y = Y/Z without a lens. With
one it is, with r² = x² + y², at

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
    y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y

and in the pixel (fx x' + cx, fy y' + cy). OpenGL draws without a lens. So a picture is drawn that
is large enough, and each pixel is taken from where it belongs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import CameraModel

Array = npt.NDArray[np.float64]

_ITERATIONS = 30
# Pixels whose light cannot be told apart more precisely than this are outside the lens.
_PRECISE_PX = 0.1
# A lens that shows more than this many times the picture's width is cut off there.
_LARGEST = 2.0


def distorted(
    x: Array, y: Array, lens: tuple[float, float, float, float, float]
) -> tuple[Array, Array]:
    """Where points at x = X/Z, y = Y/Z are with a lens k1, k2, p1, p2, k3."""
    k1, k2, p1, p2, k3 = lens
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return (
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


@dataclass(frozen=True)
class View:
    """A picture as it is drawn, before a lens.

    Attributes:
        width: In pixels, as for ``height``.
        height: See there.
        left: Where the left edge is at x = X/Z; ``right``, ``top`` and ``bottom`` alike, y upwards.
        right: See there.
        bottom: See there.
        top: See there.
        pixels: For each pixel of the final picture, row by row, the number of the drawn one; those
            that see nothing have the number ``width * height``. None where there is no lens.
    """

    width: int
    height: int
    left: float
    right: float
    bottom: float
    top: float
    pixels: npt.NDArray[np.int64] | None = None


def view_of(camera: CameraModel) -> View:
    """How a camera's picture is drawn."""
    fx, _, cx, _, fy, cy, *_ = camera.intrinsics
    width, height = camera.width, camera.height
    if not any(camera.distortion):
        return _edges(width, height, fx, fy, cx, cy)
    x, y, seen = undistorted(camera)
    reach_x, reach_y = _LARGEST * width / fx, _LARGEST * height / fy
    seen &= (np.abs(x) < reach_x) & (np.abs(y) < reach_y)
    low_x, high_x = (fx * edge for edge in (x[seen].min(), x[seen].max()))
    low_y, high_y = (fy * edge for edge in (y[seen].min(), y[seen].max()))
    # The centre of the first drawn pixel, in pixels from the axis.
    first_x, first_y = np.floor(low_x), np.floor(low_y)
    drawn_width = int(np.ceil(high_x) - first_x) + 1
    drawn_height = int(np.ceil(high_y) - first_y) + 1
    column = np.rint(fx * np.where(seen, x, 0.0) - first_x).astype(np.int64)
    row = np.rint(fy * np.where(seen, y, 0.0) - first_y).astype(np.int64)
    pixels = np.where(seen, row * drawn_width + column, drawn_width * drawn_height)
    edges = _edges(drawn_width, drawn_height, fx, fy, -first_x, -first_y)
    return View(
        edges.width, edges.height, edges.left, edges.right, edges.bottom, edges.top, pixels.ravel()
    )


def _edges(width: int, height: int, fx: float, fy: float, cx: float, cy: float) -> View:
    # Pixel (0, 0) is the centre of the upper left pixel.
    return View(
        width,
        height,
        left=-(cx + 0.5) / fx,
        right=(width - 0.5 - cx) / fx,
        bottom=-(height - 0.5 - cy) / fy,
        top=(cy + 0.5) / fy,
    )


def undistorted(camera: CameraModel) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """Which points X/Z and Y/Z each pixel shows, and whether it shows any; by Newton's method."""
    fx, _, cx, _, fy, cy, *_ = camera.intrinsics
    columns, rows = np.meshgrid(np.arange(float(camera.width)), np.arange(float(camera.height)))
    wanted_x, wanted_y = (columns - cx) / fx, (rows - cy) / fy
    x, y = wanted_x.copy(), wanted_y.copy()
    if not any(camera.distortion):
        return x, y, np.ones(x.shape, np.bool_)
    step = 1e-6
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            at_x, at_y = distorted(x, y, camera.distortion)
            xx, yx = distorted(x + step, y, camera.distortion)
            xy, yy = distorted(x, y + step, camera.distortion)
            a, b, c, d = ((xx - at_x), (xy - at_x), (yx - at_y), (yy - at_y))
            error_x, error_y = at_x - wanted_x, at_y - wanted_y
            scale: Array = step / (a * d - b * c)
            x -= scale * (d * error_x - b * error_y)
            y -= scale * (a * error_y - c * error_x)
        at_x, at_y = distorted(x, y, camera.distortion)
        seen = np.hypot(fx * (at_x - wanted_x), fy * (at_y - wanted_y)) < _PRECISE_PX
        # Beyond its fold a lens shows the same again, turned: not what is seen there.
        seen &= (x * wanted_x + y * wanted_y >= 0.0) & (a * d - b * c > 0.0)
    return x, y, seen
