"""``launch.events.process.process_matchers``."""

from collections.abc import Callable
from typing import Any

# Any: an action that started a process, of which there are several kinds.
_Matcher = Callable[[Any], bool]


def matches_pid(pid: int) -> _Matcher:
    """Return a matcher of the action whose process has an id."""
    return lambda action: (action.process_details or {}).get("pid") == pid


def matches_name(name: str) -> _Matcher:
    """Return a matcher of actions whose process has a name."""
    return lambda action: (action.process_details or {}).get("name") == name


def matches_executable(executable: str) -> _Matcher:
    """Return a matcher of actions whose program's path has an ending."""
    return lambda action: (action.process_details or {}).get("cmd", [""])[0].endswith(executable)
