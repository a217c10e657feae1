"""The recorder of episodes beside lerobot's own recording, of the same pictures at the same time.

``python -m tests.lerobot_recording PYTHON [--seconds 60]`` needs the Python of an environment that
has lerobot. Two cameras of 640 x 480 at 30 Hz and the joints of an arm are published; one episode
is recorded by `episode_recorder`, and the same pictures go through ``LeRobotDataset.add_frame`` and
``save_episode``, as lerobot's programs do it. Both end with a data set. It prints processor time,
memory and lost frames; the exit status is 1 if ours takes more than 1.2 times as much, or loses
one.
"""

from __future__ import annotations

import argparse
import io
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import psutil
from PIL import Image

from teleopctl.bag import EpisodeFolder, check, open_bag
from teleopctl.interfaces import get_message, get_service
from teleopctl.node import Node, open_node
from tests.faults.isolation import own_graph

CAMERAS, JOINTS = ("left", "right"), ["joint_1", "joint_2", "joint_3", "joint_4"]
WIDTH, HEIGHT, RATE_HZ, JOINTS_HZ = 640, 480, 30, 100
MOST = 1.2
LEROBOT = """
import sys, time
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
seconds, pictures, root = float(sys.argv[1]), np.load(sys.argv[2]), sys.argv[3]
joints = {"dtype": "float32", "shape": (4,), "names": [f"joint_{n}.pos" for n in (1, 2, 3, 4)]}
picture = {"dtype": "video", "shape": pictures[0].shape, "names": ["height", "width", "channels"]}
cameras = ["observation.images.left", "observation.images.right"]
features = {"observation.state": joints, "action": joints, **dict.fromkeys(cameras, picture)}
data = LeRobotDataset.create(
    "local/set", fps=30, root=root, features=features, image_writer_threads=4 * len(cameras)
)
print("ready", flush=True)
sys.stdin.readline()
begun, late = time.perf_counter(), 0
for number in range(round(seconds * 30)):
    state = np.full(4, 0.001 * number, np.float32)
    images = dict.fromkeys(cameras, pictures[number % len(pictures)])
    data.add_frame({"observation.state": state, "action": state, "task": "wave", **images})
    left = begun + (number + 1) / 30 - time.perf_counter()
    late += left < 0
    time.sleep(max(0.0, left))
data.save_episode()
if hasattr(data, "finalize"):
    data.finalize()
print(late, flush=True)
"""


def pictures() -> list[np.ndarray]:
    """Return the pictures of a second: smooth colours, a moving square, and a camera's noise."""
    random = np.random.default_rng(0)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    smooth = np.stack([x * 255 / WIDTH, y * 255 / HEIGHT, (x + y) * 255 / (WIDTH + HEIGHT)], -1)
    found = []
    for number in range(RATE_HZ):
        picture = smooth + random.normal(0.0, 2.0, smooth.shape)
        picture[200:280, 10 * number : 10 * number + 80] = (200, 30, 30)
        found.append(picture.clip(0, 255).astype(np.uint8))
    return found


class Robot:
    """What publishes: two cameras, joint states, and the state of a controller."""

    def __init__(self, node: Node, images: list[np.ndarray]) -> None:
        self._node = node
        image = get_message("sensor_msgs/msg/CompressedImage")
        self._image = [
            image(format="rgb8; jpeg compressed bgr8", data=_jpeg(one)) for one in images
        ]
        self._cameras = [
            node.create_publisher(image, f"/{name}/image_raw/compressed", 10) for name in CAMERAS
        ]
        self._state = get_message("sensor_msgs/msg/JointState")(name=JOINTS, position=[0.0] * 4)
        self._states = node.create_publisher(type(self._state), "/joint_states", 10)
        kind = get_message("control_msgs/msg/JointTrajectoryControllerState")
        self._reference = kind(joint_names=JOINTS)
        self._references = node.create_publisher(kind, "/arm_controller/controller_state", 10)
        self.ended = threading.Event()
        for rate_hz, publish in (
            (RATE_HZ, self._publish_images),
            (JOINTS_HZ, self._publish_joints),
        ):
            threading.Thread(target=self._run, args=[rate_hz, publish], daemon=True).start()

    def _run(self, rate_hz, publish) -> None:
        begun, number = time.perf_counter(), 0
        while not self.ended.is_set():
            publish(number)
            number += 1
            time.sleep(max(0.0, begun + number / rate_hz - time.perf_counter()))

    def _publish_images(self, number: int) -> None:
        image = self._image[number % len(self._image)]
        image.header.stamp = self._node.get_clock().now().to_msg()
        for camera in self._cameras:
            camera.publish(image)

    def _publish_joints(self, number: int) -> None:
        stamp = self._node.get_clock().now().to_msg()
        positions = [0.001 * number] * 4
        self._state.header.stamp = self._reference.header.stamp = stamp
        self._state.position = self._reference.reference.positions = positions
        self._states.publish(self._state)
        self._references.publish(self._reference)


def _jpeg(picture: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "JPEG", quality=95)
    return file.getvalue()


class Watched:
    """A process whose memory is looked at while it runs, and whose processor time afterwards."""

    def __init__(self, words: list[str]) -> None:
        self.process = subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.memory_mb: list[float] = []

    def look(self) -> None:
        """Note the memory of the process alone."""
        self.memory_mb.append(psutil.Process(self.process.pid).memory_info().rss * 1e-6)

    def end(self) -> float:
        """Wait for the end; return the processor time with that of its children, s."""
        _, _, usage = os.wait4(self.process.pid, 0)
        return usage.ru_utime + usage.ru_stime

    def texts(self) -> str:
        """Return the memory in thirds of the time."""
        third = max(1, len(self.memory_mb) // 3)
        first, last = self.memory_mb[third : 2 * third], self.memory_mb[-third:]
        return f"memory {np.mean(first):.0f} MB, then {np.mean(last):.0f} MB"


def main() -> None:
    """Record with both, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("python", help="a Python that has lerobot")
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    images = pictures()
    with tempfile.TemporaryDirectory() as name, own_graph(), open_node("peer") as node:
        folder = Path(name)
        np.save(folder / "pictures.npy", np.stack(images))
        robot = Robot(node, images)
        words = "-m teleopctl run episode_recorder episode_recorder --ros-args -p task:=wave"
        settings = ["-p", f"folder:={folder}/ours", "-p", "episodes:=1"]
        ours = Watched([sys.executable, *words.split(), *settings])
        script = [str(options.seconds), str(folder / "pictures.npy"), str(folder / "theirs")]
        theirs = Watched([options.python, "-c", LEROBOT, *script])
        trigger = get_service("std_srvs/srv/Trigger")
        clients = {
            step: node.create_client(trigger, f"/episode_recorder/{step}")
            for step in ("start", "save")
        }
        clients["save"].wait_for_service(60.0)
        assert theirs.process.stdout is not None and theirs.process.stdin is not None
        assert theirs.process.stdout.readline().strip() == "ready"
        started = clients["start"].call(trigger.Request(), 60.0)
        assert started is not None and started.success, started
        theirs.process.stdin.write("\n")
        theirs.process.stdin.flush()
        end_s = time.monotonic() + options.seconds
        while time.monotonic() < end_s:
            time.sleep(1.0)
            ours.look()
            theirs.look()
        saved = clients["save"].call(trigger.Request(), 60.0)
        assert saved is not None and saved.success, saved
        robot.ended.set()
        ours_s = ours.end()
        late = theirs.process.stdout.readline().strip()
        theirs_s = theirs.end()
        (bag,) = folder.glob("ours/episodes/*.mcap")
        faults = [fault.what for fault in check(bag)]
        with open_bag(bag) as opened:
            counts = {topic.name: count for topic, count in opened.metadata.topics}
        frames = [counts[f"/{camera}/image_raw/compressed"] for camera in CAMERAS]
        rows = EpisodeFolder(folder / "ours").rows()
        print(
            f"{options.seconds:g} s; ours {ours_s:.1f} s of processor time ({ours.texts()}), "
            f"lerobot {theirs_s:.1f} s ({theirs.texts()}): ratio {ours_s / theirs_s:.2f}\n"
            f"ours: {frames} pictures, {rows[0].length} frames, worst offset "
            f"{1e3 * rows[0].notes.worst_offset_s:.0f} ms, lost: {faults or 'none'}; "
            f"lerobot: {late} frames late",
            flush=True,
        )
    sys.exit(1 if faults or ours_s > MOST * theirs_s else 0)


if __name__ == "__main__":
    main()
