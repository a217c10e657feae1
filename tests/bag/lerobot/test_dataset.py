"""Data sets of LeRobot that grow, lose episodes, and outlive a writer that was killed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyarrow import parquet

from teleopctl.bag import EpisodeNotes, LeRobotDataset
from teleopctl.bag.lerobot import files as module
from teleopctl.bag.lerobot.dataset import Episode, Video
from teleopctl.bag.lerobot.statistics import PictureStatistics, feature_statistics
from teleopctl.errors import InvalidFileError, NotFoundError, RefusedError

CAMERA = "observation.images.front"


def episode(length: int, value: float = 0.0, **changes: Any) -> Episode:
    """An episode of two joints, whose first one counts the frames from a value on."""
    state = np.stack([value + np.arange(length), np.full(length, value)], axis=1)
    shades = PictureStatistics()
    shades.add(np.full((4, 4, 3), round(abs(value)), np.uint8))
    made = Episode(
        vectors={"observation.state": state},
        names={"observation.state": ("a.pos", "b.pos")},
        units={"observation.state": ("rad", "m")},
        videos={CAMERA: Video(4, 4)},
        pictures={CAMERA: shades.result()},
        fps=10,
        task="wave",
        robot=None,
    )
    return made._replace(**changes)


def add(folder: Path, one: Episode, notes: EpisodeNotes | None = None, **options: Any) -> int:
    film = folder / "film.mp4"
    folder.mkdir(exist_ok=True)
    film.write_bytes(f"film of {one.vectors['observation.state'][0][0]:g}".encode())
    return LeRobotDataset(folder).add(one, {CAMERA: film}, notes, **options)


def frames(folder: Path) -> list[dict[str, Any]]:
    """All frames in the order in which LeRobot reads the files."""
    files = sorted((folder / "data").glob("*/*.parquet"))
    return [row for file in files for row in parquet.read_table(file).to_pylist()]


def films(folder: Path) -> list[str]:
    """The film of each episode, found as LeRobot finds it."""
    rows = parquet.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    pattern = json.loads((folder / "meta/info.json").read_text())["video_path"]
    return [
        (
            folder
            / pattern.format(
                video_key=CAMERA,
                chunk_index=row[f"videos/{CAMERA}/chunk_index"],
                file_index=row[f"videos/{CAMERA}/file_index"],
            )
        ).read_text()
        for row in rows
    ]


def assert_whole(folder: Path, values: list[float]) -> None:
    """The data set has the episodes that begin with these values, numbered without a gap."""
    data = LeRobotDataset(folder)
    rows = frames(folder)
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert info["total_episodes"] == len(data.episodes) == len(values)
    assert info["total_frames"] == len(rows) == sum(one.length for one in data.episodes)
    assert info["splits"] == {"train": f"0:{len(values)}"}
    assert [row["index"] for row in rows] == list(range(len(rows)))
    begins = [row for row in rows if row["frame_index"] == 0]
    assert [row["episode_index"] for row in begins] == list(range(len(values)))
    assert [row["observation.state"][0] for row in begins] == values
    assert films(folder) == [f"film of {value:g}" for value in values]
    assert len(list(folder.glob("videos/*/*/*.mp4"))) == len(values)


def test_an_episode_is_added_without_writing_the_others_again(tmp_path):
    add(tmp_path, episode(3, 1.0))
    first = (tmp_path / "data/chunk-000/file-000.parquet").stat()
    assert add(tmp_path, episode(2, 5.0), EpisodeNotes(True, "gamepad", 0.02)) == 1
    assert (tmp_path / "data/chunk-000/file-000.parquet").stat() == first
    assert_whole(tmp_path, [1.0, 5.0])
    *_, last = LeRobotDataset(tmp_path).episodes
    assert (last.length, last.task, last.notes) == (2, "wave", EpisodeNotes(True, "gamepad", 0.02))


def test_statistics_are_those_of_all_frames(tmp_path):
    parts = [episode(3, 1.0), episode(5, 7.0), episode(2, -4.0)]
    for one in parts:
        add(tmp_path, one)
    found = json.loads((tmp_path / "meta/stats.json").read_text())["observation.state"]
    values = np.concatenate([one.vectors["observation.state"] for one in parts])
    for name, value in feature_statistics(values).items():
        if not name.startswith("q"):
            assert found[name] == pytest.approx(value.tolist())


def test_a_removed_episode_leaves_no_gap(tmp_path):
    for value in (1.0, 5.0, 9.0):
        add(tmp_path, episode(2, value))
    LeRobotDataset(tmp_path).remove([1])
    assert_whole(tmp_path, [1.0, 9.0])
    add(tmp_path, episode(4, 20.0))
    assert_whole(tmp_path, [1.0, 9.0, 20.0])


@pytest.mark.parametrize("index", [1, 2])
def test_of_several_episodes_in_a_file_none_is_removed(tmp_path, index):
    for value in (1.0, 5.0, 9.0):
        add(tmp_path, episode(2, value))
    theirs = LeRobotDataset(tmp_path)
    theirs._rows[2]["data/file_index"] = theirs._rows[1]["data/file_index"]
    with pytest.raises(RefusedError, match="has several episodes in a file, as lerobot writes"):
        theirs.remove([index])
    assert_whole(tmp_path, [1.0, 5.0, 9.0])


def test_an_episode_takes_the_place_of_another(tmp_path):
    for value in (1.0, 5.0, 9.0):
        add(tmp_path, episode(2, value))
    add(tmp_path, episode(1, 6.0), index=1)
    assert_whole(tmp_path, [1.0, 6.0, 9.0])


def test_tasks_keep_their_numbers(tmp_path):
    for task in ("wave", "apple", "wave"):
        add(tmp_path, episode(1, task=task))
    assert [row["task_index"] for row in frames(tmp_path)] == [0, 1, 0]
    tasks = parquet.read_table(tmp_path / "meta/tasks.parquet").to_pylist()
    assert [row["__index_level_0__"] for row in tasks] == ["wave", "apple"]


@pytest.mark.parametrize("written", range(1, 7))
def test_a_writer_killed_while_it_adds_leaves_all_episodes_before(tmp_path, monkeypatch, written):
    add(tmp_path, episode(2, 1.0))
    put, count = module._put, 0

    def put_or_die(draft: Path, file: Path) -> None:
        nonlocal count
        count += 1
        if count == written:
            raise KeyboardInterrupt
        put(draft, file)

    monkeypatch.setattr(module, "_put", put_or_die)
    try:
        add(tmp_path, episode(3, 5.0))
    except KeyboardInterrupt:
        assert [one.length for one in LeRobotDataset(tmp_path).episodes] == [2]
        monkeypatch.setattr(module, "_put", put)
        add(tmp_path, episode(3, 5.0))
    assert_whole(tmp_path, [1.0, 5.0])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"fps": 20}, "has 10 frames a second, not 20"),
        ({"robot": "ur5"}, "is of the robot 'so101', not 'ur5'"),
        ({"videos": {}, "pictures": {}}, f"has {CAMERA}, which the episode lacks"),
        ({"videos": {CAMERA: Video(8, 4)}}, "of the size 4 x 4 x 3, not 4 x 8 x 3"),
        (
            {"names": {"observation.state": ("a.pos", "c.pos")}},
            "observation.state with a.pos, b.pos, not a.pos, c.pos",
        ),
    ],
)
def test_an_episode_of_another_kind_is_refused_with_the_difference(tmp_path, changes, text):
    add(tmp_path, episode(1, robot="so101"))
    with pytest.raises(RefusedError, match=text):
        add(tmp_path, episode(1, **{"robot": "so101", **changes}))


def test_what_is_no_data_set_of_this_version_is_named(tmp_path):
    add(tmp_path, episode(1))
    file = tmp_path / "meta" / "info.json"
    file.write_text(file.read_text().replace("v3.0", "v2.1"))
    with pytest.raises(InvalidFileError, match=r"a LeRobot data set v2\.1, not v3\.0"):
        LeRobotDataset(tmp_path)
    file.write_text("{")
    with pytest.raises(InvalidFileError, match="is no LeRobot data set"):
        LeRobotDataset(tmp_path)


def test_the_last_episode_stays_and_a_missing_one_is_named(tmp_path):
    add(tmp_path, episode(1))
    with pytest.raises(NotFoundError, match="has no episode 1"):
        LeRobotDataset(tmp_path).remove([1])
    with pytest.raises(RefusedError, match="No episode would remain"):
        LeRobotDataset(tmp_path).remove([0])
