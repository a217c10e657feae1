"""Episodes of a program and of a hand, loaded by lerobot and compared with their bags.

``python -m tests.lerobot_episodes PYTHON [--count 20] [--hand 5] [--folder FOLDER]`` needs the
Python of an environment that has lerobot (``pip install 'lerobot[dataset]' .``). The launch file
``pick_and_place.yaml`` records the first episodes, an emulated gamepad the others, into one data
set; its buttons begin and save them. lerobot's `LeRobotDataset` loads all, and each frame's state
and action must be, bit by bit, the newest message of its bag. The exit status is 1 if something is
not as it should be.
"""

from __future__ import annotations

import argparse
import bisect
import json
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from teleopctl.bag import Decoder, EpisodeFolder, open_bag
from teleopctl.interfaces import get_message, to_nanoseconds
from teleopctl.node import Node, open_node, qos_profile_latched
from tests.emulated_gamepad import EmulatedGamepad
from tests.faults.isolation import own_graph
from tests.lerobot_programs import Programs

LOAD = """
import json, sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("local/set", root=sys.argv[1], video_backend="pyav")
rows = [data.hf_dataset[number] for number in range(len(data.hf_dataset))]
pictures = [key for key in data.features if key.startswith("observation.images.")]
print(json.dumps({
    "episodes": data.num_episodes,
    "names": [data.features[key]["names"] for key in ("observation.state", "action", "stamps")],
    "rows": [
        [int(row["episode_index"]),
         *(row[key].tolist() for key in ("observation.state", "action", "stamps"))]
        for row in rows
    ],
    "pictures": {key: list(data[len(rows) // 2][key].shape) for key in pictures},
}))
"""
SIZE = (160, 90)
# Buttons and axes of the emulated pad: its left bumper enables, its left stick moves.
ENABLE, START, SUCCESS, SAVE, AXES = 4, 7, 3, 0, (0, 1)
LENGTH_S = 4.0
# Difference of times as the data set has them, single-precision seconds, ns.
ROUNDING_NS = (-2_000, 2_000)
STATE, REFERENCE = "/joint_states", "reference.positions"


def main() -> None:
    """Record, load and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("python", help="a Python that has lerobot and teleopctl")
    parser.add_argument("--count", type=int, default=20, help="episodes of pick_and_place")
    parser.add_argument("--hand", type=int, default=5, help="episodes of the gamepad")
    parser.add_argument("--folder", type=Path, help="folder of the data set, which is kept")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, own_graph():
        folder = options.folder or Path(name) / "set"
        programs = Programs(options.python, Path(name))
        before = len(EpisodeFolder(folder).rows())
        if options.count:
            _record_program(folder, options.count)
        if options.hand:
            _record_hand(folder, options.hand, Path(name))
        wanted = before + options.count + options.hand
        _compare(programs, folder, wanted)
    sys.exit(1 if programs.failures else 0)


# --- recording ------------------------------------------------------------------------------------


def _launch(*words: str) -> list[str]:
    width, height = SIZE
    return [*words, "viewer:=false", f"camera_width:={width}", f"camera_height:={height}"]


def _record_program(folder: Path, count: int) -> None:
    words = _launch("launch", "-d", "pick_and_place.yaml", f"episodes:={folder}", f"times:={count}")
    with open_node("watcher") as node:
        states = RecorderStates(node)
        _teleopctl(*words)
        states.wait(lambda state: state["saved"] >= count, 120.0 * count)
        states.wait(lambda state: state["in_data_set"] >= count, 120.0)
    _teleopctl("stop", "--all")


def _record_hand(folder: Path, count: int, place: Path) -> None:
    world = "world:=package://teleopctl/worlds/pick_and_place.yaml"
    pad = EmulatedGamepad(place / "js0")
    _teleopctl(*_launch("launch", "-d", "sim.yaml", world))
    _teleopctl("launch", "-d", "servo.yaml")
    settings = f"-p folder:={folder} -p reset:=true -p seed:=1 -p use_sim_time:=true"
    task = ["-p", "task:=Put the cube into the bin"]
    with open_node("watcher") as node:
        states = RecorderStates(node)
        _teleopctl("run", "-d", "episode_recorder", "--ros-args", *settings.split(), *task)
        device = ["teleop_device", "--ros-args", "-p", "device:=gamepad", "-p", f"dev:={pad.path}"]
        _teleopctl("run", "-d", *device)
        for number in range(count):
            _press(pad, START)
            states.wait(lambda state: state["doing"] == "recording", 60.0)
            pad.button(ENABLE, is_down=True)
            for axis, value in zip(AXES, (0.7 * (-1) ** number, -0.4), strict=True):
                pad.axis(axis, value)
            threading.Event().wait(LENGTH_S)  # the length of the episode
            for axis in AXES:
                pad.axis(axis, 0.0)
            pad.button(ENABLE, is_down=False)
            _press(pad, SUCCESS if number % 2 else SAVE)
            states.wait(lambda state, wanted=number + 1: state["saved"] >= wanted, 60.0)
        _teleopctl("stop", "episode_recorder")  # waits for the data set
    _teleopctl("stop", "--all")


def _press(pad: EmulatedGamepad, button: int) -> None:
    for is_down in (True, False):
        pad.button(button, is_down=is_down)


def _teleopctl(*words: str) -> None:
    command = [sys.executable, "-m", "teleopctl", *words]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit(f"{' '.join(words)}: {done.stdout}{done.stderr}")


class RecorderStates:
    """Newest state of the recorder, with waiting for a change."""

    def __init__(self, node: Node) -> None:
        self._changed = threading.Condition()
        self._last: dict[str, Any] = {}
        kind = get_message("diagnostic_msgs/msg/DiagnosticStatus")
        node.create_subscription(kind, "/episode_recorder/state", self._take, qos_profile_latched)

    def _take(self, message: Any) -> None:
        values = {each.key: each.value for each in message.values}
        with self._changed:
            self._last = {"doing": message.message, "failure": values["failure"]}
            self._last |= {key: int(values[key]) for key in ("saved", "in_data_set")}
            self._changed.notify_all()

    # Any: a condition of a state.
    def wait(self, condition: Any, longest_s: float) -> None:
        """Wait until a condition is true; end the program if it is not within a time in seconds."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._last and condition(self._last), longest_s):
                raise SystemExit(f"The recorder is not so far: {self._last}")


# --- comparing ------------------------------------------------------------------------------------


def _compare(programs: Programs, folder: Path, wanted: int) -> None:
    loaded = json.loads(programs.run("lerobot loads the data set", "-c", LOAD, str(folder)) or "{}")
    count = loaded.get("episodes")
    programs.check(f"it has {wanted} episodes", count == wanted, count)
    width, height = SIZE
    programs.check(
        "it has the pictures",
        loaded.get("pictures") == {"observation.images.camera": [3, height, width]},
        loaded.get("pictures"),
    )
    frames = 0
    for row in EpisodeFolder(folder).rows():
        own = [rest for episode, *rest in loaded.get("rows", []) if episode == row.number]
        wrong = _differences(EpisodeFolder(folder).bag(row.number), own, *loaded["names"])
        frames += len(own)
        by = f" by {row.notes.driven_by}" if row.notes.driven_by else ""
        is_right = not wrong and len(own) == row.length
        programs.check(f"episode {row.number}{by}: {len(own)} frames", is_right, wrong[:3])
    print(f"{frames} frames compared", flush=True)


class Series:
    """Messages of a topic: the times at which they count, in ns, and the values of the joints."""

    def __init__(self, bag: Any, topic: str) -> None:
        rows = sorted(_values(bag, topic), key=lambda row: row[0])
        # Of several with one time, the last one counts.
        self.times = [time_ns for time_ns, _ in rows]
        self.values = [values for _, values in rows]

    def newest(self, now_ns: float, name: str) -> np.float32:
        """Return the newest value of a joint at a time."""
        place = bisect.bisect_right(self.times, now_ns) - 1
        return np.float32(self.values[max(place, 0)].get(name, np.nan))


def _values(bag: Any, topic: str) -> Iterator[tuple[int, dict[str, float]]]:
    for each in Decoder(bag, [topic]).messages():
        message = each.message
        stamp_ns = to_nanoseconds(message.header.stamp)
        names = message.name if topic == STATE else message.joint_names
        values = message.position if topic == STATE else message.reference.positions
        yield min(stamp_ns, each.log_time_ns), dict(zip(names, values, strict=True))


def _differences(
    path: Path,
    frames: list[Any],
    state_names: list[str],
    action_names: list[str],
    stamp_names: list[str],
) -> list[str]:
    """Return what is not the newest message of a bag at the time of its frame."""
    with open_bag(path) as bag:
        state = Series(bag, STATE)
        topics = [topic.name for topic, _ in bag.metadata.topics]
        commands = [Series(bag, name) for name in topics if name.endswith("/controller_state")]
    if not frames:
        return ["no frames"]
    by_joint = {name: each for each in commands for name in each.values[0]}
    place = stamp_names.index("observation.state")
    # The first frame's time, from the age of its state, which is one of the bag's messages.
    starts = [
        time_ns - frames[0][2][place] * 1e9
        for time_ns, values in zip(state.times, state.values, strict=True)
        if _same(values, frames[0][0], state_names)
    ]
    reasons: list[list[str]] = []
    for start_ns in starts:
        reasons.append(wrong := [])
        for number, (states, actions, _) in enumerate(frames):
            now_ns = start_ns + number * 1e9 / 30
            for names, values, of in (
                (state_names, states, dict.fromkeys(_joints(state_names), state)),
                (action_names, actions, by_joint),
            ):
                for name, value in zip(_joints(names), values, strict=True):
                    found = {of[name].newest(now_ns + by_ns, name) for by_ns in ROUNDING_NS}
                    if np.float32(value) not in found:
                        wrong.append(f"frame {number}, {name}: {value}, not {found}")
        if not wrong:
            return []
    return min(reasons, key=len, default=["the first state is not in the bag"])


def _joints(names: list[str]) -> list[str]:
    return [name.rpartition(".")[0] for name in names]


def _same(values: dict[str, float], frame: list[float], names: list[str]) -> bool:
    pairs = zip(_joints(names), frame, strict=True)
    return all(np.float32(values[name]) == np.float32(value) for name, value in pairs)


if __name__ == "__main__":
    main()
