"""Image topics as videos: H.264 in MP4, as every browser and player shows it."""

from __future__ import annotations

import contextlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from teleopctl.bag.base import Bag
from teleopctl.bag.export.decoding import PICTURES, Decoder
from teleopctl.bag.export.output_folder import file_stems, make_output_folder, removed_on_error
from teleopctl.base.extras import extra
from teleopctl.errors import InvalidFileError, SystemFailureError, UsageError
from teleopctl.pictures import GreyScaling, PictureError, image_of

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from PIL.Image import Image as PilImage


# The usual time base of video streams, 11 us. MP4 has 32 bits for the time between frames.
_TICKS_PER_S = 90_000
_LONGEST_TICKS = 2**28
# Frame rate in the stream's header; each frame has its own time.
_NOMINAL_RATE = 30
# Constant rate factor of x264: 0 is lossless, 51 the worst quality, 23 the default.
_QUALITY = 20
# Colour codes of H.264: the primaries of screens (ITU-R BT.709), and the matrix of BT.601, which
# players read from the stream and most decoders for Python assume.
_BT709, _BT601_MATRIX = 1, 6


class VideoFile:
    """Writer of an H.264 video in MP4, frame by frame, each frame with its own time.

    A video has the duration of the recording, whatever the rate of the camera was. Frames with the
    same time are one tick apart.

    Args:
        path: Path of the file.
        size: Width and height of all images, in pixels. An odd last column or row is repeated,
            since the colours of H.264 are stored for squares of four pixels.
        rate: Frames per second if the frames have a constant rate; 0 if not.
        key_every: Largest distance between key frames, in frames.

    Attributes:
        frame_count: Number of frames written.
        shown_size: Width and height of the video's frames, even numbers.

    Raises:
        MissingExtraError: PyAV is not installed.
    """

    _codec, _format = "libx264", "yuv420p"
    _options: Mapping[str, str] = {"crf": str(_QUALITY), "preset": "veryfast"}

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
        self._is_broken = False
        self._file = av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"})
        # Any: PyAV's classes, which are missing without the extra.
        self._stream: Any = self._file.add_stream(self._codec, rate=rate or _NOMINAL_RATE)
        self._duration_ticks = round(_TICKS_PER_S / rate) if rate else 0
        width, height = self.shown_size = self._shown()
        context: Any = self._stream.codec_context
        context.width, context.height, context.pix_fmt = width, height, self._format
        context.time_base = Fraction(1, _TICKS_PER_S)
        context.gop_size = key_every
        context.options = dict(self._options)
        context.color_primaries = context.color_trc = _BT709
        context.colorspace = _BT601_MATRIX

    def add(self, time_s: float, image: PilImage) -> None:
        """Encode an image as the next frame, shown at a time in seconds from the start.

        Args:
            time_s: Time of the frame, in seconds from the start of the video.
            image: Image of the size of the video.
        """
        import numpy as np

        self.add_pixels(time_s, np.asarray(image.convert("RGB")))

    def add_pixels(self, time_s: float, pixels: npt.NDArray[np.uint8]) -> None:
        """Encode RGB pixels as the next frame; see `add`.

        Args:
            time_s: Time of the frame, in seconds from the start of the video.
            pixels: Pixels of shape (height, width, 3).
        """
        import numpy as np

        if self.size[0] % 2 or self.size[1] % 2:
            pixels = np.pad(pixels, ((0, self.size[1] % 2), (0, self.size[0] % 2), (0, 0)), "edge")
        frame: Any = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), "rgb24")
        self._write(time_s, frame.reformat(format=self._format, dst_colorspace="ITU601"))

    def _shown(self) -> tuple[int, int]:
        width, height = self.size
        return width + width % 2, height + height % 2

    # Any: PyAV's frame.
    def _write(self, time_s: float, frame: Any) -> None:
        """Encode a frame of the stream's format."""
        tick = max(round(time_s * _TICKS_PER_S) - self._cut_ticks, self._last_tick + 1)
        # A gap longer than MP4 can store, such as after a clock change, is shortened.
        cut = max(tick - self._last_tick - _LONGEST_TICKS, 0)
        self._cut_ticks += cut
        tick -= cut
        frame.pts, frame.time_base = tick, Fraction(1, _TICKS_PER_S)
        # Otherwise players would guess the duration of the last frame of a constant rate.
        frame.duration = self._duration_ticks
        self._last_tick = tick
        self._mux(frame)
        self.frame_count += 1

    # Any: PyAV's frame.
    def _mux(self, frame: Any) -> None:
        try:
            self._file.mux(self._stream.encode(frame))
        except OSError:
            self._is_broken = True
            raise

    def close(self) -> None:
        """Finish and close the video file."""
        if self._is_broken:
            # On a full disk, FFmpeg crashes if it begins a file again that it could not begin.
            with contextlib.suppress(OSError):
                self._file.close()
            return
        if self.frame_count:
            self._mux(None)
        self._file.close()


# Limits repetitions at a constant rate: after a clock change, one image would fill the disk.
_MOST_REPEATED = 100_000


class ExportedVideo(NamedTuple):
    """Result of `VideoExport` for one topic: file, frames, size, and messages left out.

    Attributes:
        path: Path of the file.
        topic: Name of the topic.
        frames: Number of frames.
        size: Width and height of the images in pixels.
        duration_s: Time from the first frame to the last, in seconds.
        left_out: Number of messages that are not in the video.
        reason: Reason for the first of these messages.
    """

    path: Path
    topic: str
    frames: int
    size: tuple[int, int]
    duration_s: float
    left_out: int = 0
    reason: str = ""


class VideoExport:
    """Export of a bag's image topics to MP4 files, one file for each topic.

    Frames are placed by the log times of their messages, as in plots and tables; the time of a
    video starts at its first frame. Frames of another size than the first are skipped.

    Args:
        bag: Bag to export.
        folder: Folder of the files, created if missing.
        topics: Names of the topics to export; all image topics if None.
        rate: Frames per second, each with the newest image at its time; None keeps the log times.

    Raises:
        NotFoundError: The bag does not have one of the topics.
        UsageError: A named topic has no images, or the rate is not in (0, 1000].
        InvalidMessageError: One of the named topics cannot be decoded.
    """

    def __init__(
        self,
        bag: Bag,
        folder: Path,
        topics: Collection[str] | None = None,
        rate: float | None = None,
    ) -> None:
        if rate is not None and not 0.0 < rate <= 1000.0:
            raise UsageError(f"{rate:g} is not a frame rate")
        self._decoder = Decoder(bag, topics)
        self._folder = folder
        self._rate = rate
        self._topics = []
        for name, topic in self._decoder.topics.items():
            if topic.type_name in PICTURES:
                self._topics.append(name)
            elif topics is not None:
                raise UsageError(f"{name} has no pictures, but {topic.type_name}")

    def write(self) -> Iterator[ExportedVideo]:
        """Write the videos while iterated; yield an `ExportedVideo` for each finished file.

        Topics without usable images are skipped.

        Raises:
            RefusedError: The folder is not empty.
            SystemFailureError: A file cannot be written.
            MissingExtraError: PyAV is not installed.
            InvalidFileError: A part of the bag is broken.
        """
        make_output_folder(self._folder)
        for name, stem in file_stems(self._topics).items():
            try:
                film = self._write_topic(name, self._folder / f"{stem}.mp4")
            except OSError as error:
                raise SystemFailureError(
                    f"Cannot write to {self._folder}: {error.strerror or error}"
                ) from error
            if film is not None:
                yield film

    def _write_topic(self, topic: str, path: Path) -> ExportedVideo | None:
        pictures = _Pictures(self._decoder, topic)
        frames: Iterable[tuple[float, PilImage]] = pictures.frames()
        if self._rate is not None:
            frames = resample_frames(frames, self._rate)
        film = None
        last_s = 0.0
        with removed_on_error((path,)):
            try:
                for time_s, image in frames:
                    film = film or VideoFile(path, image.size)
                    film.add(time_s, image)
                    last_s = time_s
            finally:
                if film is not None:
                    film.close()
        if film is None:
            return None
        left_out, reason = pictures.left_out, pictures.reason
        return ExportedVideo(path, topic, film.frame_count, film.size, last_s, left_out, reason)


class _Pictures:
    """Images of a topic that have the size of the first one."""

    def __init__(self, decoder: Decoder, topic: str) -> None:
        self._decoder = decoder
        self._topic = topic
        self._left_out = 0
        self._reason = ""

    @property
    def left_out(self) -> int:
        return self._left_out + self._decoder.unreadable.get(self._topic, 0)

    @property
    def reason(self) -> str:
        return self._reason or self._decoder.reasons.get(self._topic, "")

    def frames(self) -> Iterator[tuple[float, PilImage]]:
        """Yield (seconds since the first image, image) for each usable image of the topic."""
        scaling = GreyScaling()
        start_ns, size = 0, (0, 0)
        for decoded in self._decoder.messages([self._topic]):
            try:
                image = image_of(decoded.message, scaling)
            except PictureError as error:
                self._leave_out(error.message)
                continue
            if not size[0]:
                start_ns, size = decoded.log_time_ns, image.size
            if image.size != size:
                self._leave_out(f"{image.width} x {image.height} is not {size[0]} x {size[1]}")
                continue
            yield (decoded.log_time_ns - start_ns) / 1e9, image

    def _leave_out(self, reason: str) -> None:
        self._left_out += 1
        self._reason = self._reason or reason


def resample_frames(
    frames: Iterable[tuple[float, PilImage]], rate: float
) -> Iterator[tuple[float, PilImage]]:
    """Yield timed frames at a constant rate, each with the newest image at its time.

    The last frame is always yielded, at the next time of the rate.

    Raises:
        InvalidFileError: A gap would repeat an image more than 100 000 times.
    """
    held: PilImage | None = None
    number = 0
    for time_s, image in frames:
        if held is not None:
            if (time_s * rate - number) > _MOST_REPEATED:
                raise InvalidFileError(
                    f"After {number / rate:.1f} s no picture came until {time_s:.1f} s, too long "
                    "for a film at a constant rate"
                )
            while number / rate < time_s:
                yield number / rate, held
                number += 1
        held = image
    if held is not None:
        yield number / rate, held
