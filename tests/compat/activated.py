"""Functions that run code in a separate process, which can import ROS 2's packages."""

import os
import subprocess
import sys
from pathlib import Path

HEAD = "import teleopctl\nteleopctl.activate()\n"


def run(code: str, *path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", HEAD + code],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path)), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def output(code: str, *path: Path, **environment: str) -> str:
    done = run(code, *path, **environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()
