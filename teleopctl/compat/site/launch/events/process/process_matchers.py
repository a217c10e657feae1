"""``launch.events.process.process_matchers``."""

from collections.abc import Callable
from typing import Any

# Any: an action that started a process, of which there are several kinds.
_Matcher = Callable[[Any], bool]


def matches_pid(pid: int) -> _Matcher:
    """Return a function that tells whether an action started the process of that id."""
    return lambda action: (action.process_details or {}).get("pid") == pid


def matches_name(name: str) -> _Matcher:
    """Return a function that tells whether an action started the process of that name."""
    return lambda action: (action.process_details or {}).get("name") == name


def matches_executable(executable: str) -> _Matcher:
    """Return a function that tells whether an action started a program whose path ends so."""
    return lambda action: (action.process_details or {}).get("cmd", [""])[0].endswith(executable)
