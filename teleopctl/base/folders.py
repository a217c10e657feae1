"""Folders of the user: process records, logs, persistent state and cache.

The records determine which processes are signalled and which files are shown, so their folder must
belong to the user: never a folder below ``/tmp`` that another user could have created first.
"""

from __future__ import annotations

import os
import stat
import sys

from teleopctl.base.typed import TYPE_CHECKING
from teleopctl.errors import SystemFailureError

# The import of each of them takes half as long as a command of the command line.
if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

_HINT = "Set TELEOPCTL_RUNTIME_DIR to a folder of your own."


def runtime_dir(env: Mapping[str, str] = os.environ) -> Path:
    """Return the user's runtime folder of teleopctl, which contains the process records.

    ``TELEOPCTL_RUNTIME_DIR`` overrides the default. On Linux the default is below
    ``XDG_RUNTIME_DIR`` or ``/run/user/UID``, the first that belongs to the user and is closed to
    others; without such a folder, as in containers, the user's state folder.
    """
    from pathlib import Path

    chosen = env.get("TELEOPCTL_RUNTIME_DIR")
    if chosen:
        return Path(chosen)
    if sys.platform == "linux":
        for place in (env.get("XDG_RUNTIME_DIR"), f"/run/user/{os.getuid()}"):
            if place and _is_private(Path(place)):
                return Path(place) / "teleopctl"
        return state_dir(env)
    from platformdirs import user_runtime_path

    return user_runtime_path("teleopctl")


def logs_dir(env: Mapping[str, str] = os.environ) -> Path:
    """Return the log folder: ``ROS_LOG_DIR``, ``ROS_HOME/log`` or ``~/.ros/log``."""
    from pathlib import Path

    chosen = env.get("ROS_LOG_DIR")
    if chosen:
        return Path(chosen).expanduser()
    home = env.get("ROS_HOME")
    return (Path(home).expanduser() if home else Path.home() / ".ros") / "log"


def state_dir(env: Mapping[str, str] = os.environ) -> Path:
    """Return the user's folder of teleopctl's persistent state, such as tokens."""
    from pathlib import Path

    if sys.platform == "linux":
        chosen = env.get("XDG_STATE_HOME")
        return (Path(chosen) if chosen else Path.home() / ".local" / "state") / "teleopctl"
    from platformdirs import user_state_path

    return user_state_path("teleopctl", appauthor=False)


def cache_dir(env: Mapping[str, str] = os.environ) -> str:
    """Return the path of teleopctl's cache folder of the user, as a string."""
    if sys.platform == "linux":  # as platformdirs, without its slow import
        base, home = env.get("XDG_CACHE_HOME", ""), env.get("HOME", "")
        if base.startswith("/"):
            return f"{base.rstrip('/')}/teleopctl"
        if home.startswith("/"):
            return f"{home.rstrip('/')}/.cache/teleopctl"
    import platformdirs

    return platformdirs.user_cache_dir("teleopctl", appauthor=False)


def make_private(folder: Path) -> None:
    """Create a folder and missing parents, or check an existing one; set its mode to 0700.

    Raises:
        OSError: The folder cannot be created.
        SystemFailureError: `check_private` refuses the folder.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    check_private(folder)
    if sys.platform != "win32":
        folder.chmod(0o700)


def check_private(folder: Path) -> None:
    """Raise a SystemFailureError if a folder is another user's, or its parent is, unless root's.

    Raises:
        SystemFailureError: The folder or its parent belongs to another user, or it is no folder.
    """
    if sys.platform == "win32" or not os.path.lexists(folder):
        return
    own, above = folder.lstat(), folder.parent.stat()
    if not stat.S_ISDIR(own.st_mode) or own.st_uid != os.getuid():
        raise SystemFailureError(f"{folder} is not a folder of your own", hint=_HINT)
    if above.st_uid not in (os.getuid(), 0):
        raise SystemFailureError(f"{folder.parent} belongs to another user", hint=_HINT)


def _is_private(folder: Path) -> bool:
    """Whether a folder is the user's and closed to all others."""
    if sys.platform == "win32":
        return True
    try:
        found = folder.stat()
    except OSError:
        return False
    own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    return own and stat.S_IMODE(found.st_mode) & 0o077 == 0
