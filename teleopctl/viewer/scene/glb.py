"""Changes of binary glTF 2.0 that leave its numbers alone: colours, opacity, both sides.

The format: a header of 12 bytes, then a chunk of JSON and one of numbers, each preceded by its
length and kind and filled up to a multiple of four bytes.
"""

from __future__ import annotations

import json
import struct
from typing import Any

from teleopctl.viewer.scene.drawing import Rgba
from teleopctl.viewer.scene.srgb import light_of, shade_of

_JSON = 0x4E4F534A
_HEADER, _CHUNK_HEADER = 12, 8
# By this name a material stands for the colour that is not the file's.
_NOT_OF_THE_FILE = "of the description"
_ROUGHNESS = 0.7
_MOST_COVERED = 0.5


def furnished(glb: bytes, *, is_gltf: bool) -> bytes:
    """Adapt a GLB file, so that it looks as in RViz.

    All is seen from both sides, what is partly opaque is seen through, and what has no material
    gets one whose colour `dressed` sets.

    Args:
        glb: What trimesh wrote.
        is_gltf: Whether the file was glTF before. There a material that does not say how metallic
            it is, is a metal, and colours are amounts of light; other kinds of files have colours
            as a screen shows them, which trimesh writes as they are.
    """
    described, rest = _split(glb)
    materials: list[Any] = described.setdefault("materials", [])
    for material in materials:
        material["doubleSided"] = True
        reflecting = material.setdefault("pbrMetallicRoughness", {})
        *shades, opacity = reflecting.get("baseColorFactor", [1.0] * 4)
        if not is_gltf:
            reflecting["metallicFactor"] = 0.0
            reflecting["baseColorFactor"] = [*map(light_of, shades), opacity]
        if opacity < 1.0:
            material.setdefault("alphaMode", "BLEND")
    bare: dict[bool, int] = {}
    for mesh in described.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            if "material" in primitive:
                continue
            painted = "COLOR_0" in primitive.get("attributes", {})
            if painted not in bare:
                bare[painted] = len(materials)
                materials.append(
                    {
                        "name": "" if painted else _NOT_OF_THE_FILE,
                        "doubleSided": True,
                        "pbrMetallicRoughness": {
                            "metallicFactor": 0.0,
                            "roughnessFactor": _ROUGHNESS,
                        },
                    }
                )
            primitive["material"] = bare[painted]
    if not materials:
        del described["materials"]
    return _joined(described, rest)


def dressed(glb: bytes, rgba: Rgba, alpha: float = 1.0) -> bytes:
    """Return a GLB file with a description's colour where it has no colours of its own.

    Args:
        glb: The file.
        rgba: As a screen shows it; glTF's colours are linear.
        alpha: The opacity of the whole, also of what has its own colours.
    """
    described, rest = _split(glb)
    for material in described.get("materials", []):
        reflecting = material.setdefault("pbrMetallicRoughness", {})
        if material.get("name") == _NOT_OF_THE_FILE:
            reflecting["baseColorFactor"] = [*map(light_of, rgba[:3]), rgba[3]]
        color = [float(part) for part in reflecting.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))]
        color[3] *= alpha
        reflecting["baseColorFactor"] = color
        if color[3] < 1.0:
            material["alphaMode"] = "BLEND"
    return _joined(described, rest)


def tinted(glb: bytes, rgba: Rgba) -> bytes:
    """Return a GLB file tinted by a colour, as RViz tints the meshes of markers.

    RViz draws the mesh, then the mesh in the colour, which covers at most half of what is below.
    What has no material of its own has the colour alone. A picture is multiplied instead by what
    half of the colour and half of white are: nearly the same, and black as dark.

    Args:
        glb: The file.
        rgba: As a screen shows it.
    """
    described, rest = _split(glb)
    cover = min(rgba[3], _MOST_COVERED)
    painted = _painted_materials(described)
    for number, material in enumerate(described.get("materials", [])):
        reflecting = material.setdefault("pbrMetallicRoughness", {})
        *base, opacity = (
            float(part) for part in reflecting.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
        )
        if material.get("name") == _NOT_OF_THE_FILE:
            mixed = [*map(light_of, rgba[:3])]
        elif number in painted or "baseColorTexture" in reflecting:
            mixed = [
                part * light_of(1.0 - cover + cover * shade)
                for part, shade in zip(base, rgba[:3], strict=True)
            ]
        else:
            mixed = [
                light_of((1.0 - cover) * shade_of(part) + cover * shade)
                for part, shade in zip(base, rgba[:3], strict=True)
            ]
        reflecting["baseColorFactor"] = [*mixed, opacity * rgba[3]]
        if opacity * rgba[3] < 1.0:
            material["alphaMode"] = "BLEND"
    return _joined(described, rest)


def _painted_materials(described: dict[str, Any]) -> set[int]:
    """The materials of parts whose corners have colours of their own."""
    return {
        primitive["material"]
        for mesh in described.get("meshes", [])
        for primitive in mesh.get("primitives", [])
        if "COLOR_0" in primitive.get("attributes", {})
    }


# Any stands for what JSON holds.
def _split(glb: bytes) -> tuple[dict[str, Any], bytes]:
    (length,) = struct.unpack_from("<I", glb, _HEADER)
    begin = _HEADER + _CHUNK_HEADER
    return json.loads(glb[begin : begin + length]), glb[begin + length :]


def _joined(described: dict[str, Any], rest: bytes) -> bytes:
    text = json.dumps(described, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunk = struct.pack("<II", len(text), _JSON) + text
    return struct.pack("<4sII", b"glTF", 2, _HEADER + len(chunk) + len(rest)) + chunk + rest
