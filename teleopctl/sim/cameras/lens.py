"""Lens distortion of camera images: the model ``plumb_bob`` of sensor_msgs/CameraInfo.

Without a lens, a point of the scene at (X, Y, Z) in the optical frame is at x = X/Z, y = Y/Z in the
image. With a lens it is, with r² = x² + y², at

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
    y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y

and in the pixel (fx x' + cx, fy y' + cy). OpenGL renders without a lens. So an image is rendered
that is large enough, and each pixel of the camera is taken from its place in that image. A wide
angle camera's view does not fit into a plane: the faces of a cube around the camera are rendered.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from teleopctl.mujoco_model import CameraModel
from teleopctl.robot import Lens

Array = npt.NDArray[np.float64]

_ITERATIONS = 30
# Pixels whose distortion cannot be inverted more precisely than this are outside the lens.
_PRECISE_PX = 0.1
# Largest face of a wide angle camera's cube, in pixels along an edge.
_LARGEST_FACE = 2048
_X, _Y, _Z = np.eye(3)
# Viewing and up directions in the optical frame: ahead, left, right, up, down and back.
_FACES = ((_Z, -_Y), (-_X, -_Y), (_X, -_Y), (-_Y, -_Z), (_Y, _Z), (-_Z, -_Y))
_INVERSES: dict[str, Callable[[Array], Array]] = {
    "tan": np.arctan,
    "sin": np.arcsin,
    "id": np.positive,
}
# A lens that shows more than this multiple of the image's width is cut off there.
_LARGEST = 2.0


def distorted(
    x: Array, y: Array, lens: tuple[float, float, float, float, float]
) -> tuple[Array, Array]:
    """Return normalized image coordinates x, y distorted by plumb_bob (k1, k2, p1, p2, k3)."""
    k1, k2, p1, p2, k3 = lens
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return (
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


@dataclass(frozen=True)
class Projection:
    """Frustum in which a camera is rendered, and the mapping of its pixels through the lens.

    Attributes:
        width: Width in pixels.
        height: Height in pixels.
        left: Left edge, X/Z.
        right: Right edge, X/Z.
        bottom: Lower edge, -Y/Z.
        top: Upper edge, -Y/Z.
        pixels: For each pixel of the final image, row by row, the number of the rendered pixel;
            ``width * height`` for pixels without a ray. None without a lens.
        faces: Faces of a cube that the view consists of; their pixels are numbered one face after
            the other, each from the lowest row on. Empty for a single image that looks ahead.
    """

    width: int
    height: int
    left: float
    right: float
    bottom: float
    top: float
    pixels: npt.NDArray[np.int64] | None = None
    faces: tuple[Face, ...] = ()

    @property
    def drawn(self) -> Sequence[Projection | Face]:
        """Frustums to render: faces of a cube for a wide-angle lens, else this projection."""
        return self.faces or (self,)


@dataclass(frozen=True)
class Face:
    """Frustum of one face of the cube that a wide-angle camera is rendered on.

    Attributes:
        ahead: Viewing direction in the optical frame.
        up: Upward direction of the image in the optical frame.
        width: Width in pixels.
        height: Height in pixels.
        left: Left edge, divided by the distance ahead, to the right.
        right: Right edge, divided by the distance ahead, to the right.
        bottom: Lower edge, divided by the distance ahead, upwards.
        top: Upper edge, divided by the distance ahead, upwards.
    """

    ahead: Array
    up: Array
    width: int
    height: int
    left: float
    right: float
    bottom: float
    top: float


def camera_projection(camera: CameraModel) -> Projection:
    """Return the projection in which a camera is to be rendered so that its lens can be applied."""
    if camera.lens is not None:
        return _cube(camera, camera.lens)
    fx, _, cx, _, fy, cy, *_ = camera.intrinsics
    width, height = camera.width, camera.height
    if not any(camera.distortion):
        return _edges(width, height, fx, fy, cx, cy)
    x, y, seen = undistorted(camera)
    reach_x, reach_y = _LARGEST * width / fx, _LARGEST * height / fy
    seen &= (np.abs(x) < reach_x) & (np.abs(y) < reach_y)
    low_x, high_x = (fx * edge for edge in (x[seen].min(), x[seen].max()))
    low_y, high_y = (fy * edge for edge in (y[seen].min(), y[seen].max()))
    # The centre of the first rendered pixel, in pixels from the axis.
    first_x, first_y = np.floor(low_x), np.floor(low_y)
    drawn_width = int(np.ceil(high_x) - first_x) + 1
    drawn_height = int(np.ceil(high_y) - first_y) + 1
    column = np.rint(fx * np.where(seen, x, 0.0) - first_x).astype(np.int64)
    row = np.rint(fy * np.where(seen, y, 0.0) - first_y).astype(np.int64)
    pixels = np.where(seen, row * drawn_width + column, drawn_width * drawn_height)
    edges = _edges(drawn_width, drawn_height, fx, fy, -first_x, -first_y)
    return Projection(
        edges.width, edges.height, edges.left, edges.right, edges.bottom, edges.top, pixels.ravel()
    )


def _cube(camera: CameraModel, lens: Lens) -> Projection:
    """Return the projection of a wide angle camera: the visible faces of a cube."""
    seen_from = directions(camera, lens)
    seen = np.isfinite(seen_from).all(axis=-1)
    along = np.stack([np.where(seen, seen_from @ forwards, -np.inf) for forwards, _ in _FACES])
    nearest = np.argmax(along, axis=0)
    used = [face for face in range(len(_FACES)) if (seen & (nearest == face)).any()]
    side = _side_of_faces(camera, lens)
    pixels = np.full(seen.shape, -1, np.int64)
    faces, count = [], 0
    for face in used:
        here = seen & (nearest == face)
        ahead, up = _FACES[face]
        d = seen_from[here] / (seen_from[here] @ ahead)[:, None]
        # In pixels of the whole face, the lowest row first; only the visible part is rendered.
        column, row = (
            np.clip(np.rint((d @ axis + 1.0) / 2.0 * side - 0.5), 0, side - 1).astype(np.int64)
            for axis in (np.cross(ahead, up), up)
        )
        first_column, first_row = int(column.min()), int(row.min())
        width, height = int(column.max()) - first_column + 1, int(row.max()) - first_row + 1
        left, bottom = 2.0 * first_column / side - 1.0, 2.0 * first_row / side - 1.0
        right, top = left + 2.0 * width / side, bottom + 2.0 * height / side
        faces.append(Face(ahead, up, width, height, left, right, bottom, top))
        pixels[here] = count + (row - first_row) * width + column - first_column
        count += width * height
    pixels[pixels < 0] = count
    return Projection(count, 1, -1.0, 1.0, -1.0, 1.0, pixels.ravel(), tuple(faces))


def directions(camera: CameraModel, lens: Lens) -> Array:
    """Return the unit vectors that a wide-angle camera's pixels look along; NaN outside the lens.

    Returns:
        Unit vectors, (height, width, 3); NaN for pixels without a ray.
    """
    _, _, cx, _, _, cy, *_ = camera.intrinsics
    columns, rows = np.meshgrid(np.arange(float(camera.width)), np.arange(float(camera.height)))
    x, y = columns - cx, rows - cy
    radius = np.hypot(x, y)
    with np.errstate(invalid="ignore"):
        inverse = _INVERSES[lens.fun](radius / (camera.width / 2.0) / (lens.c1 * lens.f))
        theta = lens.c2 * (inverse - lens.c3)
        theta[~((theta >= 0.0) & (theta <= min(lens.cutoff, np.pi)))] = np.nan
    outwards = np.sin(theta) / np.where(radius > 0.0, radius, 1.0)
    return np.stack([x * outwards, y * outwards, np.cos(theta)], axis=-1)


def _side_of_faces(camera: CameraModel, lens: Lens) -> int:
    """Return the pixels along an edge of the cube, for the finest resolution in the image."""
    angles = np.linspace(1e-3, min(camera.horizontal_fov / 2.0, lens.cutoff, np.pi - 1e-3), 100)
    radii = np.array([lens.radius(float(angle)) for angle in angles]) * camera.width / 2.0
    finest = max(np.gradient(radii, angles).max(), (radii / np.sin(angles))[angles < 2.0].max())
    # The middle of a face has half as many pixels per radian.
    return int(min(_LARGEST_FACE, np.ceil(2.0 * finest)))


def fisheye_coefficients(camera: CameraModel, lens: Lens) -> tuple[float, float, float, float]:
    """Return k1 to k4 of the ``equidistant`` model in CameraInfo, fitted to a wide-angle lens.

    A direction theta from the axis is at theta (1 + k1 theta² + k2 theta⁴ + k3 theta⁶ + k4 theta⁸)
    focal lengths from the middle.
    """
    reach = min(lens.cutoff, np.pi, camera.horizontal_fov / 2.0)
    theta = np.linspace(0.0, reach, 200)[1:]
    radius = np.array([lens.radius(float(angle)) for angle in theta]) / lens.focal_length
    powers = np.stack([theta ** (2 * n + 3) for n in range(4)], axis=-1)
    k1, k2, k3, k4 = np.linalg.lstsq(powers, radius - theta, rcond=None)[0]
    return float(k1), float(k2), float(k3), float(k4)


def _edges(width: int, height: int, fx: float, fy: float, cx: float, cy: float) -> Projection:
    # Pixel (0, 0) is the centre of the upper left pixel.
    return Projection(
        width,
        height,
        left=-(cx + 0.5) / fx,
        right=(width - 0.5 - cx) / fx,
        bottom=-(height - 0.5 - cy) / fy,
        top=(cy + 0.5) / fy,
    )


def undistorted(camera: CameraModel) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """Return the undistorted X/Z and Y/Z of each pixel, and whether the pixel has a ray."""
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
        # Beyond its fold the lens model repeats the image, turned: those pixels have no ray.
        seen &= (x * wanted_x + y * wanted_y >= 0.0) & (a * d - b * c > 0.0)
    return x, y, seen
