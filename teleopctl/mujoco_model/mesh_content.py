"""Mesh files that MuJoCo does not read itself: their triangles and materials, kept by content.

Reading a COLLADA file takes up to a second, and a robot has dozens. So what was read is kept in the
user's cache folder under a hash of the file's bytes: a file that changes is another one. The
simulator, the camera and the page want the same files at the same time: one reads, the others wait.
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
from teleopctl.base.text_file import absence
from teleopctl.mujoco_model.paint import Part, parts_of
from teleopctl.robot import collada_unit_m, picture_places

try:
    import fcntl
except ImportError:  # Windows: there each reads for itself
    _HAS_LOCKS = False
else:
    _HAS_LOCKS = True

_log = logging.getLogger(__name__)

# What MuJoCo's own reader of STL takes.
_FAR_M = 2.0**30
# What is read at all: a hundred times what MuJoCo takes of an STL file, in bytes.
_LARGEST = 1_000_000_000
# Files that say everything themselves; others name files of colours and pictures.
_WHOLE = frozenset({".dae", ".glb", ".stl"})
# Goes up when what is kept would be read otherwise than before.
_EDITION = b"2"


@dataclass(frozen=True)
class MeshContent:
    """What a mesh file holds.

    Attributes:
        vertices: Corners, (n, 3), in metres.
        faces: Triangles as numbers of corners, (m, 3).
        parts: The same by materials; none where the file says nothing of colours.
    """

    vertices: npt.NDArray[np.float32]
    faces: npt.NDArray[np.int32]
    parts: tuple[Part, ...]

    @property
    def has_pictures(self) -> bool:
        """Whether it is drawn with pictures, which are files of their own."""
        return any(part.picture is not None for part in self.parts)


def unreadable(path: Path) -> str | None:
    """Why a mesh file is not to be read, too large or not there yet; None for others.

    Raises:
        OSError: It is not there.
    """
    size = path.stat().st_size
    if size <= _LARGEST:
        why = absence(path)
        return f"{path} {why}" if why else None
    return f"{path} has {size / 1e9:.1f} GB; at most {_LARGEST / 1e9:.0f} GB are read"


def read_mesh(path: Path) -> MeshContent | str:
    """Read a mesh file; returns its content, or why that is not possible."""
    try:
        if (reason := unreadable(path)) is not None:
            return reason
        kept = _kept_at(path)
    except OSError:
        kept = None
    if (content := _found(kept)) is not None:
        return content
    with _alone(kept):
        return _found(kept) or _read_and_kept(path, kept)


def _found(kept: Path | None) -> MeshContent | None:
    """What has been kept, if anything of use has."""
    try:
        return _loaded(kept) if kept is not None and kept.is_file() else None
    except (OSError, ValueError, KeyError):
        return None


def _read_and_kept(path: Path, kept: Path | None) -> MeshContent | str:
    content = _read(path)
    if kept is not None and isinstance(content, MeshContent) and not content.has_pictures:
        _keep(kept, content)
    return content


@contextlib.contextmanager
def _alone(kept: Path | None) -> Iterator[None]:
    """Let other processes wait that read the same file, until it is kept."""
    if kept is None or not _HAS_LOCKS:
        yield
        return
    lock = kept.with_suffix(".lock")
    with contextlib.ExitStack() as held:
        # Where nothing can be written, or a network's file system has no locks, each reads alone.
        with contextlib.suppress(OSError):
            lock.parent.mkdir(parents=True, exist_ok=True)
            stream = held.enter_context(lock.open("w"))
            # The system lets go of it when the process dies, however it does.
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


def _read(path: Path) -> MeshContent | str:
    scene = _scene(path)
    if isinstance(scene, str):
        return scene
    try:
        whole: Any = scene.to_mesh()
    except Exception as error:  # noqa: BLE001 - trimesh's readers raise whatever their parsers do
        return f"{path} cannot be read: {error}"
    unit_m = _unit_m(path, scene)
    whole.apply_scale(unit_m)
    if len(whole.faces) == 0:
        return f"{path} holds no triangles"
    # A comparison with NaN is false.
    if not (np.abs(whole.vertices) < _FAR_M).all():
        return f"{path} has coordinates that are no numbers, or too large"
    whole.merge_vertices()
    try:
        parts = parts_of(scene, unit_m, is_gltf=path.suffix.lower() in (".glb", ".gltf"))
    except BudgetError as error:
        _log.warning("%s is drawn without its picture: %s", path, error)
        parts = []
    except Exception:  # noqa: BLE001 - as above; then it has no colours, and all of its shape
        parts = []
    return MeshContent(
        whole.vertices.astype(np.float32), whole.faces.astype(np.int32), tuple(parts)
    )


# Any: what trimesh has read.
def _scene(path: Path) -> Any:
    import trimesh
    from trimesh.resolvers import FilePathResolver

    class Pictures(FilePathResolver):
        """Finds pictures outside of the mesh's folder too, where Gazebo's models have them."""

        def get(self, name: str) -> bytes:
            for place in picture_places(path, name.strip()):
                if place.is_file():
                    return place.read_bytes()
            raise FileNotFoundError(name)

    # A picture that is not there makes trimesh log a traceback.
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    try:
        # Left to itself it takes triangles without a word whose corners are no numbers.
        return trimesh.load_scene(path, resolver=Pictures(str(path)), process=False)
    except Exception as error:  # noqa: BLE001 - trimesh's readers raise whatever their parsers do
        return f"{path} cannot be read: {error}"


def _unit_m(path: Path, scene: Any) -> float:
    if path.suffix.lower() != ".dae":
        return 1.0
    return collada_unit_m(part.metadata for part in scene.geometry.values())


def _keep(file: Path, content: MeshContent) -> None:
    arrays: dict[str, npt.NDArray[Any]] = {"vertices": content.vertices, "faces": content.faces}
    for number, part in enumerate(content.parts):
        arrays[f"vertices{number}"] = part.vertices
        arrays[f"faces{number}"] = part.faces
        arrays[f"rgba{number}"] = np.array(() if part.rgba is None else part.rgba)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        # Others may be writing the same one.
        unfinished = file.with_suffix(f".{os.getpid()}")
        with unfinished.open("wb") as stream:
            np.savez(stream, **arrays)  # type: ignore[arg-type]
        unfinished.replace(file)
    except OSError:
        pass  # it is read anew the next time


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
