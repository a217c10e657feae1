"""Waiting for a node's parameter services, by the event of their arrival in the graph."""

from teleopctl.testing import LONGEST_WAIT_S, RosGraph


def wait_for_parameters(ros: RosGraph, node: str) -> None:
    """Return once a node of this environment offers its parameters."""
    service = f"{node}/list_parameters"
    done = ros.run(["service", "call", service, "rcl_interfaces/srv/ListParameters"])
    assert done.returncode == 0, f"{node} did not come within {LONGEST_WAIT_S} s: {done.stderr}"
