"""The files of a LeRobotDataset v3.0 with one episode, and the statistics of its features."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from teleopctl.base.extras import extra

VERSION = "v3.0"

_PLACE = "chunk-000/file-000"
_PATTERN = "chunk-{chunk_index:03d}/file-{file_index:03d}"
# Values that LeRobot's own programs write, since these may add episodes to the data set.
_CHUNKS, _DATA_MB, _VIDEO_MB = 1000, 100, 200


class Video(NamedTuple):
    """Width and height in pixels of a video of a LeRobot data set."""

    width: int
    height: int


class Episode(NamedTuple):
    """Content of a LeRobot data set with one episode, except for the video files.

    Attributes:
        vectors: Values of each feature, shape (frames, elements).
        names: Names of the elements of each feature.
        videos: Size of the video of each camera feature.
        fps: Frames per second.
        task: Description of the task in words.
        robot: Type of the robot, or None.
    """

    vectors: Mapping[str, Values]
    names: Mapping[str, tuple[str, ...]]
    videos: Mapping[str, Video]
    fps: int
    task: str
    robot: str | None

    @property
    def length(self) -> int:
        """Number of frames of the episode."""
        return len(next(iter(self.vectors.values())))


def video_path(folder: Path, key: str) -> Path:
    """Return the path of the video of a camera feature in the folder of a data set."""
    return folder / "videos" / key / f"{_PLACE}.mp4"


# Any: integer indices, and the time as float.
def index_columns(length: int, fps: int) -> dict[str, npt.NDArray[Any]]:
    """Return LeRobot's timestamp, frame, episode and task index columns for an episode."""
    numbers = np.arange(length, dtype=np.int64)
    zeros = np.zeros(length, np.int64)
    return {
        "timestamp": (numbers / fps).astype(np.float32),
        "frame_index": numbers,
        "episode_index": zeros,
        "index": numbers,
        "task_index": zeros,
    }


def write_episode(folder: Path, episode: Episode, statistics: Mapping[str, Statistics]) -> None:
    """Write all files of a LeRobot data set with one episode, except the videos.

    Args:
        folder: Folder of the data set.
        episode: Content to write.
        statistics: Statistics of each feature.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    with extra("export", "pyarrow"):
        import pyarrow as pa
    indices = index_columns(episode.length, episode.fps)
    columns: dict[str, Any] = {}  # Any: pyarrow's arrays
    for key, values in episode.vectors.items():
        flat = pa.array(values.astype(np.float32).ravel())
        width = values.shape[1]
        # LeRobot stores a vector of one element as a scalar.
        columns[key] = flat if width == 1 else pa.FixedSizeListArray.from_arrays(flat, width)
    columns.update((key, pa.array(values)) for key, values in indices.items())
    _write_table(folder / "data" / f"{_PLACE}.parquet", pa.table(columns))
    _write_tasks(folder / "meta" / "tasks.parquet", episode.task)
    _write_json(folder / "meta" / "stats.json", _lists(statistics))
    _write_json(folder / "meta" / "info.json", _info(episode))
    _write_table(
        folder / "meta" / "episodes" / f"{_PLACE}.parquet",
        pa.table({key: [value] for key, value in _episode_row(episode, statistics).items()}),
    )


def _info(episode: Episode) -> dict[str, Any]:
    features: dict[str, Any] = {}
    for key, values in episode.vectors.items():
        names = list(episode.names[key])
        features[key] = {"dtype": "float32", "shape": [values.shape[1]], "names": names}
    for key, video in episode.videos.items():
        features[key] = {
            "dtype": "video",
            "shape": [video.height, video.width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": video.height,
                "video.width": video.width,
                "video.codec": "h264",
                "video.pix_fmt": "yuv420p",
                "video.is_depth_map": False,
                "video.fps": episode.fps,
                "video.channels": 3,
                "has_audio": False,
            },
        }
    for key, values in index_columns(0, episode.fps).items():
        features[key] = {"dtype": str(values.dtype), "shape": [1], "names": None}
    return {
        "codebase_version": VERSION,
        "robot_type": episode.robot,
        "total_episodes": 1,
        "total_frames": episode.length,
        "total_tasks": 1,
        "chunks_size": _CHUNKS,
        "data_files_size_in_mb": _DATA_MB,
        "video_files_size_in_mb": _VIDEO_MB,
        "fps": episode.fps,
        "splits": {"train": "0:1"},
        "data_path": f"data/{_PATTERN}.parquet",
        "video_path": f"videos/{{video_key}}/{_PATTERN}.mp4" if episode.videos else None,
        "features": features,
    }


def _episode_row(episode: Episode, statistics: Mapping[str, Statistics]) -> dict[str, Any]:
    row: dict[str, Any] = {
        "episode_index": 0,
        "tasks": [episode.task],
        "length": episode.length,
        "data/chunk_index": 0,
        "data/file_index": 0,
        "dataset_from_index": 0,
        "dataset_to_index": episode.length,
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
    }
    for key in episode.videos:
        row[f"videos/{key}/chunk_index"] = 0
        row[f"videos/{key}/file_index"] = 0
        row[f"videos/{key}/from_timestamp"] = 0.0
        row[f"videos/{key}/to_timestamp"] = episode.length / episode.fps
    for key, found in _lists(statistics).items():
        row.update((f"stats/{key}/{name}", values) for name, values in found.items())
    return row


def _lists(statistics: Mapping[str, Statistics]) -> dict[str, dict[str, Any]]:
    return {
        key: {name: values.tolist() for name, values in found.items()}
        for key, found in statistics.items()
    }


def _write_tasks(file: Path, task: str) -> None:
    """Write the table of tasks, whose index pandas makes of a column that metadata names."""
    import pyarrow as pa

    column = "__index_level_0__"
    kinds = {"task_index": "int64", column: "unicode"}
    pandas = {
        "index_columns": [column],
        "column_indexes": [],
        "columns": [
            {
                "name": None if name == column else name,
                "field_name": name,
                "pandas_type": kind,
                "numpy_type": "object" if kind == "unicode" else kind,
                "metadata": None,
            }
            for name, kind in kinds.items()
        ],
    }
    table = pa.table({"task_index": [0], column: [task]})
    _write_table(file, table.replace_schema_metadata({"pandas": json.dumps(pandas)}))


def _write_table(file: Path, table: Any) -> None:
    from pyarrow import parquet

    file.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(table, file)


def _write_json(file: Path, document: object) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(document, indent=4, ensure_ascii=False)
    file.write_text(text, encoding="utf-8")


Values: TypeAlias = npt.NDArray[np.float64]
Statistics: TypeAlias = dict[str, Values]

_QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
# Approximate number of pixels sampled in each row and column of an image.
_SAMPLES = 100


def feature_statistics(values: Values) -> Statistics:
    """Return minimum, maximum, mean, deviation, quantiles and count of a feature, by name.

    Args:
        values: Values of the feature in all frames, shape (frames, elements).

    Returns:
        Arrays of shape (elements,), and ``count`` of shape (1,).
    """
    quantiles = np.quantile(values, list(_QUANTILES.values()), axis=0)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([len(values)]),
        **dict(zip(_QUANTILES, quantiles, strict=True)),
    }


class PictureStatistics:
    """Colour statistics of a video for LeRobot, accumulated in histograms frame by frame."""

    def __init__(self) -> None:
        self._counts = np.zeros((3, 256), np.int64)
        self._frames = 0

    def add(self, pixels: npt.NDArray[np.uint8]) -> None:
        """Add about 100 by 100 pixels of a frame, shape (height, width, 3), to the histograms."""
        rows, columns = (max(side // _SAMPLES, 1) for side in pixels.shape[:2])
        some = pixels[::rows, ::columns]
        for colour in range(3):
            self._counts[colour] += np.bincount(some[..., colour].ravel(), minlength=256)
        self._frames += 1

    def result(self) -> Statistics:
        """Return statistics by name, from 0 to 1, shape (3, 1, 1) for RGB; ``count`` has (1,)."""
        shades = np.arange(256) / 255.0
        shares = self._counts / self._counts.sum(axis=1, keepdims=True)
        means = shares @ shades
        below = shares.cumsum(axis=1)
        there = self._counts > 0
        found = {
            "min": shades[there.argmax(axis=1)],
            "max": shades[255 - there[:, ::-1].argmax(axis=1)],
            "mean": means,
            "std": np.sqrt(np.maximum(shares @ shades**2 - means**2, 0.0)),
        }
        for name, share in _QUANTILES.items():
            found[name] = shades[(below >= share - 1e-12).argmax(axis=1)]
        shaped = {name: values.reshape(3, 1, 1) for name, values in found.items()}
        return {**shaped, "count": np.array([self._frames])}
