"""Small meshes in every file format that robot descriptions use, valid and damaged."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh
from PIL import Image

Files = dict[str, bytes]
"""Contents of files by name; the first file is the mesh."""

TRIANGLES = np.asarray(trimesh.creation.box((1.0, 2.0, 3.0)).triangles, np.float32)


def exported(kind: str, **options: object) -> bytes:
    """Return the content of a mesh file of a box, written by trimesh."""
    written = trimesh.creation.box((1.0, 2.0, 3.0)).export(file_type=kind, **options)
    return written if isinstance(written, bytes) else str(written).encode()


def picture() -> bytes:
    stored = io.BytesIO()
    Image.new("RGB", (8, 8), (200, 100, 50)).save(stored, "PNG")
    return stored.getvalue()


def binary_stl(triangles: np.ndarray, claimed: int | None = None) -> bytes:
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("color", "<u2")])
    rows = np.zeros(len(triangles), row)
    rows["corners"] = triangles
    count = len(triangles) if claimed is None else claimed
    return b"made by a test".ljust(80) + struct.pack("<I", count) + rows.tobytes()


def painted_obj() -> Files:
    corners = TRIANGLES.reshape(-1, 3)
    lines = ["mtllib paint.mtl", *(f"v {x} {y} {z}" for x, y, z in corners.tolist())]
    lines += ["vt 0 0", "vt 1 0", "vt 0 1", "usemtl skin"]
    lines += [f"f {n}/1 {n + 1}/2 {n + 2}/3" for n in range(1, len(corners), 3)]
    mtl = "newmtl skin\nKd 1 1 1\nmap_Kd skin.png\n"
    return {
        "part.obj": "\n".join(lines).encode(),
        "paint.mtl": mtl.encode(),
        "skin.png": picture(),
    }


def painted_dae() -> Files:
    """Return a COLLADA file of the box and its texture, in inches and with the y axis up."""
    corners = " ".join(map(str, TRIANGLES.ravel().tolist()))
    count = len(TRIANGLES) * 3
    rows = " ".join(f"{n} {n % 3}" for n in range(count))
    text = f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00</created><modified>2026-01-01T00:00:00</modified>
<unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_images><image id="skin"><init_from>skin.png</init_from></image></library_images>
<library_effects><effect id="fx"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>skin</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="common"><phong><diffuse><texture texture="t" texcoord="UV"/></diffuse></phong>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * count}">{corners}</float_array>
<technique_common><accessor source="#pa" count="{count}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="6">0 0 1 0 0 1</float_array>
<technique_common><accessor source="#ua" count="3" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(TRIANGLES)}" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>{rows}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s0"><node id="n"><instance_geometry url="#g">
<bind_material><technique_common><instance_material symbol="m" target="#m"/></technique_common>
</bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s0"/></scene></COLLADA>"""
    return {"part.dae": text.encode(), "skin.png": picture()}


def gltf() -> Files:
    """Return a glTF file of the box and a separate file with its vertices."""
    numbers = np.ascontiguousarray(TRIANGLES, np.float32).tobytes()
    count = 3 * len(TRIANGLES)
    described = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"byteLength": len(numbers), "uri": "numbers.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(numbers)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
    }
    return {"part.gltf": json.dumps(described).encode(), "numbers.bin": numbers}


@dataclass(frozen=True)
class Kind:
    """Mesh file format with sample files.

    Attributes:
        good: Function that returns valid files.
        spoil: Function that returns a damaged mesh file: a vertex has a NaN, or a count is invalid.
        size: Size of the valid mesh along x, y and z, in metres.
    """

    good: Callable[[], Files]
    spoil: Callable[[bytes], bytes]
    size: tuple[float, float, float] = (1.0, 2.0, 3.0)


def _one(name: str, kind: str, **options: object) -> Callable[[], Files]:
    return lambda: {name: exported(kind, **options)}


def _replaced(old: bytes, new: bytes) -> Callable[[bytes], bytes]:
    def spoil(content: bytes) -> bytes:
        assert old in content
        return content.replace(old, new, 1)

    return spoil


_NAN = np.float32(np.nan).tobytes()
_CORNER = TRIANGLES[0, 0].tobytes()
_SPOILT_CORNER = TRIANGLES[0, 0, :2].tobytes() + _NAN
_spoil_binary = _replaced(_CORNER, _SPOILT_CORNER)

KINDS = {
    "text STL": Kind(_one("part.stl", "stl_ascii"), _replaced(b"vertex -0.5", b"vertex nan")),
    "binary STL": Kind(_one("part.stl", "stl"), _spoil_binary),
    "OBJ": Kind(_one("part.obj", "obj"), _replaced(b"v -0.5", b"v nan")),
    "OBJ with a texture": Kind(painted_obj, _replaced(b"v -0.5", b"v nan")),
    "COLLADA": Kind(_one("part.dae", "dae"), _replaced(b">-0.5", b">nan")),
    "COLLADA with a texture": Kind(
        painted_dae, _replaced(b">-0.5", b">nan"), (0.0254, 0.0508, 0.0762)
    ),
    "GLB": Kind(_one("part.glb", "glb"), _spoil_binary),
    "glTF": Kind(gltf, lambda content: content.replace(b'"count": 36', b'"count": -1')),
    "text PLY": Kind(_one("part.ply", "ply", encoding="ascii"), _replaced(b"\n-0.5", b"\nnan")),
    "binary PLY": Kind(_one("part.ply", "ply"), _spoil_binary),
}
"""Samples of all mesh file formats, by name."""
