"""``launch_testing.util.proc_lookup``: lookup of processes by action, name or pattern."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any, Protocol

from launch.actions import ExecuteLocal
from launch.substitutions import TextSubstitution

NO_CMD_ARGS = object()
"""In place of arguments: the process that was started with none."""


class NoMatchingProcessException(Exception):
    """Raised when no process matches."""


class KnowsProcesses(Protocol):
    """Protocol of records with processes."""

    def processes(self) -> Collection[ExecuteLocal]:
        """Return the actions of the processes."""
        ...


def resolveProcesses(  # noqa: N802 -- the original's name
    info_obj: KnowsProcesses,
    *,
    process: ExecuteLocal | str | None = None,
    cmd_args: Iterable[str] | str | object | None = None,
    strict_proc_matching: bool = True,
) -> list[ExecuteLocal]:
    """Return the actions of the matching processes, at least one.

    Args:
        info_obj: Record of the processes.
        process: An action, a part of a process's name, or None for all of them.
        cmd_args: Arguments that a process meant by its name was started with, or `NO_CMD_ARGS`.
        strict_proc_matching: Whether a name may mean one process only.

    Raises:
        NoMatchingProcessException: Nothing was recorded of such a process.
        RuntimeError: A name means several processes and may not.
        TypeError: `process` is neither action nor text.
    """
    known = list(info_obj.processes())
    if process is None:
        if not known:
            raise NoMatchingProcessException("No data recorded for any process")
        return known
    if isinstance(process, ExecuteLocal):
        if process not in known:
            raise NoMatchingProcessException(f"No data recorded for proc {_words(process)}")
        return [process]
    if not isinstance(process, str):
        raise TypeError(f"proc argument must be 'ExecuteProcess' or 'str' not {type(process)}")
    if isinstance(cmd_args, str):
        cmd_args = [cmd_args]
    found = [each for each in known if process in _name(each) and _has(each, cmd_args)]
    listed = ", ".join(sorted(map(_words, known)))
    if not found:
        raise NoMatchingProcessException(
            f"Did not find any processes matching name '{process}' and args '{cmd_args}'. "
            f"Procs: {listed}"
        )
    if strict_proc_matching and len(found) > 1:
        raise RuntimeError(
            f"Found multiple processes matching name '{process}' and cmd_args '{cmd_args}'. "
            f"Procs: {listed}"
        )
    return found


def _name(process: ExecuteLocal) -> str:
    details = process.process_details
    return str(details["name"]) if details is not None else ""


def _has(process: ExecuteLocal, arguments: Any) -> bool:
    details = process.process_details
    given = details["cmd"][1:] if details is not None else []
    if arguments is None:
        return True
    if arguments is NO_CMD_ARGS:
        return not given
    return all(argument in given for argument in arguments)


def _words(process: ExecuteLocal) -> str:
    """Return the words of the command line, as far as they are known before the start."""
    details = process.process_details
    if details is not None:
        return " ".join([details["name"], *details["cmd"][1:]])
    description = process.process_description
    parts = description.cmd if description is not None else []
    words = []
    for part in parts:
        texts = [piece.text for piece in part if isinstance(piece, TextSubstitution)]
        if len(texts) < len(part):
            return "Unknown - Process not launched yet"
        words.append("".join(texts))
    return " ".join(words)
