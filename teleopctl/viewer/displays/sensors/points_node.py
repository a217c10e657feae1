"""Points as a viser scene node, in RViz's styles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from teleopctl.viewer.scene.gltf import linear_rgb
from teleopctl.viewer.scene.unit_shapes import unit_shape

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.displays.sensors.cloud import Floats
    from teleopctl.viewer.displays.sensors.colors import Colors

BOXES = "Boxes"
_PIXELS = "Points"
_SPHERES = "Spheres"
STYLES = (_PIXELS, "Squares", "Flat Squares", _SPHERES, BOXES, "Tiles")
# viser takes sizes in metres only; about the size of a pixel at arm's length from the camera.
_PIXEL_M = 0.002
# A float16 has 11 significant bits.
_HALF_PRECISION = 2.0**-11


class PointsNode:
    """viser scene node of points, boxes or spheres, whose points can be replaced.

    Args:
        scene: The viser scene.
        path: Path of the node.
    """

    def __init__(self, scene: viser.SceneApi, path: str) -> None:
        self._scene = scene
        self._path = path
        # Any: viser's handle of a point cloud or of batched meshes
        self._handle: Any = None
        self._kind: tuple[object, ...] = ()

    def draw(
        self,
        points: Floats,
        colors: Colors,
        style: str,
        point_size_m: float,
        pixels: int,
        alpha: float,
    ) -> None:
        """Replace the node's points, with their colours, style, size and opacity.

        Args:
            points: Coordinates, (n, 3), in metres.
            colors: Colours, (n, 3), or one for all, (3,).
            style: One of `STYLES`.
            point_size_m: Size of a point in metres.
            pixels: Size of a point in pixels, for the style ``Points``.
            alpha: Opacity from 0 (invisible) to 1; values between have an effect on boxes only.
        """
        if not len(points) or alpha <= 0.0:
            self.remove()
            return
        if style == BOXES:
            self._draw_boxes(points, colors, point_size_m, alpha)
        else:
            self._draw_points(
                points, colors, style, pixels * _PIXEL_M if style == _PIXELS else point_size_m
            )

    def _draw_points(self, points: Floats, colors: Colors, style: str, size: float) -> None:
        farthest = float(np.abs(points).max())
        # float16 halves the number of bytes; used where its error is not visible.
        coarse = farthest * _HALF_PRECISION < size / 2.0
        precision: Literal["float16", "float32"] = "float16" if coarse else "float32"
        if len(colors) != len(points):
            colors = np.broadcast_to(colors, points.shape)
        kind = ("points", style, size, precision)
        if self._kind == kind:
            self._handle.points, self._handle.colors = points, colors
            return
        self.remove()
        self._kind = kind
        round_ones = style == _SPHERES
        self._handle = self._scene.add_point_cloud(
            self._path,
            points,
            colors,
            point_size=size,
            point_shape="circle" if round_ones else "square",
            precision=precision,
            point_shading="gradient" if round_ones else "flat",
        )

    def _draw_boxes(self, points: Floats, colors: Colors, size: float, alpha: float) -> None:
        self.remove()
        corners, faces = unit_shape("box")
        unturned = np.zeros((len(points), 4), np.float32)
        unturned[:, 0] = 1.0
        self._handle = self._scene.add_batched_meshes_simple(
            self._path,
            size * corners,
            faces,
            unturned,
            points,
            batched_colors=_linear_colors(colors),
            opacity=None if alpha >= 1.0 else alpha,
            lod="off",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )

    def set_pose(
        self, position: tuple[float, float, float], wxyz: tuple[float, float, float, float]
    ) -> None:
        """Set the node's position and rotation (w x y z); no effect while no points are drawn."""
        if self._handle is not None:
            self._handle.position, self._handle.wxyz = position, wxyz

    def show(self, *, shown: bool) -> None:
        """Show or hide the node's points."""
        if self._handle is not None and self._handle.visible != shown:
            self._handle.visible = shown

    def remove(self) -> None:
        """Remove the node's points from the scene."""
        if self._handle is not None:
            self._handle.remove()
        self._handle, self._kind = None, ()


def _linear_colors(colors: Colors) -> Colors:
    """Return colours as linear light, which viser's batched meshes take."""
    return np.rint(255.0 * linear_rgb(colors / 255.0)).astype(np.uint8)
