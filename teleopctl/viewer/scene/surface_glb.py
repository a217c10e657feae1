"""Triangles with a colour for each corner, or a picture on them, as binary glTF 2.0.

viser's meshes have one colour each and no picture. The format: a header of 12 bytes, then a chunk
of JSON and one of numbers, each preceded by its length and kind and filled up to a multiple of four
bytes.
"""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.viewer.scene.drawing import Floats
from teleopctl.viewer.scene.srgb import linear_light

if TYPE_CHECKING:
    from teleopctl.viewer.scene.texture_files import Texture

_FLOAT, _SHORT = 5126, 5123
_JSON, _NUMBERS = 0x4E4F534A, 0x004E4942


def surface_glb(
    corners: Floats,
    colors: Floats,
    uv: Floats | None = None,
    texture: Texture | None = None,
    normals: Floats | None = None,
) -> bytes:
    """Return two-sided triangles as binary glTF.

    Without a texture they have their colours whatever the light; a texture is lit, and multiplied
    by the colours. glTF stands on y where ROS stands on z; viser turns neither, so coordinates
    stay as they are.

    Args:
        corners: Shape (3 n, 3).
        colors: Red, green, blue and opacity from 0 to 1, shape (3 n, 4), or (4,) for all.
        uv: Where each corner is in the texture, from its upper left, shape (3 n, 2).
        texture: The picture.
        normals: Where each corner looks, shape (3 n, 3); without them triangles are flat.
    """
    shades = np.clip(colors, 0.0, 1.0)
    # Colours of glTF are amounts of light.
    linear = np.concatenate([linear_light(shades[..., :3]), shades[..., 3:]], axis=-1)
    see_through = bool((shades[..., 3] < 1.0).any()) or (
        texture is not None and texture.see_through
    )
    material: dict[str, Any] = {
        "doubleSided": True,
        "alphaMode": "BLEND" if see_through else "OPAQUE",
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0},
    }
    file = _File()
    attributes = {"POSITION": file.add(np.asarray(corners, np.float32), _FLOAT)}
    if normals is not None:
        attributes["NORMAL"] = file.add(np.asarray(normals, np.float32), _FLOAT)
    if linear.ndim == 2:
        painted = np.rint(linear * 65535.0).astype(np.uint16)
        attributes["COLOR_0"] = file.add(painted, _SHORT)
    else:
        material["pbrMetallicRoughness"]["baseColorFactor"] = linear.tolist()
    described: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "material": 0}]}],
        "materials": [material],
    }
    if texture is None or uv is None:
        described["extensionsUsed"] = ["KHR_materials_unlit"]
        material["extensions"] = {"KHR_materials_unlit": {}}
    else:
        attributes["TEXCOORD_0"] = file.add(np.asarray(uv, np.float32), _FLOAT)
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
        view = file.append(texture.data)
        described["images"] = [{"bufferView": view, "mimeType": texture.mime_type}]
        described["textures"] = [{"source": 0}]
    return file.packed(described)


class _File:
    """The numbers of a file, and what is said of them."""

    def __init__(self) -> None:
        self._numbers = b""
        self._views: list[dict[str, int]] = []
        # Any stands for what JSON holds.
        self._accessors: list[dict[str, Any]] = []

    def append(self, data: bytes) -> int:
        """Append bytes; return the number of their buffer view."""
        self._views.append({"buffer": 0, "byteOffset": len(self._numbers), "byteLength": len(data)})
        self._numbers += data + b"\0" * (-len(data) % 4)
        return len(self._views) - 1

    def add(self, rows: npt.NDArray[np.float32] | npt.NDArray[np.uint16], kind: int) -> int:
        """Append rows of numbers; return the number of their accessor."""
        accessor: dict[str, Any] = {
            "bufferView": self.append(rows.tobytes()),
            "componentType": kind,
            "count": len(rows),
            "type": f"VEC{rows.shape[1]}",
            "normalized": kind == _SHORT,
        }
        if kind == _FLOAT and len(rows):
            accessor["min"], accessor["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def packed(self, described: dict[str, Any]) -> bytes:
        """Return the complete file."""
        described["buffers"] = [{"byteLength": len(self._numbers)}]
        described["bufferViews"], described["accessors"] = self._views, self._accessors
        text = json.dumps(described, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), _JSON) + text
        chunks += struct.pack("<II", len(self._numbers), _NUMBERS) + self._numbers
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
