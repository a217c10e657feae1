"""Videos of depths as lerobot 0.6 reads them: HEVC without loss, 12 bits a pixel.

The numbers are logarithms of the depths, so that near depths have smaller steps: 0.9 mm at 0 m,
2.2 mm at 5 m. Pixels without a measurement have the least depth.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from teleopctl.bag.export.video import VideoFile
from teleopctl.errors import UsageError

# Least and greatest depth, and what is added before the logarithm, m. lerobot reads them from the
# information of the data set.
_LEAST_M, _MOST_M, _SHIFT_M = 0.01, 10.0, 3.5
_LOG_LEAST = float(np.log(_LEAST_M + _SHIFT_M))
_LOG_RANGE = float(np.log(_MOST_M + _SHIFT_M)) - _LOG_LEAST
_MOST_NUMBER = 4095
# Smallest width and height of x265, in pixels.
_LEAST_SIZE = 16

# Any: JSON.
INFORMATION: dict[str, Any] = {
    "is_depth_map": True,
    "video.is_depth_map": True,
    "depth_unit": "m",
    "video.depth_min": _LEAST_M,
    "video.depth_max": _MOST_M,
    "video.shift": _SHIFT_M,
    "video.use_log": True,
    "video.codec": "hevc",
    "video.pix_fmt": "gray12le",
    "video.channels": 1,
}
"""Information of a depth feature, without its size and rate."""


def depth_numbers(depths: npt.NDArray[np.float32]) -> npt.NDArray[np.uint16]:
    """Return the numbers of a video for depths in metres, of the same shape."""
    measured = np.where(np.isfinite(depths), depths, 0.0).clip(_LEAST_M, _MOST_M)
    part = (np.log(measured + _SHIFT_M) - _LOG_LEAST) / _LOG_RANGE
    return np.rint(part * _MOST_NUMBER).astype(np.uint16)


def depths_of_numbers() -> npt.NDArray[np.float64]:
    """Return the depth of each number from 0 to 4095, m."""
    part = np.arange(_MOST_NUMBER + 1) / _MOST_NUMBER
    return np.exp(part * _LOG_RANGE + _LOG_LEAST) - _SHIFT_M


class DepthVideoFile(VideoFile):
    """Writer of a video of depths, frame by frame at a constant rate.

    Args:
        path: Path of the file.
        size: Width and height of all images, in pixels.
        rate: Frames per second.
        key_every: Largest distance between key frames, in frames.

    Raises:
        MissingExtraError: PyAV is not installed.
        UsageError: The images are too small for the encoder.
    """

    _codec, _format = "libx265", "gray12le"
    _options: Mapping[str, str] = {
        "x265-params": "lossless=1:bframes=0:open-gop=0:log-level=none",
        "preset": "ultrafast",
    }

    def __init__(
        self, path: Path, size: tuple[int, int], *, rate: int = 0, key_every: int = 250
    ) -> None:
        if min(size) < _LEAST_SIZE:
            raise UsageError(
                f"Depth images of {size[0]} x {size[1]} are too small for a video: it has at least "
                f"{_LEAST_SIZE} x {_LEAST_SIZE}"
            )
        super().__init__(path, size, rate=rate, key_every=key_every)

    def add_numbers(self, time_s: float, numbers: npt.NDArray[np.uint16]) -> None:
        """Encode numbers as the next frame.

        Args:
            time_s: Time of the frame, in seconds from the start of the video.
            numbers: Result of `depth_numbers`, shape (height, width).
        """
        # Any: PyAV's classes, which are missing without the extra.
        frame: Any = self._av.VideoFrame(*self.size, format=self._format)
        plane = frame.planes[0]
        rows = np.zeros((self.size[1], plane.line_size // 2), np.uint16)
        rows[:, : self.size[0]] = numbers
        plane.update(rows.tobytes())
        self._write(time_s, frame)

    def _shown(self) -> tuple[int, int]:
        return self.size
