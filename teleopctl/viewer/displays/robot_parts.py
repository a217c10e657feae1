"""The files that a robot description names, read in the thread of work."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from teleopctl.errors import TeleopctlError
from teleopctl.robot import Geometry, Mesh, RobotDescription
from teleopctl.viewer.scene.mesh_files import MeshFile, load_mesh, packed, stamp_of_file
from teleopctl.viewer.scene.shapes import mesh_uris, undrawable
from teleopctl.viewer.scene.texture_files import Texture, load_texture

# Meshes of so many links are sent as glTF, of which viser compresses equal ones to one.
_MANY_USES = 4


@dataclass(frozen=True, slots=True)
class Parts:
    """The meshes and textures of a robot, and the faults of their files.

    Attributes:
        meshes: Meshes by URI.
        textures: The URDF's textures by URI.
        faults: What cannot be shown, one sentence each.
    """

    meshes: dict[str, MeshFile] = field(default_factory=dict)
    textures: dict[str, Texture] = field(default_factory=dict)
    faults: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        # Arrays have no truth of their own; the same file of the same time is the same mesh.
        return (
            isinstance(other, Parts)
            and self.faults == other.faults
            and self.textures == other.textures
            and self.meshes.keys() == other.meshes.keys()
            and all(self.meshes[uri] is other.meshes[uri] for uri in self.meshes)
        )

    __hash__ = None  # type: ignore[assignment]


def load_parts(description: RobotDescription, known: Parts, folder: Path | None = None) -> Parts:
    """Read a robot's meshes and textures; unchanged files are reused.

    Args:
        description: The robot.
        known: What was read before.
        folder: Where the description is from, for paths that are relative to it.
    """
    meshes: dict[str, MeshFile] = {}
    textures: dict[str, Texture] = {}
    faults = list(description.repairs)
    shapes = shapes_of(description)
    uses = Counter(shape.uri for shape in shapes if isinstance(shape, Mesh))
    for uri in mesh_uris(shapes):
        old = known.meshes.get(uri)
        if old is not None and _is_unchanged(old):
            meshes[uri] = old
        else:
            try:
                meshes[uri] = load_mesh(uri, folder)
            except TeleopctlError as error:
                faults.append(error.message)
                continue
        if uses[uri] >= _MANY_USES:
            meshes[uri] = packed(meshes[uri])
        faults += meshes[uri].faults
    for uri in _texture_uris(description):
        before = known.textures.get(uri)
        if before is not None and _is_unchanged(before):
            textures[uri] = before
            continue
        try:
            textures[uri] = load_texture(uri, folder)
        except TeleopctlError as error:
            faults.append(error.message)
    if strange := _links_with_undrawable_shapes(description):
        more = f" and {len(strange) - 1} more links" if len(strange) > 1 else ""
        faults.append(
            f"Shapes of link '{strange[0]}'{more} are not drawn: "
            "their sizes must be positive, finite numbers"
        )
    return Parts(meshes, textures, tuple(dict.fromkeys(faults)))


def _is_unchanged(file: MeshFile | Texture) -> bool:
    try:
        return file.path is not None and stamp_of_file(file.path) == file.stamp
    except OSError:
        return False


def shapes_of(description: RobotDescription) -> list[Geometry]:
    """Return all shapes of a robot, visual ones first."""
    links = description.links.values()
    return [visual.geometry for link in links for visual in link.visuals] + [
        collision.geometry for link in links for collision in link.collisions
    ]


def _links_with_undrawable_shapes(description: RobotDescription) -> list[str]:
    return [
        link.name
        for link in description.links.values()
        if any(undrawable(one.geometry, one.origin) for one in link.visuals)
        or any(undrawable(one.geometry, one.origin) for one in link.collisions)
    ]


def _texture_uris(description: RobotDescription) -> list[str]:
    found: dict[str, None] = {}
    for link in description.links.values():
        for visual in link.visuals:
            if visual.material is not None and visual.material.texture is not None:
                found[visual.material.texture] = None
    return list(found)
