"""``launch_testing.asserts.assert_output``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from .._text import build_text_match, without_escape_sequences
from ..util.proc_lookup import KnowsProcesses, resolveProcesses

if TYPE_CHECKING:
    from launch.actions import ExecuteLocal
    from launch.events.process import ProcessIO


class KnowsOutput(KnowsProcesses, Protocol):
    """Protocol of objects with the output of each process."""

    def __getitem__(self, key: ExecuteLocal, /) -> Sequence[ProcessIO]:
        """Return the output of a process."""
        ...


# Any: texts and patterns, as `build_text_match` takes them.
def assertInStream(  # noqa: N802 -- the original's name
    proc_output: KnowsOutput,
    expected_output: Any,
    process: ExecuteLocal | str | None,
    cmd_args: Iterable[str] | str | object | None = None,
    *,
    output_filter: Callable[[str], str] | None = None,
    strict_proc_matching: bool = True,
    strip_ansi_escape_sequences: bool = True,
    stream: str = "stderr",
) -> None:
    """Assert that a process has written an expected output to a stream.

    Args:
        proc_output: Recorded output.
        expected_output: A text, a pattern, or several of them in their order.
        process: An action, a part of a process's name, or None for any process.
        cmd_args: Arguments that it was started with.
        output_filter: Function applied to the output before.
        strict_proc_matching: Whether a name may mean one process only.
        strip_ansi_escape_sequences: Whether colours do not count.
        stream: ``stderr`` or ``stdout``.

    Raises:
        AssertionError: No process that is meant has written it.
        NoMatchingProcessException: None of them has written anything.
        ValueError: There is no such stream, or the filter cannot be called.
    """
    found = resolveProcesses(
        proc_output, process=process, cmd_args=cmd_args, strict_proc_matching=strict_proc_matching
    )
    if output_filter is not None and not callable(output_filter):
        raise ValueError("output_filter is not callable")
    if stream not in ("stdout", "stderr"):
        raise ValueError("Invalid value for stream; must be 'stdout' or 'stderr'")
    matches = build_text_match(expected_output)
    for action in found:
        text = "".join(
            event.text.decode(errors="replace")
            for event in proc_output[action]
            if event.from_stdout == (stream == "stdout")
        )
        if strip_ansi_escape_sequences:
            text = without_escape_sequences(text)
        if output_filter is not None:
            text = output_filter(text)
        if matches(text) is not None:
            return
    names = ", ".join(sorted({proc_output[action][0].process_name for action in found}))
    raise AssertionError(
        f"Did not find '{expected_output}' in output for any of the matching processes: {names}"
    )


# Any: arguments of `assertInStream`.
def assertInStdout(  # noqa: N802 -- the original's name
    proc_output: KnowsOutput,
    expected_output: Any,
    process: ExecuteLocal | str | None,
    cmd_args: Iterable[str] | str | object | None = None,
    **kwargs: Any,
) -> None:
    """Assert that a process has written an expected output to stdout; see `assertInStream`."""
    assertInStream(proc_output, expected_output, process, cmd_args, stream="stdout", **kwargs)


# Any: arguments of `assertInStream`.
def assertInStderr(  # noqa: N802 -- the original's name
    proc_output: KnowsOutput,
    expected_output: Any,
    process: ExecuteLocal | str | None,
    cmd_args: Iterable[str] | str | object | None = None,
    **kwargs: Any,
) -> None:
    """Assert that a process has written an expected output to stderr; see `assertInStream`."""
    assertInStream(proc_output, expected_output, process, cmd_args, stream="stderr", **kwargs)


def assertDefaultStream() -> str:  # noqa: N802 -- the original's name
    """Return the stream that `assertInStream` checks by default."""
    return "stderr"
