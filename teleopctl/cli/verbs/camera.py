"""``teleopctl camera``: pictures of the cameras in the graph."""

import threading
import time
from pathlib import Path

from teleopctl.base.typed import Annotated, Any
from teleopctl.cli import console
from teleopctl.cli.command_node import command_node
from teleopctl.cli.graph_lookup import absolute_name
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.cli.verbs.topic.sources import find_source
from teleopctl.errors import (
    InvalidMessageError,
    SystemFailureError,
    UnavailableError,
    UnsupportedError,
    UsageError,
)

GROUP = VerbGroup(
    "Save pictures of cameras.",
    {
        "save": Verb(
            f"{__name__}:save",
            "Save one picture as a PNG file.",
            examples=("teleopctl camera save picture.png",),
        )
    },
)

_IMAGE = "sensor_msgs/msg/Image"
# Pillow's mode and raw mode for each encoding.
_MODES = {
    "rgb8": ("RGB", "RGB"),
    "bgr8": ("RGB", "BGR"),
    "rgba8": ("RGBA", "RGBA"),
    "bgra8": ("RGBA", "BGRA"),
    "mono8": ("L", "L"),
    "8UC1": ("L", "L"),
    "mono16": ("I;16", "I;16"),
    "16UC1": ("I;16", "I;16"),
    "32FC1": ("F", "F;32F"),
}
# Depths are metres as floats, and millimetres as integers, which a PNG file stores (REP 118).
_MOST_MILLIMETRES = 65535
_TELL_EVERY_S = 2.0


def save(
    file: Annotated[str, Argument(help="Output file, such as picture.png.")],
    topic: Annotated[
        str, Option("-t", "--topic", help="The camera's images.", complete="topics")
    ] = "/image_raw",
    timeout: Annotated[
        float | None, Option("--timeout", help="Give up after this many seconds.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Save the next picture of a camera as a PNG file."""
    path = Path(file)
    if path.suffix.lower() != ".png":
        raise UsageError(f"'{file}' is not a PNG file", hint="End its name with .png.")
    image = _next_image(absolute_name(topic), timeout)
    try:
        _picture(image).save(path, optimize=True)
    except OSError as error:
        raise SystemFailureError(f"Cannot write {path}: {error.strerror or error}") from error
    size = path.stat().st_size
    console.out_done(
        f"{path}: {image.width} x {image.height}, {size // 1000} kB",
        as_json=as_json,
        file=str(path),
        width=image.width,
        height=image.height,
        bytes=size,
    )


# Any, here and below: messages, whose classes are created from their definitions.
def _next_image(topic: str, longest_wait_s: float | None) -> Any:
    """Return the next image of a topic; print a note every two seconds of waiting."""
    source = find_source(topic)
    if source.message_class.TYPE_NAME != _IMAGE:
        raise UsageError(f"'{topic}' has the type {source.message_class.TYPE_NAME}, not {_IMAGE}")
    got: list[Any] = []
    arrived = threading.Event()

    def take(image: Any) -> None:
        got.append(image)
        arrived.set()

    started = time.monotonic()
    with command_node() as node:
        qos = source.compatible_qos(1)
        node.create_subscription(source.message_class, topic, take, qos, immediate=True)
        while True:
            waited_s = time.monotonic() - started
            left_s = _TELL_EVERY_S
            if longest_wait_s is not None:
                left_s = min(left_s, max(0.0, longest_wait_s - waited_s))
            if arrived.wait(left_s):
                return got[0]
            waited_s = time.monotonic() - started
            if longest_wait_s is not None and waited_s >= longest_wait_s:
                raise UnavailableError(f"No picture on '{topic}' within {longest_wait_s:g} s")
            console.note(f"Waiting for a picture on '{topic}' for {waited_s:.0f} s")


def _picture(image: Any) -> Any:
    """Return an image message as a Pillow image.

    Raises:
        UnsupportedError: The encoding is not supported.
        InvalidMessageError: The message has too few bytes.
    """
    from PIL import Image

    if image.encoding not in _MODES:
        raise UnsupportedError(
            f"Pictures of the encoding '{image.encoding}' cannot be saved",
            hint=f"Known are {', '.join(_MODES)}.",
        )
    mode, raw_mode = _MODES[image.encoding]
    if mode == "I;16" and image.is_bigendian:
        raw_mode = "I;16B"
    if mode == "F" and image.is_bigendian:
        raw_mode = "F;32BF"
    size = (image.width, image.height)
    try:
        picture = Image.frombytes(mode, size, bytes(image.data), "raw", raw_mode, image.step)
    except ValueError as error:
        raise InvalidMessageError(
            f"An image of {image.width} x {image.height} with {len(image.data)} bytes: {error}"
        ) from error
    return _millimetres(picture) if mode == "F" else picture


def _millimetres(depths: Any) -> Any:
    """Convert depths from metres to 16-bit millimetres; 0 for no measurement or out of range."""
    import numpy as np
    from PIL import Image

    found = np.rint(np.asarray(depths) * 1000.0)
    found[~((found > 0.0) & (found <= _MOST_MILLIMETRES))] = 0.0
    return Image.fromarray(found.astype(np.uint16))
