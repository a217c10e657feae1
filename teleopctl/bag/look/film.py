"""Pictures as a film: H.264 in MP4, as every browser and player shows it."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from teleopctl.base.extras import extra

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage

# The clock of video streams: 11 us. MP4 has 32 bits for what lies between some frames.
_TICKS_PER_S = 90_000
_LONGEST_TICKS = 2**28
# What players expect where nobody tells; the real times are in the frames.
_NOMINAL_RATE = 30
# 0 is without loss, 51 the worst; x264's own default is 23.
_QUALITY = 20
# Colours in the terms of H.264: the primaries of screens (ITU-R BT.709), and the matrix of BT.601,
# right for players, which heed it, and for decoders that know no other, as most in Python.
_BT709, _BT601_MATRIX = 1, 6


class Film:
    """Video file to which frames are added one by one, each with its time.

    Each frame has its own time, so that a film is as long as what it shows, whatever the rate of
    the camera was; frames of the same time follow each other by one tick.

    Args:
        path: The file.
        size: Width and height of all frames, in pixels; an odd last column or row is repeated,
            since the colours of H.264 stand for squares of four pixels.
        rate: Frames per second, where the times of frames are those of a constant rate.
        key_every: The most frames from one that stands for itself to the next.

    Attributes:
        frame_count: How many frames were written.
        shown_size: Width and height of the film's frames, even numbers.

    Raises:
        MissingExtraError: PyAV is not installed.
    """

    def __init__(
        self, path: Path, size: tuple[int, int], *, rate: int = 0, key_every: int = 250
    ) -> None:
        with extra("export", "av"):
            import av
        self.path = path
        self.size = size
        self.frame_count = 0
        self._av = av
        self._last_tick = -1
        self._cut_ticks = 0
        self._file = av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"})
        self._stream = self._file.add_stream("libx264", rate=rate or _NOMINAL_RATE)
        self._duration_ticks = round(_TICKS_PER_S / rate) if rate else 0
        width, height = self.shown_size = (size[0] + size[0] % 2, size[1] + size[1] % 2)
        # Any: PyAV's classes, which are not there without the extra.
        context: Any = self._stream.codec_context
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base = Fraction(1, _TICKS_PER_S)
        context.gop_size = key_every
        context.options = {"crf": str(_QUALITY), "preset": "veryfast"}
        context.color_primaries = context.color_trc = _BT709
        context.colorspace = _BT601_MATRIX

    def add(self, time_s: float, image: PilImage) -> None:
        """Add a frame.

        Args:
            time_s: When it is shown, in seconds from the film's start.
            image: Of the film's size.
        """
        import numpy as np

        pixels = np.asarray(image.convert("RGB"))
        if self.size[0] % 2 or self.size[1] % 2:
            pixels = np.pad(pixels, ((0, self.size[1] % 2), (0, self.size[0] % 2), (0, 0)), "edge")
        frame: Any = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), "rgb24")
        frame = frame.reformat(format="yuv420p", dst_colorspace="ITU601")
        tick = max(round(time_s * _TICKS_PER_S) - self._cut_ticks, self._last_tick + 1)
        # A longer gap than MP4 can keep, as of a clock that was set, is cut short.
        cut = max(tick - self._last_tick - _LONGEST_TICKS, 0)
        self._cut_ticks += cut
        tick -= cut
        frame.pts, frame.time_base = tick, Fraction(1, _TICKS_PER_S)
        # Else players would take the last frame of a constant rate for longer or shorter.
        frame.duration = self._duration_ticks
        self._last_tick = tick
        self._file.mux(self._stream.encode(frame))
        self.frame_count += 1

    def close(self) -> None:
        """Finish and close the file."""
        if self.frame_count:
            self._file.mux(self._stream.encode(None))
        self._file.close()
