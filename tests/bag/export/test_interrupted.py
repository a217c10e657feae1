"""Exports that do not come to their end leave nothing that looks like one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from teleopctl.bag import (
    Bag,
    BagMessage,
    BagWriter,
    EpisodeNotes,
    LeRobotOptions,
    TableExport,
    VideoExport,
    export_lerobot,
    open_bag,
)
from tests.bag.bags import message, topic

STATES, PICTURES = "/joint_states", "/image_raw"
TYPES = {STATES: "sensor_msgs/msg/JointState", PICTURES: "sensor_msgs/msg/Image"}
FIELDS: dict[str, dict[str, Any]] = {
    STATES: {"name": ["a"], "position": [1.0]},
    PICTURES: {"encoding": "mono8", "width": 8, "height": 8, "step": 8, "data": bytes(64)},
}


@pytest.fixture
def bag(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        for name, type_name in TYPES.items():
            writer.add_topic(topic(name, type_name))
        for number in range(400):
            for name, type_name in TYPES.items():
                writer.write(message(name, number, type_name, **FIELDS[name]))
    with open_bag(tmp_path / "bag") as opened:
        yield opened


EXPORTS: dict[str, Callable[[Bag, Path], object]] = {
    "csv": lambda bag, folder: list(TableExport(bag, folder, [STATES], "csv").write()),
    "parquet": lambda bag, folder: list(TableExport(bag, folder, [STATES], "parquet").write()),
    "mp4": lambda bag, folder: list(VideoExport(bag, folder, [PICTURES]).write()),
    "lerobot": lambda bag, folder: export_lerobot(
        [bag], folder, lambda _: (LeRobotOptions(STATES, cameras=[PICTURES]), EpisodeNotes())
    ),
}


@pytest.mark.parametrize("form", EXPORTS)
def test_after_ctrl_c_nothing_of_an_export_is_left_and_it_may_be_done_again(
    bag: Bag,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    form: str,
) -> None:
    export = EXPORTS[form]
    messages = bag.messages
    passes: list[int] = []

    def interrupted(*words: Any, **named: Any) -> Iterator[BagMessage]:
        for number, each in enumerate(messages(*words, **named)):
            # CSV has to know its columns first, and reads a bag of lists twice.
            if number == 200 and (form != "csv" or passes):
                raise KeyboardInterrupt
            yield each
        passes.append(1)

    with monkeypatch.context() as patched:
        patched.setattr(bag, "messages", interrupted)
        with pytest.raises(KeyboardInterrupt):
            export(bag, tmp_path / "out")
    assert list(tmp_path.glob("out/**/*")) == []
    export(bag, tmp_path / "out")
    assert any(path.is_file() for path in tmp_path.glob("out/**/*"))
