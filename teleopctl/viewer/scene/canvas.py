"""Drawings as viser scene nodes: one node for all solids of a shape, or all lines of a width."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.tf import Transform
from teleopctl.viewer.scene.drawing import (
    COLUMNS,
    OWN,
    Drawing,
    Floats,
    Rows,
    Text,
    TriangleMesh,
    Vector,
)
from teleopctl.viewer.scene.gltf import colored_glb, linear_rgb, surface_glb, tinted_glb
from teleopctl.viewer.scene.unit_shapes import is_unit_shape, unit_shape

if TYPE_CHECKING:
    import viser

    from teleopctl.viewer.scene.assets import MeshFile
    from teleopctl.viewer.scene.gltf import Texture

# Any: viser's nodes of any kind, and their contents.

# Each text is a node of its own: browsers do not draw more texts smoothly.
MOST_TEXTS = 500
MOST_SURFACES = 500
_MOST_PICKED = 1000
# A mesh with materials is sent once for each tint colour.
_MOST_TINTS = 20
# Shapes drawn more often have fewer triangles.
_MOST_FINE = 100
_MOST_SIMPLE = 2000
_HAIR_PIXELS = 2.0


class Canvas:
    """Group of viser scene nodes below one path, which shows one `Drawing` at a time.

    Unchanged nodes are not sent again. A node whose number of rows changes is replaced, so that a
    browser never combines the new solids with the colours of the old ones.

    Args:
        scene: The viser scene.
        path: Scene path of the group, below which nothing else is drawn.
        meshes: Meshes by name, for shapes that are not in `unit_shapes`.
        textures: Textures of surfaces by name; None for a texture that cannot be loaded, whose
            surfaces are drawn in their colours.
        picked: Whether users can click on solids. Each solid is then a node of its own, since viser
            finds the solid under the mouse by the size of a batch's shape, not of the solid.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        path: str,
        meshes: Mapping[str, MeshFile] | None = None,
        textures: Mapping[str, Texture | None] | None = None,
        *,
        picked: bool = False,
    ) -> None:
        self.path = path
        self._picked = picked
        self._scene = scene
        self._meshes: Mapping[str, MeshFile] = meshes if meshes is not None else {}
        self._textures: Mapping[str, Texture | None] = textures if textures is not None else {}
        # Node and number of its rows. Any: viser's kinds of handles.
        self._nodes: dict[str, tuple[Any, int]] = {}
        self._shown_surfaces: dict[str, tuple[TriangleMesh, Texture | None]] = {}

    def show(self, drawing: Drawing) -> None:
        """Add, update and remove scene nodes so that the canvas shows a drawing."""
        before = set(self._nodes)
        kept: set[str] = set()
        for shape, rows in drawing.solids.items():
            kept |= self._show_solids(shape, rows.stack(COLUMNS))
        for number, (width, rows) in enumerate(sorted(drawing.lines.items())):
            kept.add(self._show_lines(f"lines{number}", width, rows))
        for number, (width, rows) in enumerate(sorted(drawing.points.items())):
            kept.add(self._show_points(f"points{number}", width, rows))
        for number, text in enumerate(drawing.texts[:MOST_TEXTS]):
            kept.add(self._show_text(f"text{number}", text))
        for number, surface in enumerate(drawing.surfaces[:MOST_SURFACES]):
            if (shown := self._show_surface(f"surface{number}", surface)) is not None:
                kept.add(shown)
        for name in before - kept:
            self._remove(name)

    def remove(self) -> None:
        """Remove all nodes of the canvas from the scene."""
        for name in list(self._nodes):
            self._remove(name)

    @property
    def nodes(self) -> dict[str, Any]:
        """The canvas's viser scene nodes, by their names below the canvas's path."""
        return {name: node for name, (node, _) in self._nodes.items()}

    def _remove(self, name: str) -> None:
        node, _ = self._nodes.pop(name)
        self._shown_surfaces.pop(name, None)
        if self._is_in_scene(node):
            node.remove()

    def _reusable(self, name: str, rows: int) -> Any:
        """Return the node of a name if it has that many rows and is in the scene, else None."""
        node, count = self._nodes.get(name, (None, 0))
        return node if node is not None and count == rows and self._is_in_scene(node) else None

    def _is_in_scene(self, node: Any) -> bool:
        # Removing a frame removes all nodes below it.
        return self._scene.get_handle_by_name(node.name) is node

    def _show_solids(self, shape: str, rows: Floats) -> set[str]:
        rows = rows[rows[:, 13] > 0.0]
        mesh = self._meshes.get(shape)
        is_file = mesh is not None
        if mesh is None:
            if not is_unit_shape(shape):
                return set()  # a mesh that is not loaded yet
            vertices, faces = unit_shape(shape, fine=len(rows) <= _MOST_FINE)
        elif mesh.vertices is not None and mesh.faces is not None:
            vertices, faces = mesh.vertices, mesh.faces
        else:
            return self._show_tinted(shape, rows, mesh.glb)
        if self._picked:
            name = _node_name(shape)
            return {
                self._show_mesh(f"{name}{number}", row, vertices, faces, is_file=is_file)
                for number, row in enumerate(rows[:_MOST_PICKED])
            }
        clear = rows[:, 13] < 1.0
        kept = set()
        for suffix, part in (("", rows[~clear]), ("_clear", rows[clear])):
            if len(part):
                name = _node_name(shape) + suffix
                self._show_batch(
                    name, part, vertices, faces, see_through=bool(suffix), is_file=is_file
                )
                kept.add(name)
        return kept

    def _show_mesh(
        self,
        name: str,
        row: Floats,
        vertices: npt.NDArray[np.float32],
        faces: npt.NDArray[np.uint32],
        *,
        is_file: bool,
    ) -> str:
        red, green, blue = _bytes(row[10:13]).tolist()
        node = self._scene.add_mesh_simple(
            f"{self.path}/{name}",
            vertices * row[7:10].astype(np.float32),
            faces,
            color=(red, green, blue),
            opacity=float(row[13]) if row[13] < 1.0 else None,
            position=row[0:3],
            wxyz=row[3:7],
            # Triangles of files are drawn flat, and may have inverted normals.
            flat_shading=is_file,
            side="double" if is_file else "front",
            cast_shadow=False,
            receive_shadow=False,
        )
        self._nodes[name] = (node, 1)
        return name

    def _show_batch(
        self,
        name: str,
        rows: Floats,
        vertices: npt.NDArray[np.float32],
        faces: npt.NDArray[np.uint32],
        *,
        see_through: bool,
        is_file: bool,
    ) -> None:
        opacities = rows[:, 13].astype(np.float32) if see_through else None
        node = self._reusable(name, len(rows))
        if node is None:
            node = self._scene.add_batched_meshes_simple(
                f"{self.path}/{name}",
                vertices,
                faces,
                batched_positions=rows[:, 0:3],
                batched_wxyzs=rows[:, 3:7],
                batched_scales=rows[:, 7:10].astype(np.float32),
                batched_colors=_linear_bytes(rows[:, 10:13]),
                batched_opacities=opacities,
                # For a simple mesh, level of detail costs the browser more than drawing.
                flat_shading=is_file,
                side="double" if is_file else "front",
                lod="off" if len(vertices) <= _MOST_SIMPLE else "auto",
                cast_shadow=False,
                receive_shadow=False,
            )
            self._nodes[name] = (node, len(rows))
            return
        _set_poses(node, rows)
        node.batched_colors = _linear_bytes(rows[:, 10:13])
        if opacities is not None:
            node.batched_opacities = opacities

    def _show_tinted(self, shape: str, rows: Floats, glb: bytes) -> set[str]:
        """Draw a mesh with materials: a node for each colour that tints it."""
        # Colours are rounded to 8 bits, so that node names distinguish them.
        colors, numbers = np.unique(_bytes(rows[:, 10:14]), axis=0, return_inverse=True)
        numbers = numbers.reshape(-1)  # only numpy 2.0 returns a second axis
        kept = set()
        for number, color in enumerate(colors[:_MOST_TINTS]):
            # Rows of all further colours are drawn in the last one.
            is_last = number == _MOST_TINTS - 1
            part = rows[numbers >= number] if is_last else rows[numbers == number]
            name = f"{_node_name(shape)}_{color.tobytes().hex()}"
            kept.add(self._show_glb(name, part, glb, color))
        return kept

    def _show_glb(self, name: str, rows: Floats, glb: bytes, color: npt.NDArray[np.uint8]) -> str:
        node = self._reusable(name, len(rows))
        if node is not None:
            _set_poses(node, rows)
            return name
        red, green, blue, opacity = (color / 255.0).tolist()
        own = color.tolist() == _bytes(np.array(OWN)).tolist()
        glb = colored_glb(glb, OWN) if own else tinted_glb(glb, (red, green, blue, opacity))
        node = self._scene.add_batched_glb(
            f"{self.path}/{name}",
            glb,
            batched_positions=rows[:, 0:3],
            batched_wxyzs=rows[:, 3:7],
            batched_scales=rows[:, 7:10].astype(np.float32),
            cast_shadow=False,
            receive_shadow=False,
        )
        self._nodes[name] = (node, len(rows))
        return name

    def _show_lines(self, name: str, width: float, rows: Rows) -> str:
        ends = rows.stack(12).reshape(-1, 2, 6)
        points, colors = ends[:, :, 0:3].astype(np.float32), _linear_bytes(ends[:, :, 3:6])
        node = self._reusable(name, len(ends))
        if node is None:
            node = self._scene.add_line_segments(
                f"{self.path}/{name}",
                points,
                colors,
                thickness=width or _HAIR_PIXELS,
                thickness_units="world" if width else "screen",
            )
            self._nodes[name] = (node, len(ends))
        else:
            node.thickness_units = "world" if width else "screen"
            node.points, node.colors, node.thickness = points, colors, width or _HAIR_PIXELS
        return name

    def _show_points(self, name: str, width: float, rows: Rows) -> str:
        all_rows = rows.stack(6)
        points, colors = all_rows[:, 0:3].astype(np.float32), _bytes(all_rows[:, 3:6])
        node = self._reusable(name, len(points))
        if node is None:
            node = self._scene.add_point_cloud(
                f"{self.path}/{name}",
                points,
                colors,
                point_size=width,
                point_shape="square",
                point_shading="flat",
                precision="float32",
            )
            self._nodes[name] = (node, len(points))
        else:
            node.points, node.colors, node.point_size = points, colors, width
        return name

    def _show_text(self, name: str, text: Text) -> str:
        node = self._reusable(name, 1)
        if node is None:
            node = self._scene.add_label(
                f"{self.path}/{name}",
                text.text,
                position=text.position,
                font_size_mode="scene",
                font_scene_height=text.height,
                anchor="center-center",
                depth_test=True,
            )
            self._nodes[name] = (node, 1)
        else:
            node.text, node.font_scene_height = text.text, text.height
            node.position = text.position
        return name

    def _show_surface(self, name: str, surface: TriangleMesh) -> str | None:
        node = self._reusable(name, 1)
        texture = self._textures.get(surface.texture)
        if surface.texture and surface.texture not in self._textures:
            # The texture is not loaded yet: the former surface is kept until then.
            return name if node is not None else None
        shown = self._shown_surfaces.get(name)
        if node is None or shown is None or not _is_same(shown, (surface, texture)):
            node = self._add_surface(f"{self.path}/{name}", surface, texture)
            self._nodes[name] = (node, 1)
        elif shown[0].pose != surface.pose:
            node.position, node.wxyz = _viser_pose(surface.pose)
        self._shown_surfaces[name] = surface, texture
        return name

    def _add_surface(self, path: str, surface: TriangleMesh, texture: Texture | None) -> Any:
        position, wxyz = _viser_pose(surface.pose)
        if surface.colors.ndim == 2 or texture is not None:
            glb = surface_glb(surface.corners, surface.colors, surface.uv, texture)
            return self._scene.add_glb(
                path, glb, position=position, wxyz=wxyz, cast_shadow=False, receive_shadow=False
            )
        red, green, blue = _bytes(surface.colors[:3]).tolist()
        opacity = float(surface.colors[3])
        return self._scene.add_mesh_simple(
            path,
            surface.corners.astype(np.float32),
            np.arange(len(surface.corners), dtype=np.uint32).reshape(-1, 3),
            color=(red, green, blue),
            opacity=opacity if opacity < 1.0 else None,
            flat_shading=True,
            side="double",
            position=position,
            wxyz=wxyz,
            cast_shadow=False,
            receive_shadow=False,
        )


def _is_same(
    one: tuple[TriangleMesh, Texture | None], other: tuple[TriangleMesh, Texture | None]
) -> bool:
    """Return whether two surfaces are equal but for their poses."""
    (a, its_texture), (b, other_texture) = one, other
    return (
        its_texture is other_texture
        and np.array_equal(a.corners, b.corners)
        and np.array_equal(a.colors, b.colors)
        and (its_texture is None or np.array_equal(_uv(a), _uv(b)))
    )


def _uv(surface: TriangleMesh) -> Floats:
    return surface.uv if surface.uv is not None else np.empty((0, 2))


def _viser_pose(pose: Transform) -> tuple[Vector, tuple[float, float, float, float]]:
    x, y, z, w = pose.rotation
    return pose.translation, (w, x, y, z)


def _set_poses(node: Any, rows: Floats) -> None:
    node.batched_positions = rows[:, 0:3].astype(np.float32)
    node.batched_wxyzs = rows[:, 3:7].astype(np.float32)
    node.batched_scales = rows[:, 7:10].astype(np.float32)


def _bytes(colors: Floats) -> npt.NDArray[np.uint8]:
    return np.clip(np.rint(colors * 255.0), 0, 255).astype(np.uint8)


def _linear_bytes(colors: Floats) -> npt.NDArray[np.uint8]:
    """Return colours as linear light, which viser's batches and lines take.

    viser's other nodes take sRGB colours; the same numbers would look pale.
    """
    return _bytes(linear_rgb(np.clip(colors, 0.0, 1.0)))


def _node_name(shape: str) -> str:
    return shape.replace("/", "\u2215")
