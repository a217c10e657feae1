"""Pictures of depths as numbers: how far away each pixel is."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.pictures.compressed import depths_inside
from teleopctl.pictures.picture import PictureError
from teleopctl.pictures.raw import numbers_of

Depths = npt.NDArray[np.float32]

# REP 118: whole numbers are millimetres, floats are metres.
_METRES = {"16UC1": 0.001, "mono16": 0.001, "32FC1": 1.0}
_KINDS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}


# Any: a message of one of two types.
def depths_of(message: Any) -> Depths:
    """Return the depth of each pixel in metres, (rows, width).

    Args:
        message: A ``sensor_msgs/msg/Image`` or ``sensor_msgs/msg/CompressedImage`` of depths.

    Returns:
        The depths; where nothing was measured, 0 or no number. Rows that have not arrived are
        missing.

    Raises:
        PictureError: It holds no depths, or cannot be read.
    """
    if hasattr(message, "encoding"):
        encoding = message.encoding
        if encoding not in _METRES:
            raise PictureError(f"Pictures in {encoding or 'no encoding'} hold no depths")
        numbers = numbers_of(message, _KINDS[encoding], 1)[..., 0]
    else:
        if "compressedDepth" not in message.format:
            raise PictureError(f"Pictures in '{message.format}' hold no depths")
        numbers, encoding = depths_inside(message), message.format[:5]
    depths: Depths = numbers.astype(np.float32) * np.float32(_METRES.get(encoding, 0.001))
    return depths
