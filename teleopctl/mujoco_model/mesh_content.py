"""Mesh files that MuJoCo does not read itself: their triangles and materials, kept by content.

Reading a COLLADA file takes up to a second, and a robot has dozens. So the content is cached in the
user's cache folder under a hash of the file's bytes; a changed file gets a new entry. The
simulator, cameras and web page need the same files at the same time: one process reads, the others
wait.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.base.budget import BudgetError
from teleopctl.base.folders import cache_dir
from teleopctl.mujoco_model.paint import Part, parts_of
from teleopctl.robot import check_mesh_file, read_mesh

try:
    import fcntl
except ImportError:  # Windows: each process reads the file itself
    _HAS_LOCKS = False
else:
    _HAS_LOCKS = True

_log = logging.getLogger(__name__)

# Formats that are complete in one file; others refer to files with materials and textures.
_WHOLE = frozenset({".dae", ".glb", ".stl"})
# Increased when the cached content of a file would differ from before.
_EDITION = b"3"


@dataclass(frozen=True)
class MeshContent:
    """Triangles and materials of a mesh file, as read or cached.

    Attributes:
        vertices: Vertices, (n, 3), in metres.
        faces: Triangles as indices of vertices, (m, 3).
        parts: The triangles by material; empty where the file has no colours.
        faults: Left-out parts of the file, each as the words after the file's name in a warning.
    """

    vertices: npt.NDArray[np.float32]
    faces: npt.NDArray[np.int32]
    parts: tuple[Part, ...]
    faults: tuple[str, ...] = ()

    @property
    def has_pictures(self) -> bool:
        """Whether any part of the mesh has a texture."""
        return any(part.picture is not None for part in self.parts)


def load_mesh_content(path: Path) -> MeshContent:
    """Return a mesh file's triangles and materials, from the cache if there; raise if unreadable.

    Raises:
        InvalidMeshError: The file cannot be read; see `teleopctl.robot.read_mesh`.
    """
    check_mesh_file(path)
    try:
        kept = _kept_at(path)
    except OSError:
        kept = None
    if (content := _found(kept)) is not None:
        return content
    with alone_with(kept):
        return _found(kept) or _read_and_kept(path, kept)


def _found(kept: Path | None) -> MeshContent | None:
    """Return the cached content; None if the file is missing or unusable."""
    try:
        return _loaded(kept) if kept is not None and kept.is_file() else None
    except (OSError, ValueError, KeyError):
        return None


def _read_and_kept(path: Path, kept: Path | None) -> MeshContent:
    content = _read(path)
    # Textures may be separate files, and a missing one may be added later.
    if kept is not None and not content.has_pictures and not content.faults:
        _keep(kept, content)
    return content


@contextlib.contextmanager
def alone_with(kept: Path | None) -> Iterator[None]:
    """Lock an entry of the cache, so that other processes wait until it is written.

    Args:
        kept: File of the entry; None for content that is not kept.
    """
    if kept is None or not _HAS_LOCKS:
        yield
        return
    lock = kept.with_suffix(".lock")
    with contextlib.ExitStack() as held:
        # Without a writable folder, or on a network file system without locks, each process reads.
        with contextlib.suppress(OSError):
            lock.parent.mkdir(parents=True, exist_ok=True)
            stream = held.enter_context(lock.open("w"))
            # The operating system releases the lock when the process ends, for whatever reason.
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX)
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                lock.unlink()


def _kept_at(path: Path) -> Path | None:
    if path.suffix.lower() not in _WHOLE:
        return None
    digest = hashlib.sha256(_EDITION + path.suffix.lower().encode() + path.read_bytes())
    return Path(cache_dir()) / "meshes" / f"{digest.hexdigest()}.npz"


def _read(path: Path) -> MeshContent:
    mesh = read_mesh(path)
    corners, triangles = mesh.triangles()
    import trimesh

    whole = trimesh.Trimesh(corners, triangles, process=False)
    whole.merge_vertices()
    parts: list[Part] = []
    if mesh.scene is not None:
        try:
            parts = parts_of(mesh.scene, is_gltf=path.suffix.lower() in (".glb", ".gltf"))
        except BudgetError as error:
            _log.warning("%s is drawn without its texture: %s", path, error)
        except Exception:  # noqa: BLE001, S110 - trimesh raises any exception; the shape is read
            pass
    return MeshContent(
        whole.vertices.astype(np.float32),
        whole.faces.astype(np.int32),
        tuple(parts),
        tuple(mesh.faults),
    )


def _keep(file: Path, content: MeshContent) -> None:
    arrays: dict[str, npt.NDArray[Any]] = {"vertices": content.vertices, "faces": content.faces}
    for number, part in enumerate(content.parts):
        arrays[f"vertices{number}"] = part.vertices
        arrays[f"faces{number}"] = part.faces
        arrays[f"rgba{number}"] = np.array(() if part.rgba is None else part.rgba)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        # Other processes may write the same file.
        unfinished = file.with_suffix(f".{os.getpid()}")
        with unfinished.open("wb") as stream:
            np.savez(stream, **arrays)  # type: ignore[arg-type]
        unfinished.replace(file)
    except OSError:
        pass  # the mesh file is read again the next time


def _loaded(file: Path) -> MeshContent:
    with np.load(file, allow_pickle=False) as arrays:
        parts: list[Part] = []
        while f"rgba{len(parts)}" in arrays:
            number = len(parts)
            rgba = arrays[f"rgba{number}"].tolist()
            parts.append(
                Part(
                    arrays[f"vertices{number}"],
                    arrays[f"faces{number}"],
                    tuple(rgba) if rgba else None,
                )
            )
        return MeshContent(arrays["vertices"], arrays["faces"], tuple(parts))
