"""Material and texture files that a mesh file names: search and checks before reading."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from urllib.parse import unquote

from PIL import Image
from trimesh.resolvers import Resolver

from teleopctl.base.budget import check_pixels
from teleopctl.errors import TeleopctlError
from teleopctl.packages import resolve_uri

MOST_TEXTURE_BYTES = 100_000_000
_PICTURES = frozenset(Image.registered_extensions()) - {".pdf"}


def texture_paths(mesh: Path, name: str) -> list[Path]:
    """Return the possible paths of a file that a mesh file names, the likeliest first.

    First the name relative to the mesh, also percent-decoded and with backslashes replaced; then,
    as in Gazebo's search, its last part in the mesh's folder and in ``../materials/textures``.

    Args:
        mesh: Path of the mesh file.
        name: File name in the mesh file.
    """
    folder = mesh.parent
    plain = unquote(name).replace("\\", "/")
    last = plain.rpartition("/")[2]
    names = dict.fromkeys((name, unquote(name), plain))
    places = [folder / each for each in names]
    if last:
        places += [folder / last, folder.parent / "materials" / "textures" / last]
    return places


class MeshFileResolver(Resolver):
    """trimesh resolver for the files that a mesh file names: materials, textures, buffers.

    Args:
        path: Path of the mesh file.

    Attributes:
        faults: Reasons why named files could not be read, by file name.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.faults: dict[str, str] = {}

    def get(self, key: str) -> bytes:
        """Return the content of a file that the mesh names, for trimesh; raise if it is unusable.

        Raises:
            FileNotFoundError: The file cannot be read; trimesh then continues without it.
        """
        name = key.strip()
        try:
            path = self._find(name)
            if path.stat().st_size > MOST_TEXTURE_BYTES:
                raise FileNotFoundError(f"is larger than {MOST_TEXTURE_BYTES / 1e6:.0f} MB")
            content = path.read_bytes()
            if path.suffix.lower() in _PICTURES:
                check_picture(content)
        except (OSError, ValueError, TeleopctlError) as error:
            reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
            if isinstance(error, FileNotFoundError) and error.strerror:
                reason = "is not there"
            self.faults[name] = reason
            raise FileNotFoundError(name) from error
        return content

    def _find(self, name: str) -> Path:
        if "://" in name:
            return resolve_uri(name)
        places = texture_paths(self._path, name)
        return next((place for place in places if place.is_file()), places[0])

    def keys(self) -> list[str]:
        """Return no file names, since trimesh would choose a material among them."""
        return []

    def write(self, name: str, data: object) -> None:
        """Raise NotImplementedError: mesh files are only read."""
        raise NotImplementedError(name, data)

    def namespaced(self, namespace: str) -> MeshFileResolver:
        """Return the resolver for files in a subfolder; called by trimesh."""
        return MeshFileResolver(self._path.parent / namespace / self._path.name)


def check_picture(content: bytes) -> None:
    """Check by its header that a file is an image of allowed size, before decoding; else raise.

    Raises:
        ValueError: The content is not a picture, or has too many pixels.
    """
    try:
        with warnings.catch_warnings(action="ignore", category=Image.DecompressionBombWarning):
            image = Image.open(io.BytesIO(content))
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f"is not a supported image: {error}") from error
    check_pixels(*image.size)
