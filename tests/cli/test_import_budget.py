"""The command line must not load what only a few verbs need."""

import json
import subprocess
import sys

import pytest

from tests.bag.bags import write_bag

HEAVY = {
    *("numpy", "rosbags", "mujoco", "rich", "typer", "yaml", "psutil", "xacro", "lxml", "pydantic"),
    *("asyncio", "inspect", "dataclasses", "argparse", "logging"),
}

PROBE = """
import json, sys
from teleopctl.cli import console, main
console.error = lambda failure: None
status = main.run({words!r})
print("\\n" + json.dumps([status, sorted({{name.partition(".")[0] for name in sys.modules}})]))
"""


def loaded_after(words: list[str], env: dict[str, str]) -> tuple[int, set[str]]:
    done = subprocess.run(
        [sys.executable, "-c", PROBE.format(words=words)],
        env=env,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    status, modules = json.loads(done.stdout.splitlines()[-1])
    return status, set(modules)


@pytest.mark.parametrize(
    "line",
    ["topic list", "topic list -t --json", "topic info /chatter", "node list", "service list"],
)
def test_a_graph_query_loads_no_heavy_module(line, ros):
    _, modules = loaded_after(line.split(), ros.env)
    assert not modules & HEAVY


def test_help_in_a_pipe_loads_no_rich_and_no_verb(ros):
    status, modules = loaded_after(["--help"], ros.env)
    assert status == 0
    assert not modules & {"rich", "numpy", "zenoh", "yaml"}


@pytest.mark.parametrize("line", ["bag --help", "bag list storage"])
def test_what_reads_no_bag_loads_nothing_that_does(line, ros_without_router):
    status, modules = loaded_after(line.split(), ros_without_router.env)
    assert status == 0
    assert not modules & {"numpy", "rosbags", "yaml", "mcap", "zstandard", "lz4", "zenoh", "rich"}


def test_a_table_of_csv_loads_no_library_of_other_formats(tmp_path, ros_without_router):
    write_bag(tmp_path / "session")
    line = ["bag", "export", str(tmp_path / "session"), "-o", str(tmp_path / "tables")]
    status, modules = loaded_after(line, ros_without_router.env)
    assert status == 0
    assert not modules & {"numpy", "pyarrow", "av", "matplotlib", "PIL"}
