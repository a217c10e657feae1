"""Recorders of episodes that are killed at random moments: every saved episode opens.

``python -m tests.faults.episodes [--count 20] [--lerobot PYTHON]`` records short episodes of a
simulated arm and kills the recorder at a random time, also while it saves and while the data set
grows. After each kill all saved bags and the data set must be whole; at the end lerobot loads it
if the Python of an environment with lerobot is named. The exit status is 1 if one is not.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from teleopctl.bag import EpisodeFolder, check, open_bag
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import get_service
from teleopctl.node import open_node
from tests.faults.isolation import own_graph

LOAD = """
import sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("local/set", root=sys.argv[1])
frames = sum(1 for number in range(len(data)) if data[number]["action"].isfinite().all())
print(data.num_episodes, frames, len(data))
"""
TELEOPCTL = [sys.executable, "-m", "teleopctl"]


def main() -> None:
    """Kill recorders; print what is left after each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20, help="recorders to kill")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--lerobot", metavar="PYTHON", help="a Python that has lerobot")
    options = parser.parse_args()
    source = random.Random(options.seed)
    wrong = 0
    with tempfile.TemporaryDirectory() as name, own_graph():
        folder = Path(name) / "set"
        launch = [*TELEOPCTL, "launch", "sim.yaml", "-d", "camera:=false", "viewer:=false"]
        subprocess.run(launch, check=True, stdout=subprocess.DEVNULL)
        try:
            for number in range(1, options.count + 1):
                saved = _record_and_kill(folder, source.uniform(0.2, 4.0))
                problem = _problem(folder, saved)
                wrong += bool(problem)
                count = len(list(folder.glob("episodes/*.mcap")))
                print(f"{number}: {count} bags{f', {problem}' if problem else ''}", flush=True)
            if options.lerobot:
                wrong += _cannot_be_loaded(options.lerobot, folder)
        finally:
            subprocess.run([*TELEOPCTL, "stop", "--all"], check=False, stdout=subprocess.DEVNULL)
    sys.exit(1 if wrong else 0)


def _record_and_kill(folder: Path, after_s: float) -> list[Path]:
    """Record episodes of 0.5 s each; return the bags whose saving was confirmed before the kill."""
    settings = f"-p folder:={folder} -p task:=wave -p fps:=10"
    words = [*TELEOPCTL, "run", "episode_recorder", "episode_recorder", "--ros-args"]
    with open_node("peer") as node:
        recorder = subprocess.Popen(
            [*words, *settings.split()],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        kind = get_service("std_srvs/srv/Trigger")
        clients = {
            step: node.create_client(kind, f"/episode_recorder/{step}")
            for step in ("start", "save")
        }
        clients["save"].wait_for_service(30.0)
        end_s = time.monotonic() + after_s
        while (left_s := end_s - time.monotonic()) > 0.0:
            for step, pause_s in (("start", 0.5), ("save", 0.0)):
                clients[step].call(kind.Request(), max(0.01, end_s - time.monotonic()))
                time.sleep(min(pause_s, max(0.0, left_s)))
        saved = sorted(folder.glob("episodes/episode_*.mcap"))
        recorder.kill()
        recorder.wait()
    return saved


def _problem(folder: Path, saved: list[Path]) -> str:
    """Return what is wrong with the saved episodes; empty if nothing is."""
    try:
        for bag in saved:
            faults = list(check(bag))
            if faults:
                return f"{bag.name}: {faults[0].what}"
        found = EpisodeFolder(folder)
        for left in found.unfinished():
            with open_bag(left) as opened:
                list(opened.messages())
        rejected = found.add_missing(lambda *_: None)
        rows = EpisodeFolder(folder).rows()
    except TeleopctlError as error:
        return error.message
    if rejected or len(rows) != len(list(folder.glob("episodes/episode_*.mcap"))):
        return f"{len(rows)} of {len(saved)} in the data set: {rejected}"
    return ""


def _cannot_be_loaded(python: str, folder: Path) -> bool:
    """Load all frames of the data set by lerobot; print and return whether one is missing."""
    command = [python, "-c", LOAD, str(folder)]
    environment = {**os.environ, "HF_HUB_OFFLINE": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    found = EpisodeFolder(folder)
    frames = sum(row.length for row in found.rows())
    is_whole = done.stdout.split() == [str(len(found.rows())), str(frames), str(frames)]
    print(f"lerobot: {done.stdout.strip() or done.stderr[-500:]}", flush=True)
    return not is_whole


if __name__ == "__main__":
    main()
