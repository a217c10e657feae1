"""Colours and textures of mesh files, which MuJoCo does not read.

A file with several materials becomes one mesh per material, each with its colour or texture. These
meshes are only drawn: collisions and mass still use the whole mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.base.budget import check_pixels
from teleopctl.mujoco_model.urdf_import import WEIGHING_GROUP

# More different colours of triangles than this are replaced by their mean.
_MOST_COLOURS = 32
# Longest side of a texture in pixels; larger textures are reduced.
_LARGEST_PICTURE = 1024
# Upper limit of all textures of a model together, in bytes: the whole model is sent to cameras when
# it changes, while simulation time stands still. A furnished house has 80 textures: with the side
# above, 200 MB.
_MOST_OF_PICTURES = 64_000_000
# Exponent that converts glTF's linear colours to those of a screen.
_SCREEN_GAMMA = 1.0 / 2.2

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Part:
    """Part of a mesh file with one material: triangles, colour and texture.

    Attributes:
        vertices: Vertices, (n, 3), in metres.
        faces: Triangles as indices of vertices, (m, 3).
        rgba: Colour of the part; None where the file has none.
        picture: Pixels of the texture, (height, width, 3), the lowest row first; or None.
        uv: Texture coordinates of each vertex, (n, 2), from 0 to 1; None without a texture.
    """

    vertices: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    rgba: Rgba | None
    picture: npt.NDArray[np.uint8] | None = None
    uv: npt.NDArray[np.float64] | None = None


class MeshTexture(NamedTuple):
    """Texture of a mesh: the mesh's name, the pixels, and the colour that multiplies them.

    Attributes:
        name: Name of the mesh.
        pixels: Pixels of the texture, as ``picture`` of `Part`.
        rgba: Colour that the pixels are multiplied by.
    """

    name: str
    pixels: npt.NDArray[np.uint8]
    rgba: Rgba


# Any stands for trimesh's results, whose types are not right for every kind of file, and for
# MuJoCo's elements, which have no types.
def parts_of(scene: Any, *, is_gltf: bool) -> list[Part]:
    """Return the parts of a trimesh scene, split by material; none if the scene has no colours.

    Args:
        scene: trimesh's scene, in metres.
        is_gltf: Whether the colours are linear, as in glTF.
    """
    found: dict[object, list[Part]] = {}
    for mesh in scene.dump(concatenate=False):
        if not len(getattr(mesh, "faces", ())):
            continue
        for key, part in _parts_of_mesh(mesh, is_gltf=is_gltf):
            found.setdefault(key, []).append(part)
    parts = [_joined(alike) for alike in found.values()]
    return parts if any(part.rgba is not None for part in parts) else []


def visual_geoms(spec: mujoco.MjSpec, mesh: Any) -> list[Any]:
    """Return the geoms of a spec that draw a mesh without colliding."""
    return [geom for geom in spec.geoms if geom.meshname == mesh.name and not geom.contype]


def replace_visuals(
    spec: mujoco.MjSpec, mesh: Any, parts: Sequence[Part], is_taken: Callable[[Any], bool]
) -> list[MeshTexture]:
    """Replace a mesh's visual shapes by coloured parts if MuJoCo takes them; return textures.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        mesh: The mesh to replace.
        parts: Parts of the mesh by material.
        is_taken: Function that returns whether MuJoCo accepts a mesh.

    Returns:
        Textures for `add_textures`, to be added once nothing more is deleted from the spec: MuJoCo
        copies all textures at each deletion.
    """
    meshes = [_add_mesh(spec, mesh, f"{mesh.name}/{number}", p) for number, p in enumerate(parts)]
    if not all(map(is_taken, meshes)):
        for added in meshes:
            spec.delete(added)
        return []
    for geom in visual_geoms(spec, mesh):
        for part, added in zip(parts, meshes, strict=True):
            _add_geom(geom, part, added.name)
        body = geom.parent
        weighed = body.explicitinertial or any(other.contype for other in body.geoms)
        if weighed or not len(body.joints):
            spec.delete(geom)
        else:
            # A moving link without another mass has that of its shapes.
            geom.group = WEIGHING_GROUP
    pictures = [
        MeshTexture(added.name, part.picture, part.rgba)
        for part, added in zip(parts, meshes, strict=True)
        if part.picture is not None and part.rgba is not None
    ]
    if not any(geom.meshname == mesh.name for geom in spec.geoms):
        spec.delete(mesh)
    return pictures


def add_textures(spec: mujoco.MjSpec, pictures: Iterable[MeshTexture]) -> None:
    """Add textures and their materials to a spec, halved in size until all are within 64 MB."""
    added, side = list(pictures), _LARGEST_PICTURE
    while side > 1 and sum(picture.pixels.nbytes for picture in added) > _MOST_OF_PICTURES:
        side //= 2
        added = [picture._replace(pixels=_reduced(picture.pixels, side)) for picture in added]
    for name, pixels, rgba in added:
        texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
        texture.height, texture.width, texture.nchannel = pixels.shape
        texture.data = pixels.tobytes()
        material = spec.add_material(name=name, rgba=list(rgba))
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _reduced(pixels: npt.NDArray[np.uint8], side: int) -> npt.NDArray[np.uint8]:
    """Return a picture reduced by means of 2 x 2 pixels until no side is longer than ``side``."""
    while max(pixels.shape[:2]) > side and min(pixels.shape[:2]) > 1:
        height, width = (size // 2 * 2 for size in pixels.shape[:2])
        blocks = pixels[:height, :width].reshape(height // 2, 2, width // 2, 2, 3)
        pixels = blocks.mean(axis=(1, 3)).astype(np.uint8)
    return pixels


def _add_mesh(spec: mujoco.MjSpec, whole: Any, name: str, part: Part) -> Any:
    mesh = spec.add_mesh(name=name, scale=whole.scale)
    # Sheets have no volume; visual meshes have no mass.
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    mesh.uservert = part.vertices.astype("float32").ravel().tolist()
    mesh.userface = part.faces.astype("int32").ravel().tolist()
    if part.uv is not None:
        mesh.usertexcoord = part.uv.astype("float32").ravel().tolist()
        mesh.userfacetexcoord = mesh.userface
    return mesh


def _add_geom(geom: Any, part: Part, mesh: str) -> None:
    added = geom.parent.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=mesh,
        pos=geom.pos,
        quat=geom.quat,
        group=geom.group,
        contype=0,
        conaffinity=0,
        mass=0.0,
    )
    if part.picture is not None:
        added.material = mesh
    else:
        added.rgba = geom.rgba if part.rgba is None else part.rgba


def _parts_of_mesh(mesh: Any, *, is_gltf: bool) -> Iterator[tuple[object, Part]]:
    visual = mesh.visual
    material = getattr(visual, "material", None)
    if material is None:
        yield from _parts_by_triangles(mesh)
        return
    mesh.merge_vertices()
    visual, rgba = mesh.visual, _rgba(material, is_gltf=is_gltf)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    uv = getattr(visual, "uv", None)
    if image is None or uv is None or max(image.size) <= 2:
        # trimesh generates pictures of 2 x 2 pixels for materials without a texture.
        yield rgba, Part(mesh.vertices, mesh.faces, rgba)
        return
    check_pixels(*image.size)
    image = image.convert("RGB")
    image.thumbnail((_LARGEST_PICTURE, _LARGEST_PICTURE))
    picture = np.flipud(np.asarray(image, np.uint8))
    white = (1.0, 1.0, 1.0, 1.0) if rgba is None else rgba
    yield (rgba, picture.tobytes()), Part(mesh.vertices, mesh.faces, white, picture, np.asarray(uv))


def _parts_by_triangles(mesh: Any) -> Iterator[tuple[object, Part]]:
    if getattr(mesh.visual, "kind", None) not in ("face", "vertex"):
        yield None, Part(mesh.vertices, mesh.faces, None)
        return
    colours, which = np.unique(np.asarray(mesh.visual.face_colors), axis=0, return_inverse=True)
    if len(colours) > _MOST_COLOURS:
        colours, which = colours.mean(axis=0, keepdims=True), np.zeros(len(mesh.faces), int)
    for number, colour in enumerate(colours):
        rgba = _as_rgba(colour / 255.0)
        yield rgba, Part(mesh.vertices, mesh.faces[which.ravel() == number], rgba)


def _rgba(material: Any, *, is_gltf: bool) -> Rgba | None:
    """Return the colour of a material; None where it is a default of trimesh's."""
    from trimesh.visual.material import SimpleMaterial

    if isinstance(material, SimpleMaterial) and not material.kwargs:
        return None
    colour = np.asarray(material.main_color, float) / 255.0
    if is_gltf:
        colour[:3] **= _SCREEN_GAMMA
    return _as_rgba(colour)


def _as_rgba(colour: npt.NDArray[np.float64]) -> Rgba:
    red, green, blue, alpha = colour.tolist()
    # COLLADA's writers do not agree on which end of transparency is opaque.
    return red, green, blue, alpha or 1.0


def _joined(parts: list[Part]) -> Part:
    """Join parts with the same material into one part, without unused vertices."""
    vertices, faces, uvs, count = [], [], [], 0
    for part in parts:
        used, numbers = np.unique(part.faces, return_inverse=True)
        vertices.append(part.vertices[used])
        faces.append(numbers.reshape(-1, 3) + count)
        if part.uv is not None:
            uvs.append(part.uv[used])
        count += len(used)
    first = parts[0]
    uv = np.concatenate(uvs) if uvs else None
    return Part(np.concatenate(vertices), np.concatenate(faces), first.rgba, first.picture, uv)
