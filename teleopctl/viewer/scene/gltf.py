"""glTF 2.0 for viser: coloured and textured surfaces, and changes of a mesh's materials."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.viewer.scene.drawing import Floats, Rgba

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, slots=True)
class Texture:
    """A loaded texture: PNG or JPEG bytes for browsers, with their properties.

    Attributes:
        data: Content of a PNG or JPEG file.
        mime_type: ``image/png`` or ``image/jpeg``.
        see_through: Whether the texture may have transparent pixels.
        mean: Mean colour of the texture.
        path: Path of the file; None for a texture from a message.
        stamp: Size and modification time of the file when it was read; see `file_stamp`.
    """

    data: bytes
    mime_type: str
    see_through: bool = False
    mean: Rgba = (1.0, 1.0, 1.0, 1.0)
    path: Path | None = None
    stamp: tuple[int, int] = (0, 0)


def linear_rgb(srgb: Floats) -> Floats:
    """Return an array of sRGB colour values (0 to 1) converted to linear light (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def to_linear(srgb: float) -> float:
    """Return one sRGB colour value, clamped to 0 to 1, as linear light."""
    srgb = min(max(srgb, 0.0), 1.0)
    return srgb / 12.92 if srgb <= 0.04045 else math.pow((srgb + 0.055) / 1.055, 2.4)


def to_srgb(light: float) -> float:
    """Return one value of linear light, clamped to 0 to 1, as an sRGB colour value."""
    light = min(max(light, 0.0), 1.0)
    return light * 12.92 if light <= 0.0031308 else 1.055 * math.pow(light, 1 / 2.4) - 0.055


_FLOAT, _SHORT = 5126, 5123
_JSON, _NUMBERS = 0x4E4F534A, 0x004E4942


def surface_glb(
    corners: Floats,
    colors: Floats,
    uv: Floats | None = None,
    texture: Texture | None = None,
    normals: Floats | None = None,
) -> bytes:
    """Return coloured or textured triangles as binary glTF, visible from both sides.

    viser's own meshes have one colour each and no texture. trimesh cannot write unlit materials or
    16-bit colours, and re-encodes textures, which browsers can read as they are.

    Without a texture the colours are unlit; a texture is lit, and multiplied by the colours.
    Coordinates are not converted to glTF's y-up, since viser does not convert them back.

    Args:
        corners: Corners, three per triangle, (3 n, 3).
        colors: Red, green, blue and opacity from 0 to 1, (3 n, 4), or (4,) for all.
        uv: Texture coordinates from the upper left, (3 n, 2).
        texture: Texture of the triangles; None for colours alone.
        normals: Normals of the corners, (3 n, 3); without them the shading is flat.
    """
    shades = np.clip(colors, 0.0, 1.0)
    # glTF colours are linear light.
    linear = np.concatenate([linear_rgb(shades[..., :3]), shades[..., 3:]], axis=-1)
    see_through = bool((shades[..., 3] < 1.0).any()) or (
        texture is not None and texture.see_through
    )
    material: dict[str, Any] = {
        "doubleSided": True,
        "alphaMode": "BLEND" if see_through else "OPAQUE",
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0},
    }
    file = _GltfBuffer()
    attributes = {"POSITION": file.add(np.asarray(corners, np.float32), _FLOAT)}
    if normals is not None:
        attributes["NORMAL"] = file.add(np.asarray(normals, np.float32), _FLOAT)
    if linear.ndim == 2:
        painted = np.rint(linear * 65535.0).astype(np.uint16)
        attributes["COLOR_0"] = file.add(painted, _SHORT)
    else:
        material["pbrMetallicRoughness"]["baseColorFactor"] = linear.tolist()
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "material": 0}]}],
        "materials": [material],
    }
    if texture is None or uv is None:
        document["extensionsUsed"] = ["KHR_materials_unlit"]
        material["extensions"] = {"KHR_materials_unlit": {}}
    else:
        attributes["TEXCOORD_0"] = file.add(np.asarray(uv, np.float32), _FLOAT)
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
        view = file.append(texture.data)
        document["images"] = [{"bufferView": view, "mimeType": texture.mime_type}]
        document["textures"] = [{"source": 0}]
    return file.packed(document)


class _GltfBuffer:
    """Binary chunk of a glTF file, with its buffer views and accessors."""

    def __init__(self) -> None:
        self._numbers = b""
        self._views: list[dict[str, int]] = []
        # Any: JSON values.
        self._accessors: list[dict[str, Any]] = []

    def append(self, data: bytes) -> int:
        """Append bytes to the binary chunk; return the index of their buffer view."""
        self._views.append({"buffer": 0, "byteOffset": len(self._numbers), "byteLength": len(data)})
        self._numbers += data + b"\0" * (-len(data) % 4)
        return len(self._views) - 1

    def add(
        self, rows: npt.NDArray[np.float32] | npt.NDArray[np.uint16], component_type: int
    ) -> int:
        """Append an array of numbers to the binary chunk; return the index of its accessor."""
        accessor: dict[str, Any] = {
            "bufferView": self.append(rows.tobytes()),
            "componentType": component_type,
            "count": len(rows),
            "type": f"VEC{rows.shape[1]}",
            "normalized": component_type == _SHORT,
        }
        if component_type == _FLOAT and len(rows):
            accessor["min"], accessor["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def packed(self, document: dict[str, Any]) -> bytes:
        """Return the complete GLB file: ``document`` as JSON chunk, and the binary chunk."""
        document["buffers"] = [{"byteLength": len(self._numbers)}]
        document["bufferViews"], document["accessors"] = self._views, self._accessors
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), _JSON) + text
        chunks += struct.pack("<II", len(self._numbers), _NUMBERS) + self._numbers
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


_HEADER, _CHUNK_HEADER = 12, 8
# Name of the material of parts without one.
_DEFAULT_MATERIAL = "of the description"
_ROUGHNESS = 0.7
_MOST_COVERED = 0.5


def prepare_glb(glb: bytes, *, is_gltf: bool) -> bytes:
    """Return a GLB file written by trimesh, with its materials changed to look as in RViz.

    Triangles are visible from both sides, opacities below 1 are transparent, and parts without
    material get one whose colour `colored_glb` sets.

    Args:
        glb: GLB file written by trimesh.
        is_gltf: Whether the original was glTF, whose default material is metallic and whose
            colours are linear. Colours of other formats are sRGB, which trimesh writes unchanged.
    """
    document, rest = _split(glb)
    materials: list[Any] = document.setdefault("materials", [])
    for material in materials:
        material["doubleSided"] = True
        reflecting = material.setdefault("pbrMetallicRoughness", {})
        *shades, opacity = reflecting.get("baseColorFactor", [1.0] * 4)
        if not is_gltf:
            reflecting["metallicFactor"] = 0.0
            reflecting["baseColorFactor"] = [*map(to_linear, shades), opacity]
        if opacity < 1.0:
            material.setdefault("alphaMode", "BLEND")
    bare: dict[bool, int] = {}
    for mesh in document.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            if "material" in primitive:
                continue
            painted = "COLOR_0" in primitive.get("attributes", {})
            if painted not in bare:
                bare[painted] = len(materials)
                materials.append(
                    {
                        "name": "" if painted else _DEFAULT_MATERIAL,
                        "doubleSided": True,
                        "pbrMetallicRoughness": {
                            "metallicFactor": 0.0,
                            "roughnessFactor": _ROUGHNESS,
                        },
                    }
                )
            primitive["material"] = bare[painted]
    if not materials:
        del document["materials"]
    return _joined(document, rest)


def colored_glb(glb: bytes, rgba: Rgba, alpha: float = 1.0) -> bytes:
    """Return a `prepare_glb` file with a colour for parts without material, and an opacity for all.

    Args:
        glb: GLB file from `prepare_glb`.
        rgba: Colour in sRGB.
        alpha: Opacity of all parts, with and without material.
    """
    document, rest = _split(glb)
    for material in document.get("materials", []):
        reflecting = material.setdefault("pbrMetallicRoughness", {})
        if material.get("name") == _DEFAULT_MATERIAL:
            reflecting["baseColorFactor"] = [*map(to_linear, rgba[:3]), rgba[3]]
        color = [float(part) for part in reflecting.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))]
        color[3] *= alpha
        reflecting["baseColorFactor"] = color
        if color[3] < 1.0:
            material["alphaMode"] = "BLEND"
    return _joined(document, rest)


def tinted_glb(glb: bytes, rgba: Rgba) -> bytes:
    """Return a `prepare_glb` file tinted by a colour, as RViz tints the meshes of markers.

    RViz draws the mesh, and over it the mesh in the colour with an opacity of at most 0.5. Parts
    without material have the colour alone. Here a texture is multiplied by the mean of the colour
    and white instead, which looks nearly the same.

    Args:
        glb: GLB file from `prepare_glb`.
        rgba: Colour in sRGB.
    """
    document, rest = _split(glb)
    cover = min(rgba[3], _MOST_COVERED)
    painted = _painted_materials(document)
    for number, material in enumerate(document.get("materials", [])):
        reflecting = material.setdefault("pbrMetallicRoughness", {})
        *base, opacity = (
            float(part) for part in reflecting.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
        )
        if material.get("name") == _DEFAULT_MATERIAL:
            mixed = [*map(to_linear, rgba[:3])]
        elif number in painted or "baseColorTexture" in reflecting:
            mixed = [
                part * to_linear(1.0 - cover + cover * shade)
                for part, shade in zip(base, rgba[:3], strict=True)
            ]
        else:
            mixed = [
                to_linear((1.0 - cover) * to_srgb(part) + cover * shade)
                for part, shade in zip(base, rgba[:3], strict=True)
            ]
        reflecting["baseColorFactor"] = [*mixed, opacity * rgba[3]]
        if opacity * rgba[3] < 1.0:
            material["alphaMode"] = "BLEND"
    return _joined(document, rest)


def _painted_materials(document: dict[str, Any]) -> set[int]:
    """Return the indices of materials of parts with vertex colours."""
    return {
        primitive["material"]
        for mesh in document.get("meshes", [])
        for primitive in mesh.get("primitives", [])
        if "COLOR_0" in primitive.get("attributes", {})
    }


# Any: JSON values.
def _split(glb: bytes) -> tuple[dict[str, Any], bytes]:
    (length,) = struct.unpack_from("<I", glb, _HEADER)
    begin = _HEADER + _CHUNK_HEADER
    return json.loads(glb[begin : begin + length]), glb[begin + length :]


def _joined(document: dict[str, Any], rest: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<II", len(text), _JSON) + text
    return struct.pack("<4sII", b"glTF", 2, _HEADER + len(chunk) + len(rest)) + chunk + rest
