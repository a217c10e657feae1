"""The pictures on meshes, made to fit a browser."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterable
from typing import Any

from PIL import Image

from teleopctl.base.budget import check_pixels
from teleopctl.robot import check_picture
from teleopctl.viewer.scene.drawing import Rgba

# Phones refuse larger textures, and they are sent whole.
_LARGEST_SIDE = 2048
_MEAN = Image.Resampling.BOX
_SLOTS = (
    "image",
    "baseColorTexture",
    "emissiveTexture",
    "normalTexture",
    "occlusionTexture",
    "metallicRoughnessTexture",
)


# Any stands for trimesh's meshes and materials.


def fit_textures(meshes: Iterable[Any]) -> list[str]:
    """Convert the textures of meshes to what browsers show.

    Returns:
        What was left out, each as what follows the file's name in a sentence.
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
    """Return a picture in a size and format that browsers show.

    Raises:
        OSError: It cannot be read.
        BudgetError: It is too large.
    """
    stored = _stored_smaller(image)
    return image if stored is None else Image.open(io.BytesIO(stored))


def _stored_smaller(image: Image.Image) -> bytes | None:
    """A picture as PNG that fits; None for one that fits as it is.

    Raises:
        OSError: It cannot be read.
        BudgetError: It is too large.
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


def picture_for_browsers(content: bytes) -> tuple[bytes, str, bool, Rgba]:
    """Return a picture as PNG or JPEG of a size that browsers show.

    Args:
        content: In any format that Pillow reads; PNG and JPEG of a fair size stay as they are.

    Returns:
        The file, its media type, whether it may be seen through, and its mean colour.

    Raises:
        OSError: It cannot be read.
        ValueError: It is no picture, or too large.
    """
    check_picture(content)
    with warnings.catch_warnings(action="ignore", category=Image.DecompressionBombWarning):
        image = Image.open(io.BytesIO(content))
    stored = _stored_smaller(image)
    is_jpeg = stored is None and image.format == "JPEG"
    mime_type = "image/jpeg" if is_jpeg else "image/png"
    red, green, blue, opacity = image.convert("RGBA").resize((1, 1), _MEAN).tobytes()
    mean = (red / 255, green / 255, blue / 255, opacity / 255)
    return stored or content, mime_type, _is_see_through(image), mean


def _is_see_through(image: Image.Image) -> bool:
    return "A" in image.getbands() or "transparency" in image.info
