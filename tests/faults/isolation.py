"""Isolated ROS graph for a campaign, separate from the user's nodes and files."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from teleopctl.testing import free_port

_DOMAIN = "230"


@contextlib.contextmanager
def own_graph() -> Iterator[str]:
    """Set environment variables to a separate graph and folders; yield the router's endpoint.

    The router runs during the ``with`` block. At its end all background processes are stopped.
    """
    with tempfile.TemporaryDirectory(prefix="teleopctl-faults-") as folder:
        for name in ("HOME", "TELEOPCTL_RUNTIME_DIR", "ROS_LOG_DIR"):
            path = Path(folder, name.lower())
            path.mkdir(mode=0o700)
            os.environ[name] = str(path)
        router = os.environ["TELEOPCTL_ROUTER"] = f"tcp/127.0.0.1:{free_port()}"
        os.environ["ROS_DOMAIN_ID"] = _DOMAIN
        teleopctl("daemon", "start")
        try:
            yield router
        finally:
            teleopctl("stop", "--all")
            teleopctl("daemon", "stop")


def teleopctl(*words: str) -> None:
    """Run a teleopctl command to its end; its output goes to this program's output."""
    subprocess.run([sys.executable, "-m", "teleopctl", *words], check=False, timeout=60)
