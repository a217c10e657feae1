"""Files of a LeRobotDataset v3.0, which grows episode by episode.

Each episode has files of its own, so that adding one writes none of the others again. The new
files are complete before `meta/info.json`, which counts the episodes, is replaced as the last
one: a data set whose writer was killed has all episodes but the one that was being added.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from teleopctl.bag.lerobot.depth import INFORMATION
from teleopctl.bag.lerobot.files import read_tasks, write_json, write_table, write_tasks
from teleopctl.bag.lerobot.statistics import (
    Statistics,
    Values,
    feature_statistics,
    joined_statistics,
)
from teleopctl.base.extras import extra
from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError

VERSION = "v3.0"
"""Version of LeRobot's format."""

DATA_FOLDERS = ("data", "videos", "meta")
"""Names of the folders of a data set, which LeRobot's format gives them."""

_PATTERN = "chunk-{chunk_index:03d}/file-{file_index:03d}"
# Only such files are removed: others in the folder are not of the data set.
_FILES = "chunk-[0-9][0-9][0-9]/file-[0-9][0-9][0-9]"
# Values that LeRobot's own programs write, since these may add episodes to the data set.
_CHUNKS, _DATA_MB, _VIDEO_MB = 1000, 100, 200
_INFO, _STATS = "meta/info.json", "meta/stats.json"
_TASKS = "meta/tasks.parquet"
_EPISODES = "meta/episodes/chunk-000/file-000.parquet"
# Extra columns of an episode's row, which LeRobot passes over.
_SUCCESS, _HAND, _OFFSET = "success", "driven_by", "worst_offset_s"
# Any: JSON.
_OF_COLOURS: dict[str, Any] = {
    "video.codec": "h264",
    "video.pix_fmt": "yuv420p",
    "video.is_depth_map": False,
    "video.channels": 3,
}
_INDICES = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}


class Video(NamedTuple):
    """Width and height in pixels of a video of a LeRobot data set, and whether it has depths."""

    width: int
    height: int
    is_depth: bool = False


class Episode(NamedTuple):
    """Content of an episode, except for the video files.

    Attributes:
        vectors: Values of each feature, shape (frames, elements).
        names: Names of the elements of each feature.
        units: Units of the elements of each feature, empty for an unknown one.
        videos: Size of the video of each camera feature.
        pictures: Statistics of each camera feature.
        fps: Frames per second.
        task: Description of the task in words.
        robot: Type of the robot, or None.
    """

    vectors: Mapping[str, Values]
    names: Mapping[str, Sequence[str]]
    units: Mapping[str, Sequence[str]]
    videos: Mapping[str, Video]
    pictures: Mapping[str, Statistics]
    fps: int
    task: str
    robot: str | None

    @property
    def length(self) -> int:
        """Number of frames of the episode."""
        return len(next(iter(self.vectors.values())))


class EpisodeNotes(NamedTuple):
    """Notes on an episode, beside its frames.

    Attributes:
        success: Whether the task succeeded; None if unknown.
        driven_by: Device or program that drove the robot; empty if unknown.
        worst_offset_s: Largest age of a value in a frame, in seconds.
    """

    success: bool | None = None
    driven_by: str = ""
    worst_offset_s: float = 0.0


class EpisodeRow(NamedTuple):
    """Episode of a data set, as its table of episodes has it.

    Attributes:
        number: Number of the episode, from 0.
        length: Number of frames.
        task: Description of the task.
        notes: Notes on the episode.
    """

    number: int
    length: int
    task: str
    notes: EpisodeNotes


class LeRobotDataset:
    """Data set in a folder, to which episodes are added and from which they are removed.

    Args:
        folder: Folder of the data set; without one in it, the first episode begins it.

    Raises:
        InvalidFileError: The folder has a data set of another version, or a broken one.
        MissingExtraError: pyarrow is not installed.
    """

    def __init__(self, folder: Path) -> None:
        with extra("export", "pyarrow"):
            import pyarrow  # noqa: F401
        self.folder = folder
        self._info: dict[str, Any] | None = None
        self._rows: list[dict[str, Any]] = []
        self._tasks: list[str] = []
        if (folder / _INFO).exists():
            self._read()

    @property
    def episodes(self) -> list[EpisodeRow]:
        """Episodes of the data set in their order."""
        return [
            EpisodeRow(
                index,
                row["length"],
                str(row["tasks"][0]) if row["tasks"] else "",
                EpisodeNotes(row.get(_SUCCESS), row.get(_HAND) or "", row.get(_OFFSET) or 0.0),
            )
            for index, row in enumerate(self._rows)
        ]

    @property
    def fps(self) -> int | None:
        """Frames per second; None before the first episode."""
        return None if self._info is None else int(self._info["fps"])

    @property
    def robot(self) -> str:
        """Type of the robot; empty if unknown."""
        return "" if self._info is None else str(self._info["robot_type"] or "")

    # Any, here and below: JSON and rows of tables.
    @property
    def features(self) -> dict[str, Any]:
        """Features by name, as in the data set's information, without LeRobot's indices."""
        listed = {} if self._info is None else self._info["features"]
        return {key: value for key, value in listed.items() if key not in _INDICES}

    # Any: JSON.
    @property
    def statistics(self) -> dict[str, dict[str, Any]]:
        """Statistics over all episodes, by feature and name."""
        return {
            key: {name: value.tolist() for name, value in found.items()}
            for key, found in self._total_statistics().items()
        }

    def refusal(self, episode: Episode) -> str:
        """Return why an episode does not fit into the data set; empty if it does."""
        if self._info is None:
            return ""
        if self._info["fps"] != episode.fps:
            return f"has {self._info['fps']} frames a second, not {episode.fps}"
        robot = self._info["robot_type"]
        if robot and episode.robot and robot != episode.robot:
            return f"is of the robot '{robot}', not '{episode.robot}'"
        here, new = self.features, _features(episode)
        if missing := sorted(here.keys() - new.keys()):
            return f"has {', '.join(missing)}, which the episode lacks"
        if added := sorted(new.keys() - here.keys()):
            return f"lacks {', '.join(added)} of the episode"
        for key, feature in here.items():
            if feature["shape"] != new[key]["shape"]:
                size, other = (" x ".join(map(str, one["shape"])) for one in (feature, new[key]))
                return f"has {key} of the size {size}, not {other}"
            if list(feature["names"]) != list(new[key]["names"]):
                ours, theirs = (", ".join(one["names"]) for one in (feature, new[key]))
                return f"has {key} with {ours}, not {theirs}"
        return ""

    def add(
        self,
        episode: Episode,
        videos: Mapping[str, Path],
        notes: EpisodeNotes | None = None,
        *,
        index: int | None = None,
    ) -> int:
        """Add an episode at the end, or in place of one; return its index.

        Args:
            episode: Content of the episode.
            videos: Finished video of each camera feature, which is moved into the data set; on
                the same disk.
            notes: Notes on the episode.
            index: Index of the episode to replace; None to add one.

        Raises:
            RefusedError: The episode does not fit into the data set.
            OSError: A file cannot be written; the data set is as before.
        """
        if reason := self.refusal(episode):
            raise RefusedError(
                f"The data set {self.folder} {reason}",
                hint="Record or export into another folder.",
            )
        self._remove_leftovers()
        notes = notes or EpisodeNotes()
        place = self._free_place()
        row: dict[str, Any] = {
            "tasks": [episode.task],
            "length": episode.length,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
            _SUCCESS: notes.success,
            _HAND: notes.driven_by,
            _OFFSET: notes.worst_offset_s,
        }
        for key in episode.videos:
            row[f"videos/{key}/chunk_index"], row[f"videos/{key}/file_index"] = place
            row[f"videos/{key}/from_timestamp"] = 0.0
            row[f"videos/{key}/to_timestamp"] = episode.length / episode.fps
            film = self._video(key, place)
            film.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(videos[key], film)
        numbers = np.arange(episode.length, dtype=np.float64)
        counted = {"timestamp": numbers / episode.fps, "frame_index": numbers}
        for key, values in {**episode.vectors, **counted}.items():
            _add_statistics(row, key, feature_statistics(values.reshape(episode.length, -1)))
        for key, found in episode.pictures.items():
            _add_statistics(row, key, found)
        number = len(self._rows) if index is None else index
        rows = [*self._rows[:number], row, *self._rows[number + 1 :]]
        self._commit(rows, _information(episode, self._info), episode.vectors)
        if index is not None:
            self._remove_leftovers()
        return number

    def remove(self, indices: Sequence[int]) -> None:
        """Remove episodes; the later ones get their numbers.

        Raises:
            NotFoundError: There is no such episode.
            RefusedError: No episode would remain, or one would that is in the same file.
        """
        for index in indices:
            self.require(index)
        rows = [row for index, row in enumerate(self._rows) if index not in set(indices)]
        if {_place(self._rows[index], "data") for index in indices} & {
            _place(row, "data") for row in rows
        }:
            raise self._has_shared_files()
        if not rows:
            raise RefusedError(
                f"No episode would remain in {self.folder}", hint="Remove the folder instead."
            )
        assert self._info is not None
        self._commit(rows, self._info, {})
        self._remove_leftovers()

    def require(self, index: int) -> None:
        """Raise if the data set does not have an episode.

        Raises:
            NotFoundError: There is no such episode.
        """
        if not 0 <= index < len(self._rows):
            has = f"0 to {len(self._rows) - 1}" if self._rows else "none"
            raise NotFoundError(f"{self.folder} has no episode {index}", hint=f"It has {has}.")

    # --- reading --------------------------------------------------------------------------

    def _read(self) -> None:
        from pyarrow import ArrowException, parquet

        try:
            info = json.loads((self.folder / _INFO).read_text(encoding="utf-8"))
            if info["codebase_version"] != VERSION:
                raise InvalidFileError(
                    f"{self.folder} is a LeRobot data set {info['codebase_version']}, "
                    f"not {VERSION}",
                    hint="lerobot's convert_dataset_v21_to_v30 converts one of v2.1; or choose "
                    "another folder.",
                )
            rows: list[dict[str, Any]] = []
            for file in sorted((self.folder / "meta" / "episodes").glob("*/*.parquet")):
                rows += parquet.read_table(file).to_pylist()
            rows.sort(key=lambda row: int(row["episode_index"]))
            # The information is written last: what it does not count was being added.
            self._rows = rows[: int(info["total_episodes"])]
            self._tasks = read_tasks(self.folder / _TASKS)
            self._info = info
        except (OSError, ValueError, KeyError, TypeError, ArrowException) as error:
            raise self._broken(f"is no LeRobot data set: {error}") from error
        if len(self._rows) != int(info["total_episodes"]):
            raise self._broken(
                f"counts {info['total_episodes']} episodes, and lists only {len(self._rows)}"
            )
        if missing := next((file for file in sorted(self._used()) if not file.exists()), None):
            raise self._broken(f"lacks {missing.relative_to(self.folder)}")

    def _broken(self, problem: str) -> InvalidFileError:
        """Return the error for a data set that cannot be used, with what can be done."""
        hint = "Choose another folder."
        if next(self.folder.glob("episodes/episode_*.mcap"), None):
            hint = (
                "Its bags can make it again: remove data, videos and meta there, then "
                f"teleopctl episode build {self.folder}"
            )
        return InvalidFileError(f"{self.folder} {problem}", hint=hint)

    # --- places ---------------------------------------------------------------------------

    def _data(self, place: tuple[int, int]) -> Path:
        return self.folder / "data" / f"{_at(place)}.parquet"

    def _video(self, key: str, place: tuple[int, int]) -> Path:
        return self.folder / "videos" / key / f"{_at(place)}.mp4"

    def _free_place(self) -> tuple[int, int]:
        """Return the first place after all files of all episodes."""
        keys = ["data", *(f"videos/{key}" for key in self._video_keys())]
        places = [_place(row, key) for row in self._rows for key in keys]
        return _next(max(places)) if places else (0, 0)

    def _remove_leftovers(self) -> None:
        """Remove files of no episode: of one that was being added when its writer was killed."""
        used = self._used()
        for pattern in (f"data/{_FILES}.parquet", f"videos/*/{_FILES}.mp4"):
            for file in self.folder.glob(pattern):
                if file not in used:
                    file.unlink(missing_ok=True)

    def _used(self) -> set[Path]:
        """Return the files of all episodes."""
        used = {self._data(_place(row, "data")) for row in self._rows}
        for key in self._video_keys():
            used |= {self._video(key, _place(row, f"videos/{key}")) for row in self._rows}
        return used

    def _video_keys(self) -> list[str]:
        return [key for key, feature in self.features.items() if feature["dtype"] == "video"]

    # --- writing --------------------------------------------------------------------------

    def _commit(
        self,
        rows: Sequence[dict[str, Any]],
        info: dict[str, Any],
        vectors: Mapping[str, Values],
    ) -> None:
        """Write the data of new and of renumbered episodes, then all tables.

        LeRobot reads data files in the order of their places. So once an episode gets a new place,
        all later ones do.

        Args:
            rows: Episodes in their order; a new one has no place of its data yet.
            info: Information of the data set.
            vectors: Vectors of the new episode.
        """
        tasks = [*self._tasks]
        tasks += [task for row in rows if (task := str(row["tasks"][0])) not in tasks]
        place = self._free_place()
        at = 0
        moves = False
        written = []
        for index, row in enumerate(rows):
            indices = (index, at, tasks.index(str(row["tasks"][0])))
            end = at + row["length"]
            is_new = "data/file_index" not in row
            if is_new or (row["episode_index"], row["dataset_from_index"]) != (index, at):
                moves = True
            changed = {"episode_index": index, "dataset_from_index": at, "dataset_to_index": end}
            if moves:
                if is_new:
                    self._write_data(place, row["length"], vectors, info["fps"], indices)
                else:
                    self._move_data(row, place, indices)
                changed |= {"data/chunk_index": place[0], "data/file_index": place[1]}
                place = _next(place)
            written.append({**row, **changed})
            at = end
        self._rows, self._tasks = written, tasks
        self._info = {
            **info,
            "total_episodes": len(rows),
            "total_frames": at,
            "total_tasks": len(tasks),
            "splits": {"train": f"0:{len(rows)}"},
        }
        self._write_rows()
        write_tasks(self.folder / _TASKS, tasks)
        write_json(self.folder / _STATS, self.statistics)
        write_json(self.folder / _INFO, self._info)

    def _write_data(
        self,
        place: tuple[int, int],
        length: int,
        vectors: Mapping[str, Values],
        fps: int,
        indices: tuple[int, int, int],
    ) -> None:
        import pyarrow as pa

        columns: dict[str, Any] = {}  # Any: pyarrow's arrays
        for key, values in vectors.items():
            flat = pa.array(values.astype(np.float32).ravel())
            width = values.shape[1]
            # LeRobot stores a vector of one element as a scalar.
            columns[key] = flat if width == 1 else pa.FixedSizeListArray.from_arrays(flat, width)
        numbers = np.arange(length, dtype=np.int64)
        columns["timestamp"] = pa.array((numbers / fps).astype(np.float32))
        columns["frame_index"] = pa.array(numbers)
        write_table(self._data(place), pa.table(columns | _index_columns(length, indices)))

    def _move_data(
        self, row: Mapping[str, Any], place: tuple[int, int], indices: tuple[int, int, int]
    ) -> None:
        """Write an episode's data to another place, with other indices."""
        from pyarrow import parquet

        table = parquet.read_table(self._data(_place(row, "data")))
        if table.num_rows != row["length"]:
            raise self._has_shared_files()
        for name, column in _index_columns(row["length"], indices).items():
            table = table.set_column(table.schema.get_field_index(name), name, column)
        write_table(self._data(place), table)

    def _has_shared_files(self) -> RefusedError:
        return RefusedError(
            f"{self.folder} has several episodes in a file, as lerobot writes them",
            hint="lerobot-edit-dataset changes it.",
        )

    def _write_rows(self) -> None:
        import pyarrow as pa

        names = list(dict.fromkeys(name for row in self._rows for name in row))
        kinds = {_SUCCESS: pa.bool_(), _HAND: pa.string(), _OFFSET: pa.float64()}
        table = pa.table(
            {
                name: pa.array([row.get(name) for row in self._rows], kinds.get(name))
                for name in names
            }
        )
        write_table(self.folder / _EPISODES, table)
        for file in (self.folder / "meta" / "episodes").glob("*/*.parquet"):
            if file != self.folder / _EPISODES:
                file.unlink()

    def _total_statistics(self) -> dict[str, Statistics]:
        found: dict[str, list[Statistics]] = {}
        for row in self._rows:
            of_row: dict[str, Statistics] = {}
            for name, value in row.items():
                if name.startswith("stats/"):
                    key, _, which = name.removeprefix("stats/").rpartition("/")
                    of_row.setdefault(key, {})[which] = np.asarray(value, np.float64)
            for key, statistics in of_row.items():
                found.setdefault(key, []).append(statistics)
        return {key: joined_statistics(each) for key, each in found.items()}


def _at(place: tuple[int, int]) -> str:
    return _PATTERN.format(chunk_index=place[0], file_index=place[1])


def _place(row: Mapping[str, Any], key: str) -> tuple[int, int]:
    return int(row[f"{key}/chunk_index"]), int(row[f"{key}/file_index"])


def _next(place: tuple[int, int]) -> tuple[int, int]:
    chunk, file = place
    return (chunk, file + 1) if file + 1 < _CHUNKS else (chunk + 1, 0)


def _add_statistics(row: dict[str, Any], key: str, found: Statistics) -> None:
    row.update((f"stats/{key}/{name}", value.tolist()) for name, value in found.items())


def _index_columns(length: int, indices: tuple[int, int, int]) -> dict[str, Any]:
    import pyarrow as pa

    episode, start, task = indices
    return {
        "episode_index": pa.array(np.full(length, episode, np.int64)),
        "index": pa.array(np.arange(start, start + length, dtype=np.int64)),
        "task_index": pa.array(np.full(length, task, np.int64)),
    }


def _features(episode: Episode) -> dict[str, Any]:
    features: dict[str, Any] = {}
    for key, values in episode.vectors.items():
        features[key] = {
            "dtype": "float32",
            "shape": [values.shape[1]],
            "names": list(episode.names[key]),
            "info": {"units": list(episode.units[key])},
        }
    for key, video in episode.videos.items():
        of_kind = INFORMATION if video.is_depth else _OF_COLOURS
        features[key] = {
            "dtype": "video",
            "shape": [video.height, video.width, of_kind["video.channels"]],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": video.height,
                "video.width": video.width,
                **of_kind,
                "video.fps": episode.fps,
                "has_audio": False,
            },
        }
    return features


def _information(episode: Episode, before: dict[str, Any] | None) -> dict[str, Any]:
    """Return the information of the data set, without the numbers that each episode changes."""
    if before is not None:
        return before
    features = _features(episode)
    for key, dtype in _INDICES.items():
        features[key] = {"dtype": dtype, "shape": [1], "names": None}
    return {
        "codebase_version": VERSION,
        "robot_type": episode.robot,
        "total_episodes": 0,
        "total_frames": 0,
        "total_tasks": 0,
        "chunks_size": _CHUNKS,
        "data_files_size_in_mb": _DATA_MB,
        "video_files_size_in_mb": _VIDEO_MB,
        "fps": episode.fps,
        "splits": {},
        "data_path": f"data/{_PATTERN}.parquet",
        "video_path": f"videos/{{video_key}}/{_PATTERN}.mp4" if episode.videos else None,
        "features": features,
    }
