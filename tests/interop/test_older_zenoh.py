"""A peer of Zenoh 1.7, whose protocol is that of the 1.8 in rmw_zenoh: 1.8 has no wheels."""

import importlib.metadata
import subprocess
import sys

import pytest

from teleopctl.testing import eventually
from tests import ROOT

VERSION = "1.7.2"


@pytest.fixture(scope="session")
def older_zenoh(tmp_path_factory):
    """The folder of an older zenoh-python; where none can be had, the tests are skipped."""
    folder = tmp_path_factory.mktemp("zenoh")
    command = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--only-binary=:all:",
    ]
    done = subprocess.run(
        [*command, "--target", str(folder), f"eclipse-zenoh=={VERSION}"],
        capture_output=True,
        text=True,
        timeout=100,
    )
    if done.returncode:
        pytest.skip(f"Zenoh {VERSION} cannot be had: {done.stderr.strip().splitlines()[-1]}")
    found = importlib.metadata.distributions(path=[str(folder)])
    assert [each.version for each in found] == [VERSION]
    return folder


def test_a_node_that_was_there_before_the_router_is_seen_by_commands(
    ros_without_router, older_zenoh
):
    ros = ros_without_router
    ros.env["PYTHONPATH"] = str(older_zenoh)
    peer = ros.spawn_module("tests.interop.old_peer", [str(ros.port), str(ros.domain)], cwd=ROOT)
    del ros.env["PYTHONPATH"]
    peer.wait_for_line("up")
    ros.start_router()
    eventually(lambda: ros.run("node list").stdout == "/old_node\n")
