"""Cameras by the names of their image topics, as a graph or a bag lists them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from teleopctl.pictures.messages import COMPRESSED, RAW

DEPTH_ENCODINGS = frozenset({"16UC1", "32FC1", "mono16"})
"""Encodings of images that are depths, not colours."""

# Last parts of the names of image topics, which do not distinguish cameras.
_IMAGE_WORDS = {"image", "image_raw", "image_color", "image_rect", "image_rect_color", "color"}
_TRANSPORTS = ("compressed", "compressedDepth", "theora", "ffmpeg")


def camera_name(topic: str) -> str:
    """Return the name of the camera that publishes an image topic.

    Example:
        >>> camera_name("/wrist_camera/color/image_raw")
        'wrist_camera'
    """
    parts = [part for part in topic.strip("/").split("/") if part not in _TRANSPORTS]
    while parts and parts[-1] in _IMAGE_WORDS:
        parts.pop()
    return "_".join(parts) or "camera"


def camera_topics(
    topics: Mapping[str, Sequence[str]], *, prefers_raw: bool = False
) -> dict[str, str]:
    """Return one image topic of each camera, by the cameras' names.

    Of an image in several transports, that is the JPEG; of depths, which JPEG cannot hold, the raw
    image. Two cameras of one name get numbers.

    Args:
        topics: Types of the topics by name.
        prefers_raw: Whether raw images are taken where there is a choice.
    """
    chosen: dict[str, str] = {}
    for topic, types in sorted(topics.items()):
        stem, _, last = topic.rpartition("/")
        is_raw = RAW in types
        if not is_raw and (COMPRESSED not in types or last == "compressedDepth"):
            continue
        base = topic if is_raw or last not in _TRANSPORTS else stem
        if base not in chosen or is_raw == (prefers_raw or "depth" in base.lower()):
            chosen[base] = topic
    named: dict[str, str] = {}
    for base, topic in chosen.items():
        name, number = camera_name(base), 2
        while name in named:
            name, number = f"{camera_name(base)}_{number}", number + 1
        named[name] = topic
    return named
