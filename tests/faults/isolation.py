"""A graph of its own for a campaign: nothing of the user's is met or touched."""

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
    """Set the environment to folders, a port and a domain of their own; yields the router's.

    A router runs there meanwhile, and all that was started in the background ends with it.
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
    """Run a command and wait for it; what it says goes to this program's output."""
    subprocess.run([sys.executable, "-m", "teleopctl", *words], check=False, timeout=60)
