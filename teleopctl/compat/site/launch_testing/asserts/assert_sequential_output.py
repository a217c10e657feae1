"""``launch_testing.asserts.assert_sequential_output``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..util import resolveProcesses

if TYPE_CHECKING:
    from launch.actions import ExecuteLocal

    from .assert_output import KnowsOutput

_LINES_AROUND = 2


class SequentialTextChecker:
    """Checker of the order of texts in an output.

    Args:
        output: The output, in pieces.
    """

    def __init__(self, output: Iterable[str]) -> None:
        self._text = "".join(output)
        self._end_of_last = 0

    def assertInText(self, msg: str) -> None:  # noqa: N802 -- the original's name
        """Assert that a text follows the one found last; continue after it.

        Raises:
            AssertionError: It does not; the next search starts at the same place.
        """
        found = self._text.find(msg, self._end_of_last)
        assert found >= 0, (
            f"'{msg}' not found in sequence after previous match.  The output near the last "
            f"matched line:\n{self.get_nearby_lines()}"
        )
        self._end_of_last = found + len(msg)

    def assertInStdout(self, msg: str) -> None:  # noqa: N802 -- the original's name
        """Assert that a text follows the one found last; see `assertInText`."""
        self.assertInText(msg)

    def get_nearby_lines(self) -> str:
        """Return the next line to be checked, with two lines before and after it."""
        lines = self._text.splitlines()
        # After the last character of a line, the next line is checked.
        at = self._text.count("\n", 0, self._end_of_last + 1)
        return "\n".join(lines[max(0, at - _LINES_AROUND) : at + _LINES_AROUND + 1])


@contextmanager
def assertSequentialStdout(  # noqa: N802 -- the original's name
    proc_output: KnowsOutput,
    process: ExecuteLocal | str,
    cmd_args: Iterable[str] | str | object | None = None,
) -> Iterator[SequentialTextChecker]:
    """Return a context manager with a checker of a process's output.

    Args:
        proc_output: Recorded output.
        process: Its action, or a part of its name.
        cmd_args: Arguments that it was started with.

    Raises:
        NoMatchingProcessException: No such process has written anything.
        RuntimeError: The name means several processes.
    """
    (action,) = resolveProcesses(proc_output, process=process, cmd_args=cmd_args)
    yield SequentialTextChecker(
        event.text.decode(errors="replace") for event in proc_output[action]
    )
