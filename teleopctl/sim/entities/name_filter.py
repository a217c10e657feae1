"""Filter of entity names by a client's regular expression, with a time limit.

Python's regular expressions take exponentially long for some patterns (``(a+)+$``), and block all
threads during that time. So all but the simplest patterns are matched by a separate process, which
is ended when it takes too long.
"""

from __future__ import annotations

import json
import re
import string
import subprocess
import sys
import threading
from collections.abc import Sequence

from teleopctl.base.printable import shortened
from teleopctl.errors import InvalidMessageError
from teleopctl.node import Future

# Time limit in seconds of wall time: Python itself starts in 0.02 to 0.1 s, and on a busy machine
# in some seconds.
_LONGEST_S = 2.0
_LONGEST_PATTERN = 10_000
# A pattern with at most _FEW of these operators and _SHORT characters takes at most the cube of a
# name's length.
_BRANCHING = re.compile(r"[*+?{|(]")
_FEW = 2
_SHORT = 200

# Character classes of POSIX regular expressions, which Python's do not have.
_POSIX_CLASSES = {
    "alnum": "a-zA-Z0-9",
    "alpha": "a-zA-Z",
    "blank": " \\t",
    "digit": "0-9",
    "lower": "a-z",
    "punct": re.escape(string.punctuation),
    "space": r"\s",
    "upper": "A-Z",
    "xdigit": "0-9a-fA-F",
}
_POSIX_CLASS = re.compile(rf"\[:({'|'.join(_POSIX_CLASSES)}):\]")

_PROGRAM = """
import json, re, sys
pattern, names = json.load(sys.stdin)
try:
    found = re.compile(pattern)
    print(json.dumps([name for name in names if found.search(name)]))
except (re.error, OverflowError, RecursionError) as error:
    print(json.dumps(str(error)))
"""


async def matching_names(
    pattern: str, names: Sequence[str], longest_s: float = _LONGEST_S
) -> list[str]:
    """Return the names in which a regular expression finds a match; raise if invalid or too slow.

    Args:
        pattern: Python regular expression, which may contain POSIX character classes.
        names: Names to match.
        longest_s: Time limit, in seconds of wall time.

    Raises:
        InvalidMessageError: The pattern is not a regular expression, or takes too long.
    """
    python = _POSIX_CLASS.sub(lambda m: _POSIX_CLASSES[m[1]], pattern)
    if len(python) <= _SHORT and len(_BRANCHING.findall(python)) <= _FEW:
        try:
            found = re.compile(python)
        except (re.error, OverflowError) as error:
            raise _mistake(pattern, str(error)) from error
        return [name for name in names if found.search(name)]
    if len(python) > _LONGEST_PATTERN:
        raise _mistake(pattern, f"it has more than {_LONGEST_PATTERN} characters")
    answered: Future[list[str] | str] = Future()
    asking = threading.Thread(
        target=lambda: answered.set_result(_asked(python, names, longest_s)),
        name="filter",
        daemon=True,
    )
    asking.start()
    answer = await answered
    if isinstance(answer, list):
        return answer
    raise _mistake(pattern, answer or "")


def _asked(pattern: str, names: Sequence[str], longest_s: float) -> list[str] | str:
    """Return the names that a separate process finds, or its error message."""
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-S", "-c", _PROGRAM],
            input=json.dumps([pattern, list(names)]),
            capture_output=True,
            text=True,
            timeout=longest_s,
            check=True,
        )
        answer: list[str] | str = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return f"it takes longer than {longest_s:g} s"
    except (OSError, ValueError, subprocess.CalledProcessError) as error:
        return f"the filter could not be applied: {error}"
    return answer


def _mistake(pattern: str, why: str) -> InvalidMessageError:
    return InvalidMessageError(f"The filter '{shortened(pattern)}': {why}")
