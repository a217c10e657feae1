"""Pictures that are laid on triangles: PNG or JPEG, as a browser takes them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from teleopctl.errors import TeleopctlError
from teleopctl.viewer.scene.drawing import Rgba
from teleopctl.viewer.scene.mesh_files import file_of, stamp_of_file


class TextureError(TeleopctlError):
    """A texture cannot be shown; the message names its file."""


@dataclass(frozen=True, slots=True)
class Texture:
    """A loaded texture.

    Attributes:
        data: What its file would hold.
        mime_type: ``image/png`` or ``image/jpeg``.
        see_through: Whether parts of it may be.
        mean: Its colour as a whole.
        path: Its file, for one that was read from there.
        stamp: That file's size and time when it was read; see `stamp_of_file`.
    """

    data: bytes
    mime_type: str
    see_through: bool = False
    mean: Rgba = (1.0, 1.0, 1.0, 1.0)
    path: Path | None = None
    stamp: tuple[int, int] = (0, 0)


def load_texture(uri: str, folder: Path | None = None) -> Texture:
    """Load a texture file.

    Args:
        uri: ``package://``, ``file://`` or a path.
        folder: Where the description that names it is from; see `file_of`.

    Raises:
        TextureError: There is none, or it cannot be read.
    """
    from teleopctl.robot import MOST_TEXTURE_BYTES

    try:
        path = file_of(uri, folder)
        stamp = stamp_of_file(path)
        if stamp[0] > MOST_TEXTURE_BYTES:
            raise ValueError(f"it is larger than {MOST_TEXTURE_BYTES / 1e6:.0f} MB")
        content = path.read_bytes()
    except (TeleopctlError, OSError, ValueError, RuntimeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise TextureError(f"Texture '{uri}' cannot be read: {reason}") from error
    return _read(uri, content, path, stamp)


def load_embedded_texture(name: str, data: bytes) -> Texture:
    """Load a texture that came in a message.

    Args:
        name: What it is called there.
        data: What its file would hold, in any format that is known here.

    Raises:
        TextureError: It cannot be read.
    """
    if not data:
        raise TextureError(f"Texture '{name}' came without data")
    return _read(name, data, None, (len(data), 0))


def _read(name: str, content: bytes, path: Path | None, stamp: tuple[int, int]) -> Texture:
    from teleopctl.viewer.scene.textures import picture_for_browsers

    try:
        picture = picture_for_browsers(content)
    except Exception as error:
        # Pillow's readers raise whatever their formats are broken by.
        reason = " ".join(str(error).split())[:200]
        raise TextureError(f"Texture '{name}' cannot be read: {reason}") from error
    return Texture(*picture, path=path, stamp=stamp)
