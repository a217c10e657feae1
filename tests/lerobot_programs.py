"""lerobot's own programs with a simulated robot of ours, and its loader with a data set of ours.

``python -m tests.lerobot_programs PYTHON`` needs the Python of an environment that has lerobot and
teleopctl (``pip install 'lerobot[dataset]' .``); lerobot needs torch, so no other test has it.

A leader arm is published, ``lerobot-teleoperate`` follows it, ``lerobot-record`` records it,
``lerobot-replay`` repeats it, a scripted policy drives the robot through lerobot's robot, and a
data set of `episode_recorder` is compared with its bags, frame by frame. The exit status is 1 if
something is not as it should be.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from teleopctl.interfaces import get_message, get_service
from teleopctl.node import open_node
from tests.faults.isolation import own_graph

LEADER = {"joint_1": 0.4, "joint_2": -0.3, "joint_3": 0.5, "joint_4": -0.5}
OURS = "--{0}.discover_packages_path=teleopctl.lerobot --{0}.type=teleopctl"
POLICY = """
import json, sys, time
import torch
from teleopctl.lerobot import TeleopctlRobot, TeleopctlRobotConfig
try:
    from lerobot.utils.feature_utils import build_dataset_frame, hw_to_dataset_features
except ImportError:  # lerobot 0.4
    from lerobot.datasets.utils import build_dataset_frame, hw_to_dataset_features
from lerobot.policies.utils import make_robot_action
with_features = TeleopctlRobot(TeleopctlRobotConfig())
with_features.connect()
features = {
    **hw_to_dataset_features(with_features.observation_features, "observation"),
    **hw_to_dataset_features(with_features.action_features, "action"),
}
goal = torch.tensor([-0.2, 0.1, -0.1, -0.3])
for _ in range(150):
    frame = build_dataset_frame(features, with_features.get_observation(), "observation")
    state = torch.from_numpy(frame["observation.state"])[:4]
    action = state + torch.clamp(goal - state, -0.05, 0.05)
    with_features.send_action(make_robot_action(action.unsqueeze(0), features))
    time.sleep(1 / 30)
at = with_features.get_observation()
# As lerobot-rollout at its end: also joints that no controller moves.
with_features.send_action({name: value for name, value in at.items() if name.endswith(".pos")})
with_features.disconnect()
print(json.dumps([at[f"joint_{n}.pos"] for n in (1, 2, 3, 4)]))
"""
LOAD = """
import json, sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("local/set", root=sys.argv[1], video_backend="pyav")
rows = [data.hf_dataset[number] for number in range(len(data.hf_dataset))]
print(json.dumps({
    "episodes": data.num_episodes,
    "rows": [[int(r["episode_index"]), *r["observation.state"].tolist()] for r in rows],
    "pictures": [list(data[number]["observation.images.front"].shape) for number in (0, -1)],
}))
"""


class Programs:
    """Programs of lerobot in another environment, with the checks of what they did."""

    def __init__(self, python: str, folder: Path) -> None:
        self._python, self._folder = python, folder
        root = str(Path(__file__).parents[1])
        self._env = {**os.environ, "PYTHONPATH": root, "HF_HUB_OFFLINE": "1"}
        self._env["HF_LEROBOT_HOME"] = str(folder / "home")
        self.failures = 0

    def run(self, name: str, *words: str) -> str:
        """Run a program; return its output."""
        done = subprocess.run(
            [self._python, *words],
            env=self._env,
            capture_output=True,
            text=True,
            timeout=180,
            check=False,
        )
        self.check(name, done.returncode == 0, done.stderr[-2000:])
        return done.stdout

    def check(self, name: str, is_right: bool, reason: object = "") -> None:
        """Print whether something is right."""
        self.failures += not is_right
        print(
            f"{'ok  ' if is_right else 'FAIL'} {name}{'' if is_right else f': {reason}'}",
            flush=True,
        )

    def script(self, program: str) -> list[str]:
        """Return the arguments that start one of lerobot's programs."""
        return ["-m", f"lerobot.scripts.{program}"]


def main() -> None:
    """Run all checks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("python", help="a Python that has lerobot and teleopctl")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, own_graph():
        programs = Programs(options.python, Path(name))
        _drive(programs, Path(name))
    sys.exit(1 if programs.failures else 0)


def _ours(*words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "teleopctl", *words], capture_output=True, text=True, check=False
    )
    return done.stdout


def _drive(programs: Programs, folder: Path) -> None:
    _ours("launch", "sim.yaml", "-d", "camera:=false", "viewer:=false")
    ended = threading.Event()
    state = get_message("sensor_msgs/msg/JointState")
    image = get_message("sensor_msgs/msg/Image")(
        encoding="rgb8", width=32, height=32, step=96, data=bytes(3072)
    )
    try:
        with open_node("peers") as node:
            leader = node.create_publisher(state, "/leader/joint_states", 1)
            camera = node.create_publisher(image.__class__, "/front/image_raw", 1)

            def publish() -> None:
                while not ended.wait(0.02):
                    leader.publish(state(name=list(LEADER), position=list(LEADER.values())))
                    image.header.stamp = node.get_clock().now().to_msg()
                    camera.publish(image)

            thread = threading.Thread(target=publish)
            thread.start()
            try:
                _programs_of_lerobot(programs, folder)
                _data_set_of_ours(programs, node, folder)
            finally:
                ended.set()
                thread.join()
    finally:
        _ours("stop", "--all")


def _is_at(wanted: list[float]) -> bool:
    text = _ours("topic", "echo", "--once", "--json", "/joint_states")
    message = json.loads(text)
    at = dict(zip(message["name"], message["position"], strict=True))
    return all(abs(at[f"joint_{n + 1}"] - value) < 0.02 for n, value in enumerate(wanted))


def _programs_of_lerobot(programs: Programs, folder: Path) -> None:
    robot, teleop = OURS.format("robot").split(), OURS.format("teleop").split()
    wanted = list(LEADER.values())
    programs.run(
        "lerobot-teleoperate",
        *programs.script("lerobot_teleoperate"), *robot, *teleop, "--teleop_time_s=3",
    )  # fmt: skip
    programs.check("the follower is where its leader is", _is_at(wanted))
    data = f"--dataset.root={folder / 'theirs'}"
    recorded = "--dataset.num_episodes=2 --dataset.episode_time_s=2 --dataset.reset_time_s=0"
    programs.run(
        "lerobot-record",
        *programs.script("lerobot_record"), *robot, *teleop, data, "--dataset.repo_id=local/theirs",
        "--dataset.single_task=wave", *recorded.split(), "--dataset.push_to_hub=false",
        "--play_sounds=false",
    )  # fmt: skip
    at = json.loads(programs.run("a scripted policy", "-c", POLICY) or "[]")
    goal = [-0.2, 0.1, -0.1, -0.3]
    near = len(at) == len(goal) and all(abs(a - b) < 0.05 for a, b in zip(at, goal, strict=True))
    programs.check("the policy's robot is at its goal", near, at)
    programs.run(
        "lerobot-replay",
        *programs.script("lerobot_replay"), *robot, data, "--dataset.repo_id=local/theirs",
        "--dataset.episode=1", "--play_sounds=false",
    )  # fmt: skip
    programs.check("the replayed robot is where it was", _is_at(wanted))


def _data_set_of_ours(programs: Programs, node: object, folder: Path) -> None:
    from teleopctl.bag import Decoder, EpisodeFolder, open_bag
    from teleopctl.node import Node

    assert isinstance(node, Node)
    where = folder / "ours"
    settings = f"-p folder:={where} -p task:=wave -p fps:=10"
    words = ["run", "-d", "episode_recorder", "--ros-args", *settings.split()]
    _ours(*words)
    trigger = get_service("std_srvs/srv/Trigger")
    for number in range(2):
        for step in ("start", "save"):
            client = node.create_client(trigger, f"/episode_recorder/{step}")
            client.wait_for_service(30.0)
            answer = client.call(trigger.Request(), 60.0)
            programs.check(f"{step} episode {number}", bool(answer and answer.success), answer)
            if step == "start":
                threading.Event().wait(2.0)  # the length of the episode
    _ours("stop", "episode_recorder")
    loaded = json.loads(programs.run("lerobot loads our data set", "-c", LOAD, str(where)) or "{}")
    rows = loaded.get("rows", [])
    programs.check("it has both episodes", loaded.get("episodes") == 2, loaded.get("episodes"))
    programs.check("it has pictures", loaded.get("pictures") == [[3, 32, 32]] * 2)
    for row in EpisodeFolder(where).rows():
        ours = [values for episode, *values in rows if episode == row.number]
        with open_bag(where / "episodes" / f"episode_{row.number:06d}.mcap") as bag:
            states = [
                [round(value, 5) for value in each.message.position]
                for each in Decoder(bag, ["/joint_states"]).messages()
            ]
        same = all([round(v, 5) for v in values] in states for values in ours)
        programs.check(f"each state of episode {row.number} is one of its bag", same and bool(ours))


if __name__ == "__main__":
    main()
