"""Sessions as data sets of LeRobot.

The form was checked by loading such data sets with lerobot 0.4.4, which is too heavy for the tests.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from pyarrow import parquet

from teleopctl.bag import (
    BagWriter,
    EpisodeNotes,
    LeRobotOptions,
    LeRobotSummary,
    export_lerobot,
    open_bag,
)
from teleopctl.bag.lerobot.statistics import PictureStatistics, feature_statistics
from teleopctl.errors import (
    InvalidFileError,
    NotFoundError,
    RefusedError,
    UsageError,
)
from teleopctl.interfaces import get_message, serialize
from tests.bag.bags import START_NS, message, topic
from tests.bag.export.test_video import BLUE, RED, raw

JOINT_STATE = "sensor_msgs/msg/JointState"
STATE = "control_msgs/msg/JointTrajectoryControllerState"
IMAGE = "sensor_msgs/msg/Image"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
ARRAY = "std_msgs/msg/Float64MultiArray"
FILE = "chunk-000/file-000"

TOPICS = {
    "/joint_states": JOINT_STATE,
    "/controller_state": STATE,
    "/joint_trajectory": TRAJECTORY,
    "/commands": ARRAY,
    "/cam/image_raw": IMAGE,
}


def joints(**positions: float) -> Any:
    return get_message(JOINT_STATE)(name=list(positions), position=list(positions.values()))


def write(folder: Path, *messages: tuple[float, str, Any]) -> Path:
    """A bag of messages, each with its time in seconds and its topic."""
    with BagWriter(folder / "bag") as writer:
        for name, type_name in TOPICS.items():
            writer.add_topic(topic(name, type_name))
        for time_s, name, one in messages:
            data = bytes(serialize(one)) if one is not None else b""
            time_ns = START_NS + round(time_s * 1e9)
            writer.write(message(name, 0)._replace(log_time_ns=time_ns, data=data))
    return folder / "bag"


def export(bag: Path, folder: Path, **options: Any) -> LeRobotSummary:
    with open_bag(bag) as opened:
        given = LeRobotOptions(**{"state": "/joint_states", **options})
        (summary,) = export_lerobot([opened], folder, lambda _: (given, EpisodeNotes()))
        return summary


def rows(folder: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = parquet.read_table(
        folder / "data" / f"{FILE}.parquet"
    ).to_pylist()
    return found


def info(folder: Path) -> Any:
    return json.loads((folder / "meta" / "info.json").read_text(encoding="utf-8"))


@pytest.fixture
def session(tmp_path):
    def reference(value: float) -> Any:
        made = get_message(STATE)(joint_names=["a", "b"])
        made.reference.positions = [value, -value]
        return made

    return write(
        tmp_path,
        (0.00, "/joint_states", joints(a=0.0, b=1.0)),
        (0.02, "/controller_state", reference(0.5)),
        (0.05, "/cam/image_raw", raw()),  # from here on all are there
        (0.10, "/joint_states", joints(b=2.0, a=0.25)),
        (0.15, "/joint_states", joints(a=0.5)),
        (0.20, "/controller_state", reference(0.75)),
        (0.25, "/cam/image_raw", raw(colour=BLUE)),
        (0.30, "/joint_states", joints(a=1.0, b=3.0)),
    )


def test_each_frame_has_the_latest_message_that_is_not_younger(session, tmp_path):
    summary = export(
        session,
        tmp_path / "set",
        action=["/controller_state"],
        cameras=["/cam/image_raw"],
        fps=10,
        task="wave",
    )
    joined = ("a.pos", "b.pos")
    assert summary.names == {"observation.state": joined, "action": joined}
    assert (summary.frames, summary.left_out) == (3, {})
    # The state of 0.10 s is that of the frame at 0.15 s, which has an image of 0.05 s.
    assert (summary.by_stamps, summary.worst_feature) == (False, "action")
    assert summary.worst_offset_s == pytest.approx(0.13)
    found = rows(tmp_path / "set")
    assert [row["observation.state"] for row in found] == [[0.0, 1.0], [0.5, 2.0], [0.5, 2.0]]
    assert [row["action"] for row in found] == [[0.5, -0.5], [0.5, -0.5], [0.75, -0.75]]
    assert [row["timestamp"] for row in found] == pytest.approx([0.0, 0.1, 0.2])
    assert [row["frame_index"] for row in found] == [row["index"] for row in found] == [0, 1, 2]
    assert {(row["episode_index"], row["task_index"]) for row in found} == {(0, 0)}
    film = tmp_path / "set" / "videos" / "observation.images.cam" / f"{FILE}.mp4"
    with av.open(str(film)) as file:
        stream = file.streams.video[0]
        frames = list(file.decode(stream))
        # By which LeRobot finds a frame.
        assert stream.average_rate == 10
    colours = [frame.to_ndarray(format="rgb24")[24, 32] for frame in frames]
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.1, 0.2])
    assert np.abs(np.subtract(colours, [RED, RED, BLUE])).max() <= 12


def test_the_files_say_what_is_in_them(session, tmp_path):
    folder = tmp_path / "set"
    export(session, folder, cameras=["/cam/image_raw"], fps=10, task="wave", robot="so101")
    said = info(folder)
    assert said["codebase_version"] == "v3.0"
    assert (said["fps"], said["robot_type"]) == (10, "so101")
    assert (said["total_episodes"], said["total_frames"], said["total_tasks"]) == (1, 3, 1)
    state = said["features"]["observation.state"]
    assert (state["dtype"], state["shape"], state["names"]) == ("float32", [2], ["a.pos", "b.pos"])
    assert state["info"] == {"units": ["rad", "rad"]}
    camera = said["features"]["observation.images.cam"]
    assert (camera["dtype"], camera["shape"]) == ("video", [48, 64, 3])
    assert set(said["features"]) - {"observation.images.cam"} == set(rows(folder)[0])
    (episode,) = parquet.read_table(folder / "meta/episodes" / f"{FILE}.parquet").to_pylist()
    assert (episode["length"], episode["tasks"]) == (3, ["wave"])
    assert (episode["dataset_from_index"], episode["dataset_to_index"]) == (0, 3)
    assert episode["videos/observation.images.cam/to_timestamp"] == pytest.approx(0.3)
    stats = json.loads((folder / "meta" / "stats.json").read_text(encoding="utf-8"))
    assert stats["observation.state"]["max"] == [0.5, 2.0]
    assert episode["stats/observation.state/max"] == [0.5, 2.0]
    assert np.shape(stats["observation.images.cam"]["mean"]) == (3, 1, 1)
    tasks = parquet.read_table(folder / "meta" / "tasks.parquet")
    assert tasks.to_pylist() == [{"task_index": 0, "__index_level_0__": "wave"}]
    assert b'"index_columns": ["__index_level_0__"]' in tasks.schema.metadata[b"pandas"]


def test_actions_may_be_trajectories_arrays_or_any_field(tmp_path):
    point = get_message("trajectory_msgs/msg/JointTrajectoryPoint")
    bag = write(
        tmp_path,
        (0.0, "/joint_states", joints(a=0.0, b=1.0)),
        (
            0.0,
            "/joint_trajectory",
            get_message(TRAJECTORY)(
                joint_names=["b"], points=[point(positions=[7.0]), point(positions=[8.0])]
            ),
        ),
        (0.0, "/commands", get_message(ARRAY)(data=[1.0, 2.0, 3.0])),
        (0.1, "/joint_states", joints(a=0.0, b=1.0)),
    )
    expected = {
        "/joint_trajectory": (("b.pos",), 8.0),
        "/joint_trajectory/points[0]/positions": (("b.pos",), 7.0),
        "/commands": (("0", "1", "2"), [1.0, 2.0, 3.0]),
        "/joint_states/position": (("a.pos", "b.pos"), [0.0, 1.0]),
    }
    for number, (action, (names, values)) in enumerate(expected.items()):
        summary = export(bag, tmp_path / str(number), action=[action])
        assert summary.names["action"] == names
        assert rows(tmp_path / str(number))[0]["action"] == values


def test_what_cannot_be_used_is_counted_and_passed_over(tmp_path):
    bag = write(
        tmp_path,
        (0.0, "/joint_states", joints()),
        (0.0, "/joint_states", None),
        (0.0, "/joint_states", joints(a=1.0)),
        (0.0, "/commands", get_message(ARRAY)(data=[1.0])),
        (0.1, "/commands", get_message(ARRAY)(data=[1.0, 2.0])),
        (0.1, "/cam/image_raw", raw()),
        (0.2, "/cam/image_raw", raw(size=(32, 32))),
        (0.3, "/cam/image_raw", raw("no_such_encoding")),
    )
    summary = export(
        bag, tmp_path / "set", action=["/commands"], cameras=["/cam/image_raw"], fps=10
    )
    assert summary.frames == 3
    assert summary.left_out == {"/joint_states": 1, "/commands": 1, "/cam/image_raw": 2}


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"action": ["/commands"]}, NotFoundError, "no message of /commands"),
        ({"action": ["/comands"]}, NotFoundError, "begins with none of the bag's topics"),
        ({"state": "/cam/image_raw"}, UsageError, "name one of its fields"),
        ({"cameras": ["/joint_states"]}, UsageError, "has no pictures"),
        ({"cameras": ["/camera"]}, NotFoundError, "no topic '/camera'"),
        ({"state": "/joint_states/name"}, NotFoundError, "no message of /joint_states"),
        ({"fps": 0}, UsageError, "not a frame rate"),
    ],
)
def test_what_is_missing_is_named(session, tmp_path, options, error, text):
    with pytest.raises(error, match=text):
        export(session, tmp_path / "set", **options)


def test_nothing_is_written_over(session, tmp_path):
    export(session, tmp_path / "set")
    with pytest.raises(RefusedError, match="already exists"):
        export(session, tmp_path / "set")


def test_a_clock_that_was_set_does_not_fill_the_disk_with_one_state(tmp_path):
    bag = write(
        tmp_path, (0.0, "/joint_states", joints(a=1.0)), (1e6, "/joint_states", joints(a=1.0))
    )
    with pytest.raises(InvalidFileError, match="too many for an episode"):
        export(bag, tmp_path / "set")


def test_statistics_of_pictures_are_those_of_their_pixels():
    source = np.random.default_rng(7)
    pictures = source.integers(0, 256, (3, 20, 30, 3), dtype=np.uint8)
    pictures[..., 2] //= 4
    counted = PictureStatistics()
    for picture in pictures:
        counted.add(picture)
    found = counted.result()
    expected = feature_statistics(pictures.reshape(-1, 3) / 255.0)
    assert found.pop("count").tolist() == [3]
    for name, values in found.items():
        # A quantile between two shades is the lower one or between them.
        tolerance = 1.5 / 255 if name.startswith("q") else 1e-9
        assert values.shape == (3, 1, 1)
        assert values.ravel() == pytest.approx(expected[name], abs=tolerance)
