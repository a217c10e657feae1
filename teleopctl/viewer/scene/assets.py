"""Mesh and texture files as a browser draws them: glTF, bare triangles, PNG and JPEG.

STL files contain no colours, so they are drawn in the URDF's. OBJ, COLLADA, glTF and PLY files have
their own materials and textures. As in RViz, the unit of a COLLADA file is applied, and its up axis
is ignored.
"""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from teleopctl.base.budget import check_pixels
from teleopctl.errors import TeleopctlError
from teleopctl.packages import resolve_uri
from teleopctl.tf import Vector3
from teleopctl.viewer.scene.drawing import Rgba
from teleopctl.viewer.scene.gltf import Texture, linear_rgb, prepare_glb

if TYPE_CHECKING:
    from PIL import Image


class MeshError(TeleopctlError):
    """Error: a mesh file cannot be loaded; the text names the file."""


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A loaded mesh in metres: binary glTF, or bare triangles.

    Attributes:
        path: Path of the file.
        glb: The mesh as binary glTF; empty for a mesh without materials.
        vertices: Coordinates, (n, 3), if ``glb`` is empty.
        faces: Triangles as indices of vertices, (m, 3), if ``glb`` is empty.
        box: Lowest and highest corner of the bounding box.
        faults: Sentences about parts that were left out, with the file's name.
        stamp: Size and modification time of the file when it was read; see `file_stamp`.
    """

    path: Path
    glb: bytes
    vertices: npt.NDArray[np.float32] | None = None
    faces: npt.NDArray[np.uint32] | None = None
    box: tuple[Vector3, Vector3] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    faults: tuple[str, ...] = ()
    stamp: tuple[int, int] = (0, 0)


def load_mesh(uri: str, folder: Path | None = None, *, bare: bool = False) -> MeshFile:
    """Return the mesh of a URI, as glTF or bare triangles; raise MeshError if it cannot be read.

    Args:
        uri: ``package://`` or ``file://`` URI, or a path.
        folder: Folder of the description with the URI; see `path_of_uri`.
        bare: Whether to load triangles without materials.

    Raises:
        MeshError: The file is missing, or cannot be read.
    """
    try:
        path = path_of_uri(uri, folder)
    except (TeleopctlError, ValueError, RuntimeError) as error:
        raise MeshError(f"Mesh '{uri}': {error}") from error
    named = f"Mesh {path}" if str(path) == uri else f"Mesh '{uri}': {path}"
    stamp = (0, 0)
    with contextlib.suppress(OSError, ValueError):  # reported by the reader
        stamp = file_stamp(path)
    return _read_mesh_file(named, path, None, stamp, bare=bare)


def load_embedded_mesh(name: str, data: bytes, *, bare: bool = False) -> MeshFile:
    """Return a mesh whose file's content is in a message (``embedded://``), as `MeshFile`.

    Args:
        name: Name of the file; its suffix is the format.
        data: Content of the file.
        bare: Whether to load triangles without materials.

    Raises:
        MeshError: The content is empty, or cannot be read.
    """
    if not data:
        raise MeshError(f"Mesh '{name}' has no data")
    return _read_mesh_file(f"Mesh '{name}'", Path(name), data, (len(data), 0), bare=bare)


def _read_mesh_file(
    named: str, path: Path, data: bytes | None, stamp: tuple[int, int], *, bare: bool
) -> MeshFile:
    """Read a mesh file, or the content of one, for the page.

    Args:
        named: Subject of the sentences about faults: the mesh and its file.
        path: Path of the file.
        data: Content of the file, for a mesh in a message; None to read the file.
        stamp: See `MeshFile`.
        bare: Whether to load triangles without materials.

    Raises:
        MeshError: The mesh cannot be read; see `teleopctl.robot.read_mesh`.
    """
    from teleopctl.robot import read_mesh

    try:
        mesh = read_mesh(path, data)
        (lx, ly, lz), (hx, hy, hz) = mesh.bounds.tolist()
        box = (lx, ly, lz), (hx, hy, hz)
        faults = mesh.faults
        glb, vertices, faces = b"", None, None
        if bare or mesh.scene is None:
            vertices, faces = mesh.triangles()
        else:
            glb, unfit = _scene_glb(mesh.scene, is_gltf=path.suffix.lower() in (".glb", ".gltf"))
            faults = faults + unfit
    except TeleopctlError as error:
        raise MeshError(f"{named} {error.message}") from error
    except Exception as error:
        # trimesh may fail to write a scene that it has read.
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise MeshError(f"{named} cannot be read: {reason}") from error
    sentences = tuple(f"{named} {fault}" for fault in faults)
    return MeshFile(path, glb, vertices, faces, box, sentences, stamp)


# Any: trimesh's results have different types for different file formats.
def _scene_glb(scene: Any, *, is_gltf: bool) -> tuple[bytes, list[str]]:
    """Return a trimesh scene as binary glTF for viser, and the faults of its textures."""
    meshes = list(scene.geometry.values())
    faults = fit_textures(meshes)
    for part in meshes:
        _remove_default_material(part)
        if not is_gltf:
            _linearize_colors(part)
    written = bytes(scene.export(file_type="glb"))
    return prepare_glb(written, is_gltf=is_gltf), faults


def as_glb(mesh: MeshFile) -> MeshFile:
    """Return a `MeshFile` with its bare triangles converted to glTF; others are returned unchanged.

    `colored_glb` sets the colour of the converted mesh.
    """
    if mesh.glb or mesh.vertices is None or mesh.faces is None:
        return mesh
    import trimesh

    triangles: Any = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    written = triangles.export(file_type="glb", include_normals=False)
    glb = prepare_glb(bytes(written), is_gltf=False)
    return replace(mesh, glb=glb, vertices=None, faces=None)


def path_of_uri(uri: str, folder: Path | None = None) -> Path:
    """Return the path of a mesh or texture URI; missing relative paths are taken below ``folder``.

    Args:
        uri: ``package://`` or ``file://`` URI, or a path.
        folder: Folder of the description, for relative paths. RViz resolves no relative paths in a
            description from a topic, but many descriptions contain them.

    Raises:
        NotFoundError: The package is not found.
    """
    path = resolve_uri(uri)
    if folder is None or path.is_absolute() or path.exists():
        return path
    return folder / path


def file_stamp(path: Path) -> tuple[int, int]:
    """Return a file's size and modification time (ns), to detect changes; raise if missing.

    Raises:
        OSError: The file is missing.
    """
    status = path.stat()
    return status.st_size, status.st_mtime_ns


def _remove_default_material(mesh: Any) -> None:
    """Remove the material that trimesh invents for a mesh whose file has none."""
    from trimesh.visual import ColorVisuals, material as materials

    made_up: Any = materials
    material: Any = getattr(mesh.visual, "material", None)
    if not isinstance(material, made_up.SimpleMaterial) or material.kwargs:
        return
    # The texture of the default material has 2 x 2 equal pixels.
    if material.image is None or max(material.image.size) <= 2:
        mesh.visual = ColorVisuals(mesh)


def _linearize_colors(mesh: Any) -> None:
    """Convert a mesh's vertex or face colours to linear light, as glTF has them."""
    visual = mesh.visual
    if getattr(visual, "kind", None) not in ("vertex", "face"):
        return
    colors = np.array(visual.vertex_colors, np.uint8)
    light = linear_rgb(colors[:, :3] / 255.0)
    colors[:, :3] = np.rint(255.0 * light)
    visual.vertex_colors = colors


# Phones do not support larger textures, and textures are sent whole.
_LARGEST_SIDE = 2048
_SLOTS = (
    "image",
    "baseColorTexture",
    "emissiveTexture",
    "normalTexture",
    "occlusionTexture",
    "metallicRoughnessTexture",
)


# Any: trimesh's meshes and materials.


def fit_textures(meshes: Iterable[Any]) -> list[str]:
    """Convert textures of trimesh meshes in place for browsers; return texts about removed ones.

    Returns:
        Faults of textures that were removed, each as the end of a sentence about the file.
    """
    faults: list[str] = []
    for mesh in meshes:
        material = getattr(mesh.visual, "material", None)
        for slot in _SLOTS:
            image = getattr(material, slot, None)
            if image is None:
                continue
            try:
                fitting = fit_texture(image)
            except (OSError, ValueError, SyntaxError) as error:
                setattr(material, slot, None)
                faults.append(f"has a texture that cannot be read: {error}")
            else:
                setattr(material, slot, fitting)
    return list(dict.fromkeys(faults))


def fit_texture(image: Image.Image) -> Image.Image:
    """Return a Pillow image as PNG or JPEG of at most 2048 pixels a side.

    Raises:
        OSError: The image cannot be read.
        BudgetError: The image has too many pixels.
    """
    from PIL import Image

    stored = _stored_smaller(image)
    return image if stored is None else Image.open(io.BytesIO(stored))


def _stored_smaller(image: Image.Image) -> bytes | None:
    """Return a picture converted to a PNG of at most 2048 pixels a side; None if it fits.

    Raises:
        OSError: The picture cannot be read.
        BudgetError: The picture has too many pixels.
    """
    check_pixels(*image.size)
    if image.format in ("PNG", "JPEG") and max(image.size) <= _LARGEST_SIDE:
        image.load()
        return None
    small = image.convert("RGBA" if _is_see_through(image) else "RGB")
    small.thumbnail((_LARGEST_SIDE, _LARGEST_SIDE))
    stored = io.BytesIO()
    small.save(stored, "PNG")
    return stored.getvalue()


def browser_picture(content: bytes) -> tuple[bytes, str, bool, Rgba]:
    """Return a picture file as PNG or JPEG for browsers, its media type, transparency, mean colour.

    Args:
        content: Content of a picture file in a format of Pillow; a PNG or JPEG of at most 2048
            pixels a side is returned unchanged.

    Returns:
        The file, its media type, whether it may be transparent, and its mean colour.

    Raises:
        OSError: The picture cannot be read.
        ValueError: The content is no picture, or too large.
    """
    from PIL import Image

    from teleopctl.robot import check_picture

    check_picture(content)
    with warnings.catch_warnings(action="ignore", category=Image.DecompressionBombWarning):
        image = Image.open(io.BytesIO(content))
    stored = _stored_smaller(image)
    is_jpeg = stored is None and image.format == "JPEG"
    mime_type = "image/jpeg" if is_jpeg else "image/png"
    red, green, blue, opacity = image.convert("RGBA").resize((1, 1), Image.Resampling.BOX).tobytes()
    mean = (red / 255, green / 255, blue / 255, opacity / 255)
    return stored or content, mime_type, _is_see_through(image), mean


def _is_see_through(image: Image.Image) -> bool:
    return "A" in image.getbands() or "transparency" in image.info


class TextureError(TeleopctlError):
    """Error: a texture cannot be loaded; the text names the file."""


def load_texture(uri: str, folder: Path | None = None) -> Texture:
    """Return the texture of a URI; raise TextureError if it cannot be read.

    Args:
        uri: ``package://`` or ``file://`` URI, or a path.
        folder: Folder of the description with the URI; see `path_of_uri`.

    Raises:
        TextureError: The file is missing, or cannot be read.
    """
    from teleopctl.robot import MOST_TEXTURE_BYTES

    try:
        path = path_of_uri(uri, folder)
        stamp = file_stamp(path)
        if stamp[0] > MOST_TEXTURE_BYTES:
            raise ValueError(f"it is larger than {MOST_TEXTURE_BYTES / 1e6:.0f} MB")
        content = path.read_bytes()
    except (TeleopctlError, OSError, ValueError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise TextureError(f"Texture '{uri}' cannot be read: {reason}") from error
    return _read_texture(uri, content, path, stamp)


def load_embedded_texture(name: str, data: bytes) -> Texture:
    """Return a texture whose file's content is in a message (``embedded://``), as `Texture`.

    Args:
        name: Name of the texture in the message.
        data: Content of a picture file in a format of Pillow.

    Raises:
        TextureError: The content is empty, or cannot be read.
    """
    if not data:
        raise TextureError(f"Texture '{name}' has no data")
    return _read_texture(name, data, None, (len(data), 0))


def _read_texture(name: str, content: bytes, path: Path | None, stamp: tuple[int, int]) -> Texture:
    try:
        picture = browser_picture(content)
    except Exception as error:
        # Pillow's readers raise various exceptions for damaged files.
        reason = " ".join(str(error).split())[:200]
        raise TextureError(f"Texture '{name}' cannot be read: {reason}") from error
    return Texture(*picture, path=path, stamp=stamp)
