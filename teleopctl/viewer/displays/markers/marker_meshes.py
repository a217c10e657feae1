"""The mesh files that markers name, each read once, in a thread that may take its time."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from teleopctl.errors import TeleopctlError
from teleopctl.viewer.scene.mesh_files import MeshFile, load_embedded_mesh, load_mesh

if TYPE_CHECKING:
    from teleopctl.viewer.displays.base import Stage

# Any stands for messages: their classes are made at run time, from definitions.

_EMBEDDED = "embedded://"
_BARE = "#bare"
# Meshes that no marker uses any more are kept up to this many, since markers come and go.
_MOST_UNUSED = 20


def mesh_key(marker: Any) -> str:
    """The name of a marker's mesh among all: where it is, and whether in its own materials."""
    uri = str(marker.mesh_resource)
    if uri.startswith(_EMBEDDED):
        uri += f"#{zlib.crc32(bytes(marker.mesh_file.data)):08x}"
    return uri if marker.mesh_use_embedded_materials else uri + _BARE


class MarkerMeshes:
    """Meshes by their keys.

    Args:
        stage: Who has a thread for reading.
        arrived: Called when one more has been read, or cannot be.

    Attributes:
        ready: What has been read.
        faults: Why others cannot be, or what is not shown of those.
    """

    def __init__(self, stage: Stage, arrived: Callable[[], object]) -> None:
        self.ready: dict[str, MeshFile] = {}
        self.faults: dict[str, str] = {}
        self._stage = stage
        self._arrived = arrived
        self._asked: set[str] = set()

    def want(self, marker: Any) -> None:
        """Read a marker's mesh, unless that has been done."""
        key = mesh_key(marker)
        if key in self._asked:
            return
        self._asked.add(key)
        uri, bare = str(marker.mesh_resource), not marker.mesh_use_embedded_materials
        if uri.startswith(_EMBEDDED):
            name, data = str(marker.mesh_file.filename or uri), bytes(marker.mesh_file.data)

            def read() -> MeshFile:
                return load_embedded_mesh(name, data, bare=bare)
        else:

            def read() -> MeshFile:
                return load_mesh(uri, bare=bare)

        self._stage.work(read, lambda result: self._take(key, result))

    def forget_unused(self, used: Iterable[str]) -> None:
        """Let go of what no marker uses, if it has become much."""
        unused = self._asked.difference(used)
        if len(unused) > _MOST_UNUSED:
            for key in unused & (self.ready.keys() | self.faults.keys()):
                self._asked.discard(key)
                self.ready.pop(key, None)
                self.faults.pop(key, None)

    def _take(self, key: str, result: MeshFile | BaseException) -> None:
        if isinstance(result, MeshFile):
            self.ready[key] = result
            if result.faults:
                self.faults[key] = "; ".join(result.faults)
        else:
            is_ours = isinstance(result, TeleopctlError)
            self.faults[key] = str(result) if is_ours else f"Mesh {key}: {result}"
        self._arrived()
