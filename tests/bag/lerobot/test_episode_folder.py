"""Folders of episodes: bags that become a data set, are cut, dropped and put aside."""

from __future__ import annotations

import os
import shutil
import threading
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from pyarrow import parquet

from teleopctl.bag import (
    EPISODE_RECORD,
    BagWriter,
    EpisodeFolder,
    EpisodeSettings,
    find_actions,
    find_cameras,
    open_bag,
)
from teleopctl.bag.lerobot.depth import depths_of_numbers
from teleopctl.errors import (
    InvalidFileError,
    NotFoundError,
    RefusedError,
    SystemFailureError,
    UsageError,
)
from teleopctl.interfaces import get_message, serialize, set_stamp
from teleopctl.pictures import camera_name
from tests.bag.bags import START_NS, message, topic
from tests.bag.export.test_video import raw

KINDS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/arm/controller_state": "control_msgs/msg/JointTrajectoryControllerState",
    "/hand/commands": "std_msgs/msg/Float64MultiArray",
    "/front/image_raw": "sensor_msgs/msg/Image",
    "/depth/image_raw": "sensor_msgs/msg/Image",
    "/servo_node/delta_twist_cmds": "geometry_msgs/msg/TwistStamped",
}


def record(folder: EpisodeFolder, *messages: tuple[float, str, Any], **settings: Any) -> Path:
    """Record an episode as the recorder does; messages with times in seconds."""
    number = folder.next_number
    draft = folder.draft(number)
    with BagWriter(draft) as writer:
        for name, kind in KINDS.items():
            if any(name == each for _, each, _ in messages):
                writer.add_topic(topic(name, kind))
        for time_s, name, one in messages:
            time_ns = START_NS + round(time_s * 1e9)
            writer.write(message(name, 0)._replace(log_time_ns=time_ns, data=bytes(serialize(one))))
        writer.add_record(EPISODE_RECORD, EpisodeSettings(fps=10, **settings).record())
    return folder.keep(draft, number)


def state(value: float, stamp_s: float | None = None) -> Any:
    made: Any = get_message(KINDS["/joint_states"])(name=["a"], position=[value])
    if stamp_s is not None:
        set_stamp(made.header.stamp, START_NS + round(stamp_s * 1e9))
    return made


def reference(value: float) -> Any:
    made: Any = get_message(KINDS["/arm/controller_state"])(joint_names=["a"])
    made.reference.positions = [value]
    return made


def second(value: float) -> list[tuple[float, str, Any]]:
    """One second of a joint and its controller, from a value on."""
    return [
        (0.1 * step, name, make(value + step))
        for step in range(11)
        for name, make in (("/joint_states", state), ("/arm/controller_state", reference))
    ]


def values(folder: EpisodeFolder) -> list[list[float]]:
    """Joint positions of each episode, by the data set."""
    found: list[list[float]] = [[] for _ in folder.rows()]
    for file in sorted((folder.folder / "data").glob("*/*.parquet")):
        for row in parquet.read_table(file).to_pylist():
            found[row["episode_index"]].append(row["observation.state"])
    return found


@pytest.fixture
def folder(tmp_path):
    return EpisodeFolder(tmp_path / "cube")


def add(folder: EpisodeFolder) -> list[str]:
    return folder.add_missing(lambda *_: None)


def test_saved_episodes_become_a_data_set_and_say_who_drove(folder):
    record(folder, *second(0.0), task="push", success=True, driven_by="gamepad")
    record(folder, *second(50.0), task="push")
    assert folder.missing() == [0, 1]
    assert add(folder) == []
    assert folder.missing() == []
    first, other = folder.rows()
    assert (first.task, first.length) == ("push", 11)
    assert first.notes[:2] == (True, "gamepad")
    assert other.notes[:2] == (None, "")
    assert values(folder)[1] == [50.0 + step for step in range(11)]
    assert folder.dataset.features["action"]["names"] == ["a.pos"]


def test_an_episode_that_does_not_fit_is_put_aside_and_the_next_takes_its_place(folder):
    record(folder, *second(0.0))
    record(folder, (0.0, "/hand/commands", get_message(KINDS["/hand/commands"])(data=[1.0])))
    record(folder, *second(50.0))
    (sentence,) = add(folder)
    assert "no topic" in sentence or "none of the bag's topics" in sentence
    assert sentence.endswith("cube/episodes/rejected/episode_000001.mcap")
    assert [one[0] for one in values(folder)] == [0.0, 50.0]
    assert [path.name for path in folder.bags()] == ["episode_000000.mcap", "episode_000001.mcap"]


def test_a_dropped_episode_is_put_aside_with_its_bag_and_later_ones_move_up(folder):
    for value in (0.0, 50.0, 90.0):
        record(folder, *second(value))
    add(folder)
    (moved,) = folder.drop([1])
    assert moved.parts[-3:] == ("episodes", "dropped", "episode_000001.mcap")
    assert [one[0] for one in values(folder)] == [0.0, 90.0]
    with open_bag(folder.bag(1)) as bag:
        first = next(iter(bag.messages(["/joint_states"])))
    assert first.data == bytes(serialize(state(90.0)))
    assert EpisodeFolder(folder.folder).next_number == 2


def test_a_trimmed_episode_keeps_its_whole_bag_aside(folder):
    for value in (0.0, 50.0):
        record(folder, *second(value))
    add(folder)
    assert folder.trim(0, 0.25, 0.7).frames == 5
    assert values(folder)[0] == [3.0, 4.0, 5.0, 6.0, 7.0]
    assert values(folder)[1][0] == 50.0
    with open_bag(folder.folder / "episodes/dropped/episode_000000.mcap") as bag:
        assert bag.metadata.message_count == 22
    with pytest.raises(UsageError, match=r"The end, 0\.2 s, is not after the start, 0\.3 s"):
        folder.trim(0, 0.3, 0.2)


def test_values_are_taken_by_their_stamps_and_their_greatest_age_is_told(folder):
    late = [
        (0.1 * step + 0.08, "/joint_states", state(float(step), 0.1 * step)) for step in range(11)
    ]
    record(folder, *late)
    add(folder)
    assert values(folder) == [[float(step) for step in range(11)]]
    (row,) = folder.rows()
    assert row.notes.worst_offset_s == pytest.approx(0.0, abs=1e-6)


def test_a_hand_that_lets_go_is_a_standstill(folder):
    twist: Any = get_message(KINDS["/servo_node/delta_twist_cmds"])()
    twist.twist.linear.z = 0.5
    record(folder, *second(0.0), (0.21, "/servo_node/delta_twist_cmds", twist))
    add(folder)
    (file,) = (folder.folder / "data").glob("*/*.parquet")
    lifts = [row["hand"][2] for row in parquet.read_table(file).to_pylist()]
    assert lifts == [0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_commands_and_cameras_are_found_in_the_bag(folder):
    depth = raw("16UC1")
    images = {
        "/front/image_raw": raw(),
        "/front/image_raw/compressed": None,
        "/depth/image_raw": depth,
    }
    draft = folder.draft(0)
    with BagWriter(draft) as writer:
        for name, kind in KINDS.items():
            writer.add_topic(topic(name, kind))
        for name, one in images.items():
            if one is not None:
                writer.write(message(name, 0)._replace(data=bytes(serialize(one))))
        for name, one in (
            ("/arm/controller_state", reference(0.0)),
            ("/hand/commands", get_message(KINDS["/hand/commands"])(data=[1.0])),
        ):
            writer.write(message(name, 0)._replace(data=bytes(serialize(one))))
    with open_bag(draft) as bag:
        assert find_actions(bag) == ["/arm/controller_state", "/hand/commands"]
        assert find_cameras(bag) == {"depth": "/depth/image_raw", "front": "/front/image_raw"}


def test_depths_are_a_feature_of_their_own_in_metres(folder):
    metres = np.tile(np.array([0.0, 0.5, np.nan, 1.0, 2.0, 5.0, np.inf, 9.0], np.float32), (16, 2))
    depths = get_message(KINDS["/depth/image_raw"])(
        encoding="32FC1", width=16, height=16, step=64, data=metres.tobytes()
    )
    record(folder, *second(0.0), *((0.1 * n, "/depth/image_raw", depths) for n in range(11)))
    assert add(folder) == []
    feature = folder.dataset.features["observation.images.depth"]
    assert (feature["shape"], feature["info"]["depth_unit"]) == ([16, 16, 1], "m")
    (file,) = folder.folder.glob("videos/observation.images.depth/*/*.mp4")
    with av.open(str(file)) as video:
        frames = [frame.to_ndarray(format="gray12le") for frame in video.decode(video=0)]
    # As lerobot reads it: by the range in the information.
    assert len(frames) == 11
    seen = depths_of_numbers()[frames[-1]]
    assert seen == pytest.approx(np.where(np.isfinite(metres), metres, 0.0), abs=0.011)
    assert seen[0, 3] == pytest.approx(1.0, abs=1e-3)
    (row,) = folder.dataset.statistics["observation.images.depth"]["max"]
    assert row == [[pytest.approx(9.0, abs=3e-3)]]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("/image_raw", "camera"),
        ("/wrist_camera/color/image_raw/compressed", "wrist_camera"),
        ("/left/front/image_rect", "left_front"),
    ],
)
def test_a_camera_has_the_name_of_its_namespace(name, expected):
    assert camera_name(name) == expected


def test_a_folder_without_episodes_is_named(tmp_path):
    with pytest.raises(NotFoundError, match="has no episodes"):
        EpisodeFolder.existing(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(NotFoundError, match="file' is a file, not a folder with episodes"):
        EpisodeFolder.existing(tmp_path / "file")


def test_a_sensor_that_falls_silent_is_told(folder):
    last = max(time_s for time_s, _, _ in second(0.0))
    record(folder, *second(0.0), (last + 3.0, "/arm/controller_state", reference(0.0)))
    silent = []
    folder.add_missing(lambda _, summary: silent.append(summary.silent_s))
    assert silent == [{"observation.state": pytest.approx(3.0, abs=0.11)}]


@pytest.mark.parametrize("name", ["data", "videos", "meta"])
def test_a_folder_with_data_of_another_program_is_left_alone(folder, name):
    others = folder.folder / name / "chunk-000/file-000.parquet"
    others.parent.mkdir(parents=True)
    others.touch()
    with pytest.raises(RefusedError, match=f"{name} is of another program"):
        folder.begin_recording()
    # Bags beside it may be of a first episode whose writer was killed.
    mine = folder.folder / "data/train/mine.parquet"
    mine.parent.mkdir(parents=True)
    mine.touch()
    record(folder, *second(0.0))
    assert add(folder) == []
    assert mine.exists()


@pytest.mark.skipif(os.name == "nt", reason="locks of folders")
def test_a_folder_has_one_recorder_and_nothing_is_left_of_one_that_records_nothing(folder):
    folder.begin_recording()
    with pytest.raises(RefusedError, match="Another recorder records into"):
        EpisodeFolder(folder.folder).begin_recording()
    folder.end_recording()
    assert not folder.folder.exists()
    folder.folder.touch()
    with pytest.raises(SystemFailureError, match=r"Cannot record into .*cube: Not a directory"):
        folder.begin_recording()


@pytest.mark.skipif(os.name == "nt", reason="locks of folders")
def test_programs_change_a_data_set_one_after_the_other(folder):
    for value in (0.0, 50.0):
        record(folder, *second(value))
    add(folder)
    dropped = threading.Thread(target=EpisodeFolder(folder.folder).drop, args=[[0]])

    def begin_to_drop(*_: object) -> None:
        if not dropped.is_alive():
            dropped.start()

    for value in (60.0, 90.0):
        record(folder, *second(value))
    left = folder.folder / ".adding.killed"
    left.mkdir()
    folder.add_missing(begin_to_drop)
    dropped.join()
    found = EpisodeFolder(folder.folder)
    assert [one[0] for one in values(found)] == [50.0, 60.0, 90.0]
    assert [bag.name[-5 - 1 : -5] for bag in found.bags()] == ["0", "1", "2"]
    assert not left.exists()


def test_a_data_set_that_lacks_a_file_is_made_again_from_its_bags(folder):
    record(folder, *second(0.0))
    add(folder)
    (file,) = (folder.folder / "data").glob("*/*.parquet")
    file.unlink()
    with pytest.raises(InvalidFileError, match=r"lacks data/chunk-000/file-000\.parquet") as told:
        EpisodeFolder(folder.folder)
    assert "remove data, videos and meta there, then teleopctl episode build" in str(
        told.value.hint
    )
    for name in ("data", "meta"):
        shutil.rmtree(folder.folder / name)
    again = EpisodeFolder(folder.folder)
    assert add(again) == []
    assert [one[0] for one in values(again)] == [0.0]
