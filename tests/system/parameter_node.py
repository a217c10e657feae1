"""Helper that waits for a node's parameter services by graph events."""

from teleopctl.testing import LONGEST_WAIT_S, RosGraph


def wait_for_parameters(ros: RosGraph, node: str) -> None:
    """Wait until a node of the test's graph has parameter services."""
    service = f"{node}/list_parameters"
    done = ros.run(["service", "call", service, "rcl_interfaces/srv/ListParameters"])
    assert done.returncode == 0, f"{node} did not come within {LONGEST_WAIT_S} s: {done.stderr}"
