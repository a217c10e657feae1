"""A bag as an episode of LeRobot: joint states, actions and cameras at a constant rate.

Each frame holds the newest message of every feature at the frame's time. The first frame is at the
time at which every feature has a message, the last frame not after the last message.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from teleopctl.bag.base import Bag
from teleopctl.bag.export.decoding import PICTURES, DecodedMessage, Decoder
from teleopctl.bag.export.lerobot_files import (
    Episode,
    PictureStatistics,
    Video,
    feature_statistics,
    index_columns,
    video_path,
    write_episode,
)
from teleopctl.bag.export.output_folder import file_stems, make_output_folder, removed_on_error
from teleopctl.bag.export.plots import parse_field
from teleopctl.bag.export.video import VideoFile
from teleopctl.errors import (
    InvalidFileError,
    InvalidMessageError,
    NotFoundError,
    SystemFailureError,
    UsageError,
)
from teleopctl.interfaces import field_reader
from teleopctl.pictures import GreyScaling, PictureError, image_of

if TYPE_CHECKING:
    from PIL.Image import Image as PilImage


# Default field of a topic by its type, used if only a topic is given.
_FIELDS = {
    "sensor_msgs/msg/JointState": "position",
    "trajectory_msgs/msg/JointTrajectory": "points[-1].positions",
    "control_msgs/msg/JointTrajectoryControllerState": "reference.positions",
    "std_msgs/msg/Float64MultiArray": "data",
    "std_msgs/msg/Float32MultiArray": "data",
}
_NAMES = ("name", "joint_names")


class VectorField:
    """Reader of an array field of a topic, such as joint positions, that keeps the newest values.

    The first message defines the elements. If messages name their elements, such as joints, later
    messages may have other orders or fewer elements: missing elements keep their values.

    Args:
        text: Name of a topic, or topic and field.
        topics: Types of the bag's topics, by topic name.

    Attributes:
        topic: Name of the topic.
        names: Names of the elements; empty before the first message.
        newest: Newest values of the elements.

    Raises:
        NotFoundError: The topic does not exist.
        UsageError: The type has no default field, or the field path is malformed.
    """

    def __init__(self, text: str, topics: dict[str, str]) -> None:
        self.topic, path = parse_field(text, list(topics))
        path = path or _FIELDS.get(topics[self.topic], "")
        if not path:
            raise UsageError(
                f"{self.topic} has the type {topics[self.topic]}: name one of its fields",
                hint=f"Name it, such as {self.topic}/position. Only a topic is enough for "
                f"{', '.join(_FIELDS)}.",
            )
        self.names: tuple[str, ...] = ()
        self.newest: list[float] = []
        self._read = field_reader(path)
        self._places: dict[str, int] = {}

    # Any: a message of any type.
    def update(self, message: Any) -> None:
        """Update `newest` from a message's values, by element name if named; ignore empty arrays.

        Raises:
            InvalidMessageError: The field is no vector, or its length differs from the first one.
        """
        try:
            values = [float(value) for value in self._read(message)]
        except (TypeError, ValueError) as error:
            raise InvalidMessageError(f"{self.topic}: the field is not a vector") from error
        if not values:
            return
        names = _names(message, len(values))
        if not self.names:
            self.names = names or tuple(map(str, range(len(values))))
            self._places = {name: place for place, name in enumerate(names)}
            self.newest = values
            return
        if names and self._places:
            for name, value in zip(names, values, strict=True):
                if name in self._places:
                    self.newest[self._places[name]] = value
        elif len(values) == len(self.newest):
            self.newest = values
        else:
            raise InvalidMessageError(
                f"{self.topic} has {len(values)} values in place of {len(self.newest)}"
            )


def _names(message: Any, length: int) -> tuple[str, ...]:
    for field in _NAMES:
        names = getattr(message, field, None)
        if isinstance(names, list) and len(names) == length and len(set(names)) == length:
            return tuple(names)
    return ()


def decodable_types(decoder: Decoder) -> dict[str, str]:
    """Return the message type of each topic that a decoder can decode, by topic name."""
    return {name: topic.type_name for name, topic in decoder.topics.items()}


_STATE, _ACTION, _CAMERA = "observation.state", "action", "observation.images."
# Distance of key frames as in LeRobot, since a training reads frames in any order.
_KEY_EVERY = 2
# Limits the frames of one gap: after a clock change, one state would fill the disk.
_MOST_FRAMES = 1_000_000


class LeRobotOptions(NamedTuple):
    """Options of an export to a LeRobot data set: topics, frame rate and task.

    Attributes:
        state: Topic of the robot's state, mostly ``/joint_states``, or a field of a topic.
        action: Topic of the robot's commands, or a field of a topic; None for no action.
        cameras: Names of image topics.
        fps: Frames per second.
        task: Description of the task in words.
        robot: Type of the robot in one word, or None.
    """

    state: str
    action: str | None = None
    cameras: Sequence[str] = ()
    fps: int = 30
    task: str = "teleoperation"
    robot: str | None = None


class LeRobotSummary(NamedTuple):
    """Result of `export_lerobot`: frame count, element names and unusable messages.

    Attributes:
        frames: Number of frames in the data set.
        names: Names of the elements of each feature.
        left_out: Number of messages that could not be used, by topic.
    """

    frames: int
    names: dict[str, tuple[str, ...]]
    left_out: dict[str, int]


def export_lerobot(bag: Bag, folder: Path, options: LeRobotOptions) -> LeRobotSummary:
    """Export a bag as a LeRobot data set with one episode; return a summary.

    Args:
        bag: Bag to export.
        folder: Folder of the data set, created if missing.
        options: Topics, frame rate and task.

    Raises:
        NotFoundError: A topic does not exist, or has no usable message.
        UsageError: A camera topic has no images, a topic has no default field, or the frame rate is
            not between 1 and 1000.
        InvalidMessageError: A topic cannot be decoded.
        MissingExtraError: pyarrow or PyAV is not installed.
        RefusedError: The folder is not empty.
        SystemFailureError: A file cannot be written.
        InvalidFileError: The bag is broken, or a gap between its times is too long.
    """
    if not 1 <= options.fps <= 1000:
        raise UsageError(f"{options.fps} is not a frame rate")
    recording = _Recording(bag, folder, options)
    make_output_folder(folder)
    try:
        with removed_on_error((folder,)):
            return recording.write()
    except OSError as error:
        raise SystemFailureError(f"Cannot write to {folder}: {error.strerror or error}") from error


class _Camera:
    """Image topic of an export: the newest image, and the video of the sampled ones."""

    def __init__(self, key: str, file: Path, rate: int) -> None:
        self.key = key
        self.newest: PilImage | None = None
        self.film: VideoFile | None = None
        self.statistics = PictureStatistics()
        self._file = file
        self._rate = rate
        self._scaling = GreyScaling()

    # Any: an image message.
    def update(self, message: Any) -> None:
        """Set the newest image of the camera from an image message.

        Raises:
            PictureError: The message has no image, or one of another size than the first.
        """
        image = image_of(message, self._scaling).convert("RGB")
        if self.newest is not None and image.size != self.newest.size:
            raise PictureError(f"{image.size} is not {self.newest.size}")
        self.newest = image

    def add_frame(self, time_s: float) -> None:
        assert self.newest is not None
        if self.film is None:
            self._file.parent.mkdir(parents=True)
            size = self.newest.size
            self.film = VideoFile(self._file, size, rate=self._rate, key_every=_KEY_EVERY)
        self.film.add(time_s, self.newest)
        self.statistics.add(np.asarray(self.newest))

    def close(self) -> None:
        if self.film is not None:
            self.film.close()


class _Recording:
    """State of an export: vectors and cameras, and the frames sampled so far."""

    def __init__(self, bag: Bag, folder: Path, options: LeRobotOptions) -> None:
        self._folder = folder
        self._options = options
        types = decodable_types(Decoder(bag))
        self._vectors = {_STATE: VectorField(options.state, types)}
        if options.action is not None:
            self._vectors[_ACTION] = VectorField(options.action, types)
        self._cameras: dict[str, _Camera] = {}
        for topic, stem in file_stems(options.cameras).items():
            if topic not in types:
                raise NotFoundError(f"{bag.path} has no topic '{topic}' that can be decoded")
            if types[topic] not in PICTURES:
                raise UsageError(f"{topic} has no pictures, but {types[topic]}")
            key = f"{_CAMERA}{stem}"
            self._cameras[topic] = _Camera(key, video_path(folder, key), options.fps)
        topics = {*self._cameras, *(vector.topic for vector in self._vectors.values())}
        self._decoder = Decoder(bag, sorted(topics))
        self._rows: dict[str, list[list[float]]] = {key: [] for key in self._vectors}
        self._left_out: dict[str, int] = {}
        self._start_ns: int | None = None
        self._frames = 0

    def write(self) -> LeRobotSummary:
        last_ns = 0
        with ExitStack() as stack:
            for camera in self._cameras.values():
                stack.callback(camera.close)
            for decoded in self._decoder.messages():
                last_ns = decoded.log_time_ns
                self._add_frames(last_ns)
                self._take(decoded)
                if self._start_ns is None and self._is_complete():
                    self._start_ns = last_ns
            self._add_frames(last_ns + 1)
        if not self._frames:
            raise NotFoundError(f"There is no message of {', '.join(self._missing())}")
        self._write_files()
        for topic, count in self._decoder.unreadable.items():
            self._left_out[topic] = self._left_out.get(topic, 0) + count
        names = {key: vector.names for key, vector in self._vectors.items()}
        return LeRobotSummary(self._frames, names, self._left_out)

    def _take(self, decoded: DecodedMessage) -> None:
        try:
            for vector in self._vectors.values():
                if vector.topic == decoded.topic:
                    vector.update(decoded.message)
            if decoded.topic in self._cameras:
                self._cameras[decoded.topic].update(decoded.message)
        except (PictureError, InvalidMessageError):
            self._left_out[decoded.topic] = self._left_out.get(decoded.topic, 0) + 1

    def _missing(self) -> list[str]:
        missing = [vector.topic for vector in self._vectors.values() if not vector.names]
        return missing + [name for name, one in self._cameras.items() if one.newest is None]

    def _is_complete(self) -> bool:
        return not self._missing()

    def _add_frames(self, before_ns: int) -> None:
        """Add the frames that are due before a time, from the newest values."""
        if self._start_ns is None:
            return
        fps = self._options.fps
        until = (before_ns - self._start_ns) * fps / 1e9
        if until > self._frames + _MOST_FRAMES:
            raise InvalidFileError(f"{until:.0f} frames at {fps} Hz are too many for an episode")
        while self._frames < until:
            for key, vector in self._vectors.items():
                self._rows[key].append(list(vector.newest))
            for camera in self._cameras.values():
                camera.add_frame(self._frames / fps)
            self._frames += 1

    def _write_files(self) -> None:
        options = self._options
        vectors = {key: np.array(rows) for key, rows in self._rows.items()}
        films = {one.key: one.film for one in self._cameras.values() if one.film is not None}
        videos = {key: Video(*film.shown_size) for key, film in films.items()}
        pictures = {one.key: one.statistics.result() for one in self._cameras.values()}
        names = {key: vector.names for key, vector in self._vectors.items()}
        episode = Episode(vectors, names, videos, options.fps, options.task, options.robot)
        numbers = {**vectors, **index_columns(self._frames, options.fps)}
        statistics = {
            key: feature_statistics(np.asarray(values, np.float64).reshape(self._frames, -1))
            for key, values in numbers.items()
        }
        write_episode(self._folder, episode, {**statistics, **pictures})
