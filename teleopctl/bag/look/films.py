"""Topics of pictures as films."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from teleopctl.bag.look.decoding import PICTURES, Decoder
from teleopctl.bag.look.file_names import file_stems, make_folder, whole_or_gone
from teleopctl.bag.look.film import Film
from teleopctl.bag.storage.bag import Bag
from teleopctl.errors import InvalidFileError, SystemFailureError, UsageError
from teleopctl.pictures import GreyRange, PictureError, image_of

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage

# At a constant rate, a clock that was set would fill the disk with one picture.
_MOST_REPEATED = 100_000


class ExportedFilm(NamedTuple):
    """A written video file.

    Attributes:
        path: Where it is.
        topic: What it is of.
        frames: How many frames it has.
        size: Their width and height in pixels.
        duration_s: From the first frame to the last.
        left_out: How many messages are no frame of it.
        reason: Why the first of these is none.
    """

    path: Path
    topic: str
    frames: int
    size: tuple[int, int]
    duration_s: float
    left_out: int = 0
    reason: str = ""


class FilmExport:
    """Exports each image topic to a video.

    A frame is shown when its message was recorded, so that films, plots and tables have the same
    time; it begins with the first frame. Frames of another size than the first are left out.

    Args:
        bag: The bag.
        folder: Where the files go; made here.
        topics: The topics; all that have pictures if None.
        rate: Frames per second, each the latest picture at its time; None keeps the real times.

    Raises:
        NotFoundError: The bag has no such topic.
        UsageError: A topic that was named has no pictures, or the rate is none.
        InvalidMessageError: A topic that was named cannot be decoded.
    """

    def __init__(
        self,
        bag: Bag,
        folder: Path,
        topics: Collection[str] | None = None,
        rate: float | None = None,
    ) -> None:
        if rate is not None and not 0.0 < rate <= 1000.0:
            raise UsageError(f"{rate:g} is no rate of frames")
        self._decoder = Decoder(bag, topics)
        self._folder = folder
        self._rate = rate
        self._topics = []
        for name, topic in self._decoder.topics.items():
            if topic.type_name in PICTURES:
                self._topics.append(name)
            elif topics is not None:
                raise UsageError(f"{name} has no pictures, but {topic.type_name}")

    def films(self) -> Iterator[ExportedFilm]:
        """Write the videos, and yield each when it is finished.

        Topics without a picture make none.

        Raises:
            RefusedError: The folder holds something already.
            SystemFailureError: A file cannot be written.
            MissingExtraError: PyAV is not installed.
            InvalidFileError: A part of the bag is broken.
        """
        make_folder(self._folder)
        for name, stem in file_stems(self._topics).items():
            try:
                film = self._write(name, self._folder / f"{stem}.mp4")
            except OSError as error:
                raise SystemFailureError(
                    f"Cannot write to {self._folder}: {error.strerror or error}"
                ) from error
            if film is not None:
                yield film

    def _write(self, topic: str, path: Path) -> ExportedFilm | None:
        pictures = _Pictures(self._decoder, topic)
        frames: Iterable[tuple[float, PilImage]] = pictures.frames()
        if self._rate is not None:
            frames = at_rate(frames, self._rate)
        film = None
        last_s = 0.0
        with whole_or_gone((path,)):
            try:
                for time_s, image in frames:
                    film = film or Film(path, image.size)
                    film.add(time_s, image)
                    last_s = time_s
            finally:
                if film is not None:
                    film.close()
        if film is None:
            return None
        left_out, reason = pictures.left_out, pictures.reason
        return ExportedFilm(path, topic, film.frame_count, film.size, last_s, left_out, reason)


class _Pictures:
    """The pictures of a topic that have the size of the first."""

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
        """Yield the pictures with their times since the first one, in seconds."""
        shades = GreyRange()
        start_ns, size = 0, (0, 0)
        for decoded in self._decoder.messages([self._topic]):
            try:
                image = image_of(decoded.message, shades)
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


def at_rate(
    frames: Iterable[tuple[float, PilImage]], rate: float
) -> Iterator[tuple[float, PilImage]]:
    """Yield, at a constant rate, the newest frame of each time.

    The last frame is always there, at the next time of the rate.

    Raises:
        InvalidFileError: Nothing came for so long that one picture would fill a film.
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
