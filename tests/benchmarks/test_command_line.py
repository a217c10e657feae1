"""A graph query as a whole process, against a bare script that asks Zenoh the same.

Both run in turn in the same minute, with their bytecode cached as after any installation; the
ratio of the medians is what counts, and 2.5 is the aim.
"""

import statistics
import subprocess
import sys
import time

from teleopctl.testing import RosGraph

ROUNDS = 15

BARE = """
import os, zenoh
config = zenoh.Config.from_json5('''{
  mode: "client",
  connect: { endpoints: ["%s"] },
  scouting: { multicast: { enabled: false } },
}''' % os.environ["TELEOPCTL_ROUTER"])
with zenoh.open(config) as session:
    key = f"@ros2_lv/{os.environ['ROS_DOMAIN_ID']}/**"
    tokens = [str(reply.ok.key_expr) for reply in session.liveliness().get(key)]
"""


def process_time_s(argv: list[str], env: dict[str, str]) -> float:
    start = time.perf_counter()
    subprocess.run(argv, env=env, stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - start


def test_topic_list_against_a_bare_query(ros: RosGraph, tmp_path, capsys):
    ros.spawn("topic pub /chatter std_msgs/msg/String").wait_for_line("publishing #1")
    env = ros.env | {"PYTHONPYCACHEPREFIX": str(tmp_path), "PYTHONDONTWRITEBYTECODE": ""}
    bare, ours = [], []
    for _ in range(ROUNDS + 1):
        bare.append(process_time_s([sys.executable, "-c", BARE], env))
        ours.append(process_time_s([sys.executable, "-m", "teleopctl", "topic", "list"], env))
    # The first round of each writes the bytecode.
    bare_s, ours_s = statistics.median(bare[1:]), statistics.median(ours[1:])
    with capsys.disabled():
        print(
            f"\ntopic list {ours_s * 1e3:.1f} ms, bare query {bare_s * 1e3:.1f} ms, "
            f"ratio {ours_s / bare_s:.2f}"
        )
