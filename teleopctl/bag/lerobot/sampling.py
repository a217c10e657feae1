"""Sampling of a bag at a constant rate: vectors, cameras, and the age of each value.

Each frame holds the newest message of every feature at the frame's time. The first frame is at the
time at which every feature has a message, the last frame not after the last message. Times are the
stamps of the messages, at which an image was taken and a state was measured; where a bag's stamps
are of another clock than its recording, the times of recording.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import numpy as np

from teleopctl.bag.base import Bag
from teleopctl.bag.export.decoding import DecodedMessage, Decoder
from teleopctl.bag.export.video import VideoFile
from teleopctl.bag.lerobot.dataset import Episode, Video
from teleopctl.bag.lerobot.depth import DepthVideoFile, depth_numbers, depths_of_numbers
from teleopctl.bag.lerobot.features import (
    ACTION,
    CAMERA_PREFIX,
    HAND,
    STAMPS,
    STATE_FEATURE,
    Camera,
    HandTwist,
    Vector,
    VectorField,
    action_vector,
    decodable_types,
    has_depths,
    prismatic_joints,
    require_pictures,
    units,
)
from teleopctl.bag.lerobot.statistics import PictureStatistics, Values
from teleopctl.errors import InvalidFileError, InvalidMessageError, NotFoundError, UsageError
from teleopctl.interfaces import NANOSECONDS_PER_SECOND, to_nanoseconds
from teleopctl.pictures import PictureError, camera_name

# Distance of key frames as in LeRobot, since a training reads frames in any order.
_KEY_EVERY = 2
# Limits the frames of one gap: after a clock change, one state would fill the disk.
_MOST_FRAMES = 1_000_000
# Largest difference of a stamp and the time of recording if both are of one clock.
_ONE_CLOCK_NS = 10 * NANOSECONDS_PER_SECOND
# Age from which on a measured value is that of a sensor that has fallen silent.
_SILENT_NS = NANOSECONDS_PER_SECOND
# Longest time for which a message is held back until all with earlier stamps have come.
_LATEST_NS = NANOSECONDS_PER_SECOND


class LeRobotOptions(NamedTuple):
    """Options of an export to a LeRobot data set: topics, frame rate and task.

    Attributes:
        state: Topic of the robot's state, mostly ``/joint_states``, or a field of a topic.
        action: Topics of the robot's commands, or fields of topics; one vector of all of them.
        cameras: Image topics, each a topic or ``NAME=TOPIC``.
        fps: Frames per second.
        task: Description of the task in words.
        robot: Type of the robot in one word, or None.
        hand: Topic of the operator's twists, for a feature ``hand``; None for none. A
            bag without the topic has zeros.
    """

    state: str
    action: Sequence[str] = ()
    cameras: Sequence[str] = ()
    fps: int = 30
    task: str = "teleoperation"
    robot: str | None = None
    hand: str | None = None


class SampledEpisode(NamedTuple):
    """Result of `sample_episode`: content for a data set, and how good its times are.

    Attributes:
        episode: Content of the episode; its videos are written.
        left_out: Number of messages that could not be used, by topic.
        by_stamps: Whether the times are the stamps of the messages, not those of the recording.
        worst_offset_s: Largest age of a value in a frame, in seconds.
        worst_feature: Feature with this value.
        silent_s: Age in seconds of the oldest value of the state and of each camera, where it is
            so great that the topic was silent.
    """

    episode: Episode
    left_out: Mapping[str, int]
    by_stamps: bool
    worst_offset_s: float
    worst_feature: str
    silent_s: Mapping[str, float]


def sample_episode(bag: Bag, options: LeRobotOptions, videos: Path) -> SampledEpisode:
    """Sample a bag as an episode, and write a video of each camera.

    Args:
        bag: Bag to sample.
        options: Topics, frame rate and task.
        videos: Folder of the videos, each named by its feature.

    Raises:
        NotFoundError: A topic does not exist, or has no usable message.
        UsageError: A camera topic has no images, a topic has no default field, or the frame rate is
            not between 1 and 1000.
        InvalidMessageError: A topic cannot be decoded.
        MissingExtraError: PyAV is not installed.
        InvalidFileError: The bag is broken, or a gap between its times is too long.
    """
    if not 1 <= options.fps <= 1000:
        raise UsageError(f"{options.fps} is not a frame rate")
    return _Sampling(bag, options, videos).run()


class _Film:
    """Camera of an episode, with the video of its sampled images."""

    def __init__(self, camera: Camera, file: Path, rate: int) -> None:
        self.camera = camera
        self.video: VideoFile | DepthVideoFile | None = None
        self.statistics = (
            PictureStatistics(depths_of_numbers(), 1) if camera.is_depth else PictureStatistics()
        )
        self._file = file
        self._rate = rate

    def add_frame(self, time_s: float) -> None:
        image = self.camera.newest
        assert image is not None
        kind = DepthVideoFile if self.camera.is_depth else VideoFile
        if self.video is None:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            height, width = image.shape[:2]
            self.video = kind(self._file, (width, height), rate=self._rate, key_every=_KEY_EVERY)
        if isinstance(self.video, DepthVideoFile):
            numbers = depth_numbers(image.astype(np.float32, copy=False))
            self.video.add_numbers(time_s, numbers)
            self.statistics.add(numbers)
        else:
            pixels = image.astype(np.uint8, copy=False)
            self.video.add_pixels(time_s, pixels)
            self.statistics.add(pixels)

    def close(self) -> None:
        if self.video is not None:
            self.video.close()


class _Sampling:
    """State of a sampling: vectors and cameras, and the frames so far."""

    def __init__(self, bag: Bag, options: LeRobotOptions, videos: Path) -> None:
        self._bag = bag
        self._options = options
        types = decodable_types(Decoder(bag))
        self._vectors: dict[str, Vector] = {STATE_FEATURE: VectorField(options.state, types)}
        if options.action:
            self._vectors[ACTION] = action_vector(options.action, types, bag)
        if options.hand is not None:
            self._vectors[HAND] = HandTwist(options.hand)
        self._films: dict[str, _Film] = {}
        depths = Decoder(bag)
        for text in options.cameras:
            name, _, topic = text.rpartition("=")
            require_pictures(topic, types, bag)
            key = f"{CAMERA_PREFIX}{name or camera_name(topic)}"
            if any(film.camera.key == key for film in self._films.values()):
                raise UsageError(
                    f"Two cameras have the name '{key.removeprefix(CAMERA_PREFIX)}'",
                    hint=f"Name them: --camera NAME={topic}",
                )
            camera = Camera(key, topic, is_depth=has_depths(depths, topic))
            self._films[topic] = _Film(camera, videos / f"{key}.mp4", options.fps)
        wanted = {*self._films, *(name for one in self._vectors.values() for name in one.topics)}
        self._decoder = Decoder(bag, sorted(wanted & types.keys()))
        self._rows: dict[str, list[list[float]]] = {key: [] for key in [*self._vectors, STAMPS]}
        self._left_out: dict[str, int] = {}
        self._start_ns: int | None = None
        self._frames = 0
        # Greatest age of a value of each feature, in ns.
        self._oldest: dict[str, int] = {}

    def run(self) -> SampledEpisode:
        last_ns = 0
        by_stamps = _has_one_clock(self._decoder)
        messages = _by_stamp(self._decoder) if by_stamps else _by_log_time(self._decoder)
        with ExitStack() as stack:
            for film in self._films.values():
                stack.callback(film.close)
            for time_ns, decoded in messages:
                last_ns = time_ns
                self._add_frames(last_ns)
                self._take(decoded, time_ns)
                if self._start_ns is None and not self._missing():
                    self._start_ns = last_ns
            self._add_frames(last_ns + 1)
        if not self._frames:
            raise NotFoundError(f"There is no message of {', '.join(self._missing())}")
        for topic, count in self._decoder.unreadable.items():
            self._left_out[topic] = self._left_out.get(topic, 0) + count
        worst_ns, feature = max(((age, key) for key, age in self._oldest.items()), default=(0, ""))
        silent_s = {
            key: age_ns / 1e9
            for key, age_ns in self._oldest.items()
            if age_ns > _SILENT_NS and (key == STATE_FEATURE or key.startswith(CAMERA_PREFIX))
        }
        return SampledEpisode(
            self._episode(), self._left_out, by_stamps, worst_ns / 1e9, feature, silent_s
        )

    def _take(self, decoded: DecodedMessage, time_ns: int) -> None:
        try:
            for vector in self._vectors.values():
                if decoded.topic in vector.topics:
                    vector.update(decoded.topic, decoded.message, time_ns)
            if decoded.topic in self._films:
                self._films[decoded.topic].camera.update(decoded.message, time_ns)
        except (PictureError, InvalidMessageError):
            self._left_out[decoded.topic] = self._left_out.get(decoded.topic, 0) + 1

    def _missing(self) -> list[str]:
        missing = [topic for vector in self._vectors.values() for topic in vector.missing()]
        return missing + [name for name, one in self._films.items() if one.camera.newest is None]

    def _add_frames(self, before_ns: int) -> None:
        """Add the frames that are due before a time, from the newest values."""
        if self._start_ns is None:
            return
        fps = self._options.fps
        until = (before_ns - self._start_ns) * fps / 1e9
        if until > self._frames + _MOST_FRAMES:
            raise InvalidFileError(f"{until:.0f} frames at {fps} Hz are too many for an episode")
        while self._frames < until:
            now_ns = self._start_ns + round(self._frames * 1e9 / fps)
            for key, vector in self._vectors.items():
                self._rows[key].append(vector.values_at(now_ns))
            for film in self._films.values():
                film.add_frame(self._frames / fps)
            taken = self._times()
            self._rows[STAMPS].append([(one - self._start_ns) / 1e9 for one in taken.values()])
            for key, time_ns in taken.items():
                # Without twists, their age has no meaning.
                if key != HAND and now_ns - time_ns > self._oldest.get(key, 0):
                    self._oldest[key] = now_ns - time_ns
            self._frames += 1

    def _times(self) -> dict[str, int]:
        """Return the times of the newest values by feature; the start for a missing twist."""
        start_ns = self._start_ns or 0
        times = {key: vector.time_ns or start_ns for key, vector in self._vectors.items()}
        return times | {one.camera.key: one.camera.time_ns for one in self._films.values()}

    def _episode(self) -> Episode:
        options = self._options
        vectors: dict[str, Values] = {key: np.array(rows) for key, rows in self._rows.items()}
        names = {key: vector.names for key, vector in self._vectors.items()}
        names[STAMPS] = tuple(self._times())
        prismatic = prismatic_joints(self._bag)
        units_of = {key: units(each, prismatic) for key, each in names.items()}
        units_of[STAMPS] = ["s"] * len(names[STAMPS])
        videos = {}
        for film in self._films.values():
            assert film.video is not None
            videos[film.camera.key] = Video(*film.video.shown_size, film.camera.is_depth)
        pictures = {film.camera.key: film.statistics.result() for film in self._films.values()}
        return Episode(
            vectors, names, units_of, videos, pictures, options.fps, options.task, options.robot
        )


def _has_one_clock(decoder: Decoder) -> bool:
    """Return whether the stamps of all stamped topics are of the clock of the recording."""
    found = [
        abs(stamp - first.log_time_ns) < _ONE_CLOCK_NS
        for topic in decoder.topics
        if (first := next(iter(decoder.messages([topic])), None)) is not None
        and (stamp := _stamp_ns(first)) is not None
    ]
    return bool(found) and all(found)


def _stamp_ns(decoded: DecodedMessage) -> int | None:
    header = getattr(decoded.message, "header", None)
    stamp = getattr(header, "stamp", None)
    return None if stamp is None else to_nanoseconds(stamp)


def _by_log_time(decoder: Decoder) -> Iterator[tuple[int, DecodedMessage]]:
    return ((decoded.log_time_ns, decoded) for decoded in decoder.messages())


def _by_stamp(decoder: Decoder) -> Iterator[tuple[int, DecodedMessage]]:
    """Yield messages with their stamps, in their order.

    A message without a stamp, or with a later one than its recording, has the time of recording.
    """
    held: list[tuple[int, int, DecodedMessage]] = []
    numbers = itertools.count()
    last_ns = 0
    for decoded in decoder.messages():
        stamp_ns = _stamp_ns(decoded)
        now_ns = decoded.log_time_ns
        time_ns = min(stamp_ns, now_ns) if stamp_ns else now_ns
        heapq.heappush(held, (time_ns, next(numbers), decoded))
        while held and held[0][0] <= now_ns - _LATEST_NS:
            time_ns, _, earliest = heapq.heappop(held)
            last_ns = max(last_ns, time_ns)
            yield last_ns, earliest
    while held:
        time_ns, _, earliest = heapq.heappop(held)
        last_ns = max(last_ns, time_ns)
        yield last_ns, earliest
