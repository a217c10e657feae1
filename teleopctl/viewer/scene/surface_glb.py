"""Triangles with a colour for each corner as binary glTF 2.0.

viser's meshes have one colour each. The format: a header of 12 bytes, then a chunk of JSON and one
of numbers, each preceded by its length and kind and filled up to a multiple of four bytes.
"""

from __future__ import annotations

import json
import struct

import numpy as np

from teleopctl.viewer.scene.drawing import Floats

_FLOAT, _SHORT = 5126, 5123
_JSON, _NUMBERS = 0x4E4F534A, 0x004E4942


def linear_light(shades: Floats) -> Floats:
    """The amounts of light, from 0 to 1, of colours as screens have them (IEC 61966-2-1)."""
    return np.where(shades <= 0.04045, shades / 12.92, ((shades + 0.055) / 1.055) ** 2.4)


def surface_glb(corners: Floats, colors: Floats) -> bytes:
    """Write triangles that are seen from both sides, in their colours whatever the light.

    glTF stands on y where ROS stands on z; viser turns neither, so coordinates stay as they are.

    Args:
        corners: Shape (3 n, 3).
        colors: Red, green, blue and opacity from 0 to 1, shape (3 n, 4), or (4,) for all.
    """
    count = len(corners)
    positions = np.ascontiguousarray(corners, np.float32)
    shades = np.clip(np.broadcast_to(colors, (count, 4)), 0.0, 1.0)
    # Colours of corners are amounts of light in glTF.
    linear = np.hstack([linear_light(shades[:, :3]), shades[:, 3:]])
    painted = np.ascontiguousarray(np.rint(linear * 65535.0), np.uint16)
    numbers = positions.tobytes() + painted.tobytes()
    see_through = bool((shades[:, 3] < 1.0).any())
    low = positions.min(axis=0).tolist() if count else [0.0] * 3
    high = positions.max(axis=0).tolist() if count else [0.0] * 3
    described = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "material": 0}]}],
        "materials": [
            {
                "doubleSided": True,
                "alphaMode": "BLEND" if see_through else "OPAQUE",
                "extensions": {"KHR_materials_unlit": {}},
            }
        ],
        "buffers": [{"byteLength": len(numbers)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": positions.nbytes},
            {"buffer": 0, "byteOffset": positions.nbytes, "byteLength": painted.nbytes},
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _FLOAT,
                "count": count,
                "type": "VEC3",
                "min": low,
                "max": high,
            },
            {
                "bufferView": 1,
                "componentType": _SHORT,
                "normalized": True,
                "count": count,
                "type": "VEC4",
            },
        ],
    }
    text = json.dumps(described, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    numbers += b"\0" * (-len(numbers) % 4)
    chunks = struct.pack("<II", len(text), _JSON) + text
    chunks += struct.pack("<II", len(numbers), _NUMBERS) + numbers
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
