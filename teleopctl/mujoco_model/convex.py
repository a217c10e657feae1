"""Collision meshes that are hollow or bent, as several convex pieces.

MuJoCo uses a mesh's convex hull for collisions, so that nothing fits into a ring or between two
fingers of one part. Where CoACD is installed (the extra ``decomposition``), such meshes are cut
into pieces once and cached in the user's cache folder; `decompose_files` does so in parallel.
Fixed meshes with few triangles, such as walls, need no pieces: each of their triangles touches as a
thin slab. A warning reports each hull that is still larger than its mesh.
"""

from __future__ import annotations

import hashlib
import io
import logging
import os
import subprocess
import sys
from collections.abc import Collection, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt

from teleopctl.base import progress
from teleopctl.base.folders import cache_dir
from teleopctl.mujoco_model.mesh_content import alone_with, load_mesh_content
from teleopctl.robot import InvalidMeshError

# A mesh is hollow if its hull has more than this multiple of its volume.
_HOLLOW = 1.5
# A mesh is open if its open edges are longer than its width, depth and height together: inexact
# seams, which CAD leaves, are shorter; those of an open box or a tube are longer. Vertices that are
# nearer to each other than this fraction of the mesh's size count as one.
_OPEN_EDGES = 1.0
_SAME_CORNER = 1e-5

# CoACD's own defaults take ten seconds for each mesh; these settings take one second, with the same
# pieces for simple parts. The threshold is the concavity of a piece, as a fraction of its size.
_SETTINGS = {
    "threshold": 0.1,
    "max_convex_hull": 16,
    "resolution": 500,
    "preprocess_resolution": 30,
    "mcts_nodes": 10,
    "mcts_iterations": 60,
    "mcts_max_depth": 2,
    "seed": 0,
}
_EDITION = b"2"
_PIECES = ".convex.npz"
# Attributes of a collision shape that its pieces get.
_KEPT = (
    *("pos", "quat", "group", "rgba", "contype", "conaffinity", "condim", "priority", "friction"),
    *("solmix", "solref", "solimp", "margin", "gap", "userdata"),
)
# Most triangles of a mesh that touches as slabs, and the greatest thickness of a slab in metres.
_MOST_SLABS = 256
_SLAB_M = 0.05

# Vertices, (n, 3), in metres, and triangles as indices of vertices, (m, 3).
Piece = tuple[npt.NDArray[np.float32], npt.NDArray[np.int32]]


def can_decompose() -> bool:
    """Return whether CoACD, which cuts meshes into convex pieces, is installed."""
    return find_spec("coacd") is not None


class Hull(NamedTuple):
    """Comparison of a mesh with its convex hull: ratio of volumes, and whether the mesh is open.

    Attributes:
        ratio: Volume of the hull divided by that of the mesh; 1 if unknown.
        is_open: Whether the mesh is far from closed, so that its volume is meaningless.
    """

    ratio: float
    is_open: bool

    @property
    def fault(self) -> str:
        """End of a warning that the mesh collides as its hull, and why; empty if the hull fits."""
        if self.is_open:
            return "collides as its convex hull: it is not closed"
        if self.ratio <= _HOLLOW:
            return ""
        cure = "" if can_decompose() else "; install teleopctl[decomposition] for convex pieces"
        return f"collides as its convex hull, which has {self.ratio:.1f} times its volume{cure}"


def measure_hull(path: Path) -> Hull:
    """Return a mesh file's `Hull`, the comparison with its convex hull, from the cache if there."""
    kept = _kept_at(path, ".volumes")
    try:
        ratio, is_open = kept.read_text("utf-8").split()
        return Hull(float(ratio), is_open == "open")
    except (OSError, ValueError):
        pass  # no usable cache entry
    hull = _measured(path)
    _keep(kept, f"{hull.ratio!r} {'open' if hull.is_open else 'closed'}".encode())
    return hull


def needs_decomposition(path: Path) -> bool:
    """Return whether a mesh file needs convex pieces that are not yet cached."""
    hull = measure_hull(path)
    return not hull.is_open and hull.ratio > _HOLLOW and not _kept_at(path, _PIECES).is_file()


def convex_pieces(path: Path) -> list[Piece]:
    """Return a mesh file's convex pieces, cut once and cached; none if open or not hollow."""
    hull = measure_hull(path)
    if hull.is_open or hull.ratio <= _HOLLOW:
        return []
    kept = _kept_at(path, _PIECES)
    if (found := _found(kept)) is not None:
        return found
    # The programs of a robot that start together need the same meshes.
    with alone_with(kept):
        found = _found(kept)
        return _cut_and_kept(path, kept) if found is None else found


def _found(kept: Path) -> list[Piece] | None:
    """Return the cached pieces; None if the file is missing or unusable."""
    try:
        return _loaded(kept) if kept.is_file() else None
    except (OSError, ValueError, KeyError):
        return None


def _cut_and_kept(path: Path, kept: Path) -> list[Piece]:
    pieces = _cut(path)
    arrays: dict[str, npt.NDArray[Any]] = {}
    for number, (vertices, faces) in enumerate(pieces):
        arrays[f"vertices{number}"], arrays[f"faces{number}"] = vertices, faces
    stream = io.BytesIO()
    np.savez(stream, count=np.array(len(pieces)), **arrays)  # type: ignore[arg-type]
    _keep(kept, stream.getvalue())
    return pieces


def surface_slabs(path: Path, scale: Sequence[float]) -> list[npt.NDArray[np.float64]]:
    """Return thin convex slabs, one per triangle of a small, closed, hollow mesh; none for others.

    Args:
        path: The mesh file.
        scale: Scale of the mesh along x, y and z.

    Returns:
        Six corners of each slab, (6, 3), in metres; none if the mesh has too many triangles, is
        not closed, or is not hollow.
    """
    mesh = _trimesh(path)
    if mesh is None or not 0 < len(mesh.faces) <= _MOST_SLABS:
        return []
    mesh.apply_transform(np.diag([*scale, 1.0]))
    if not mesh.is_watertight or measure_hull(path).ratio <= _HOLLOW:
        return []
    # Half as thick as the mesh is on average, so that no slab protrudes on the other side.
    depth = min(abs(mesh.volume) / mesh.area, _SLAB_M)
    inwards = -np.sign(mesh.volume) * mesh.face_normals[:, None, :]
    outer = mesh.triangles
    # Narrower inside: at sharp edges a slab would protrude as well.
    middle = outer.mean(axis=1, keepdims=True)
    inner = (outer + middle) / 2.0 + depth * inwards
    return list(np.concatenate([outer, inner], axis=1)[mesh.area_faces > 0.0])


# Any stands for MuJoCo's elements, which have no types.
def replace_collisions(spec: mujoco.MjSpec, mesh: Any, pieces: Sequence[Piece]) -> None:
    """Replace the collision shape of a mesh by convex pieces; visual shapes stay.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        mesh: The mesh to replace.
        pieces: Convex pieces of the mesh.
    """
    names = []
    for number, (vertices, faces) in enumerate(pieces):
        piece = spec.add_mesh(name=f"{mesh.name}/convex{number}", scale=mesh.scale)
        piece.uservert, piece.userface = vertices.ravel().tolist(), faces.ravel().tolist()
        names.append(piece.name)
    for geom in collision_geoms(spec, mesh):
        for name in names:
            geom.parent.add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=name,
                **{attribute: getattr(geom, attribute) for attribute in _KEPT},
            )
        spec.delete(geom)
    if not any(geom.meshname == mesh.name for geom in spec.geoms):
        spec.delete(mesh)


def collision_geoms(spec: mujoco.MjSpec, mesh: Any) -> list[Any]:
    """Return the geoms of a spec that use a mesh and take part in collisions."""
    return [geom for geom in spec.geoms if geom.meshname == mesh.name and geom.contype]


def _trimesh(path: Path) -> Any:
    import trimesh

    try:
        content = load_mesh_content(path)
    except InvalidMeshError:
        return None
    return trimesh.Trimesh(content.vertices, content.faces)


def _measured(path: Path) -> Hull:
    mesh = _trimesh(path)
    if mesh is None:
        return Hull(1.0, is_open=False)
    try:
        # trimesh also computes the centre, and divides by zero where there is no volume.
        with np.errstate(divide="ignore", invalid="ignore"):
            volume, hull = abs(float(mesh.volume)), _hull_volume(mesh)
    except Exception:  # noqa: BLE001 - flat and broken meshes raise all kinds of exceptions
        return Hull(1.0, is_open=False)
    if hull <= 0.0:
        return Hull(1.0, is_open=False)
    # Two-sided sheets are closed but have no inside.
    if volume <= 1e-3 * hull or _open_edges(mesh) > _OPEN_EDGES:
        return Hull(1.0, is_open=True)
    return Hull(hull / volume, is_open=False)


# Any: trimesh's mesh, whose class has no reliable types.
def _hull_volume(mesh: Any) -> float:
    """Return the volume of a mesh's convex hull, m³, by MuJoCo: trimesh needs scipy for it.

    Raises:
        ValueError: The mesh is flat, or has no hull for another reason.
    """
    size = float(mesh.extents.max())
    spec = mujoco.MjSpec()
    made = spec.add_mesh(name="mesh", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
    made.uservert = (mesh.vertices / size).ravel().tolist()
    made.userface = mesh.faces.ravel().tolist()
    body = spec.worldbody.add_body()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", density=1.0)
    return float(spec.compile().body_mass[1]) * size**3


# Any: trimesh's mesh, whose class has no reliable types.
def _open_edges(mesh: Any) -> float:
    """Return the length of all open edges, divided by the sum of the mesh's three extents."""
    sides = float(mesh.extents.sum())
    places = np.round(mesh.vertices / (_SAME_CORNER * sides)).astype(np.int64)
    corners = np.unique(places, axis=0, return_inverse=True)[1].ravel()
    edges = np.sort(corners[mesh.edges], axis=1)
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    start, end = mesh.vertices[mesh.edges[first[count == 1]]].transpose(1, 0, 2)
    return float(np.linalg.norm(end - start, axis=1).sum()) / sides


def _kept_at(path: Path, suffix: str) -> Path:
    digest = hashlib.sha256(_EDITION + path.suffix.lower().encode() + path.read_bytes())
    return Path(cache_dir()) / "meshes" / f"{digest.hexdigest()}{suffix}"


def _keep(file: Path, content: bytes) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        # Other processes may write the same file.
        unfinished = file.with_suffix(f".{os.getpid()}")
        unfinished.write_bytes(content)
        unfinished.replace(file)
    except OSError:
        pass  # computed again the next time


def _cut(path: Path) -> list[Piece]:
    import coacd

    mesh = _trimesh(path)
    coacd.set_log_level("error")
    cut = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces), **_SETTINGS)
    pieces = [(np.asarray(v, np.float32), np.asarray(f, np.int32)) for v, f in cut]
    return pieces if len(pieces) > 1 else []


def _loaded(file: Path) -> list[Piece]:
    with np.load(file, allow_pickle=False) as arrays:
        return [
            (arrays[f"vertices{number}"], arrays[f"faces{number}"])
            for number in range(int(arrays["count"]))
        ]


_log = logging.getLogger(__name__)

_CUTTING = "cutting hollow meshes into convex pieces"
# Each process writes this line after each of its meshes.
_DONE = b"done\n"


def decompose_files(files: Collection[Path]) -> None:
    """Cut hollow mesh files into convex pieces, in parallel processes, into the cache.

    Files that cannot be cut this way, because no process can be started or the folder cannot be
    written, are left to `convex_pieces`.
    """
    missing = sorted({file for file in files if needs_decomposition(file)}, key=_size, reverse=True)
    if not missing:
        return
    _log.warning(
        "Cutting hollow meshes into convex pieces, up to half a minute for each: %s. They are kept "
        "for the next time",
        ", ".join(file.name for file in missing),
    )
    count = min(len(missing), os.cpu_count() or 1)
    progress.doing(_CUTTING)
    processes: list[subprocess.Popen[bytes]] = []
    read, write = os.pipe()
    try:
        for number in range(count):
            # Sorted by size and dealt out in turn: all processes take about the same time.
            share = [str(file.absolute()) for file in missing[number::count]]
            command = [sys.executable, "-P", "-m", __name__, *share]
            # The processes receive Ctrl-C too, and each would print a traceback.
            nowhere = subprocess.DEVNULL
            processes.append(subprocess.Popen(command, stdin=nowhere, stdout=write, stderr=nowhere))
        os.close(write)
        write = -1
        with open(read, "rb", closefd=False) as lines:
            for done, _ in enumerate((line for line in lines if line == _DONE), 1):
                progress.doing(f"{_CUTTING}: {done} of {len(missing)}")
        for process in processes:
            process.wait()
    except OSError:
        pass  # left to convex_pieces
    finally:
        os.close(read)
        if write != -1:
            os.close(write)
        for process in processes:
            process.kill()
            process.wait()


def _size(file: Path) -> int:
    return file.stat().st_size


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        convex_pieces(Path(argument))
        os.write(1, _DONE)
