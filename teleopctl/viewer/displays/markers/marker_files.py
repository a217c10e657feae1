"""Loading of the meshes and textures of markers, each once, in another thread."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.viewer.scene.assets import (
    MeshFile,
    load_embedded_mesh,
    load_embedded_texture,
    load_mesh,
    load_texture,
)
from teleopctl.viewer.scene.gltf import Texture

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any: messages, whose classes are created from definitions at run time.

MESH, TRIANGLES = 10, 11
_EMBEDDED = "embedded://"
_BARE = "#bare"
_TEXTURE = "#texture"
# Number of unused files that are kept, since markers are often deleted and added again.
_MOST_UNUSED = 20
# Files read at the same time. Queued files are dropped once unused, since a program may send
# another texture with each message.
_MOST_AT_ONCE = 4


def marker_file_key(marker: Any) -> str:
    """Return the key by which `MarkerFiles` stores a marker's mesh or texture; empty for none."""
    if marker.type == MESH:
        uri, data = str(marker.mesh_resource), marker.mesh_file.data
        suffix = "" if marker.mesh_use_embedded_materials else _BARE
    elif marker.type == TRIANGLES and len(marker.uv_coordinates):
        uri, data, suffix = str(marker.texture_resource), marker.texture.data, _TEXTURE
    else:
        return ""
    if uri.startswith(_EMBEDDED):
        uri += f"#{zlib.crc32(bytes(data)):08x}"
    return uri + suffix if uri else ""


class MarkerFiles:
    """Cache of markers' meshes and textures, which loads each once, in another thread.

    Args:
        stage: The viewer's node.
        arrived: Function called on the node's thread when a file was loaded or could not be loaded.

    Attributes:
        meshes: Loaded meshes, by key; see `marker_file_key`.
        textures: Loaded textures, by key; None for a texture that cannot be read.
        faults: Reasons why files cannot be read, or parts of files are not shown, by key.
    """

    def __init__(self, stage: Stage, arrived: Callable[[], object]) -> None:
        self.meshes: dict[str, MeshFile] = {}
        self.textures: dict[str, Texture | None] = {}
        self.faults: dict[str, str] = {}
        self._stage = stage
        self._arrived = arrived
        self._requested: set[str] = set()
        self._reading = 0
        self._waiting: dict[str, Callable[[], MeshFile | Texture]] = {}

    def request(self, marker: Any) -> str:
        """Start loading a marker's mesh or texture, unless requested before; return its key.

        Returns:
            The key of the mesh or texture, or an empty text if the marker has none.
        """
        key = marker_file_key(marker)
        if key and key not in self._requested:
            self._requested.add(key)
            self._waiting[key] = _reader(marker)
            self._read_next()
        return key

    def drop_unused(self, used: Iterable[str]) -> None:
        """Drop files not in ``used``: waiting ones, and all loaded ones if these are more than 20.

        Args:
            used: Keys that markers use.
        """
        unused = self._requested.difference(used)
        for key in unused & self._waiting.keys():
            self._requested.discard(key)
            del self._waiting[key]
        done = unused & (self.meshes.keys() | self.textures.keys() | self.faults.keys())
        if len(done) > _MOST_UNUSED:
            self._requested -= done
            for key in done:
                for known in (self.meshes, self.textures, self.faults):
                    known.pop(key, None)

    def _read_next(self) -> None:
        while self._waiting and self._reading < _MOST_AT_ONCE:
            key = next(iter(self._waiting))
            self._reading += 1
            self._stage.run_in_background(self._waiting.pop(key), partial(self._take, key))

    def _take(self, key: str, result: MeshFile | Texture | BaseException) -> None:
        self._reading -= 1
        if isinstance(result, MeshFile):
            self.meshes[key] = result
            if result.faults:
                self.faults[key] = "; ".join(result.faults)
        elif isinstance(result, Texture):
            self.textures[key] = result
        else:
            is_ours = isinstance(result, TeleopctlError)
            self.faults[key] = str(result) if is_ours else f"{_kind(key)} {key}: {result}"
            if key.endswith(_TEXTURE):
                self.textures[key] = None
        self._read_next()
        self._arrived()


def _kind(key: str) -> str:
    return "Texture" if key.endswith(_TEXTURE) else "Mesh"


def _reader(marker: Any) -> Callable[[], MeshFile | Texture]:
    """Return the function that loads a marker's mesh or texture."""
    if marker.type == TRIANGLES:
        uri = str(marker.texture_resource)
        if uri.startswith(_EMBEDDED):
            picture = bytes(marker.texture.data)
            return lambda: load_embedded_texture(uri, picture)
        return lambda: load_texture(uri)
    uri, bare = str(marker.mesh_resource), not marker.mesh_use_embedded_materials
    if uri.startswith(_EMBEDDED):
        name, data = str(marker.mesh_file.filename or uri), bytes(marker.mesh_file.data)
        return lambda: load_embedded_mesh(name, data, bare=bare)
    return lambda: load_mesh(uri, bare=bare)
