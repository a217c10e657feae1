"""Executable ``foxglove_bridge``: the ROS graph for Foxglove, by the official SDK's server.

Messages are forwarded undecoded, as CDR with ROS message definitions. Names and parameters are
those of ROS 2's foxglove_bridge, except that this bridge listens on loopback by default.
"""

from __future__ import annotations

import contextlib

from teleopctl.base.extras import extra
from teleopctl.node import ExternalShutdownException, init, spin


def main(args: list[str] | None = None) -> int:
    """Run the node ``foxglove_bridge`` until Ctrl-C, and return the exit status.

    Args:
        args: Command line; None takes ``sys.argv``.

    Raises:
        MissingExtraError: The Foxglove SDK is not installed.
        TeleopctlError: A parameter is wrong, or the bridge cannot listen on its address.
    """
    with extra("foxglove", "foxglove"):
        import foxglove as foxglove
    from teleopctl.nodes.foxglove_bridge.bridge import FoxgloveBridge

    with (
        contextlib.suppress(KeyboardInterrupt, ExternalShutdownException),
        init(args=args),
        FoxgloveBridge() as node,
    ):
        spin(node)
    return 0
