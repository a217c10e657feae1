"""What can be told of a launch before it begins, and what is odd about its arguments."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple

from teleopctl.errors import NotFoundError, TeleopctlError, did_you_mean
from teleopctl.launch.model.plan import FollowUp


class DryRun(NamedTuple):
    """Steps that an event will cause, as far as they can be evaluated in advance.

    Attributes:
        when: The event in words.
        further: What it does then.
        error: Why not more is known of it, or None.
        then: What that leads to.
    """

    when: str
    further: FollowUp
    error: TeleopctlError | None
    then: tuple[DryRun, ...]


def faults(foreseen: Iterable[DryRun]) -> Iterator[TeleopctlError]:
    """Yield what the foreseen steps lack, such as packages and programs.

    Other errors may be none when the time has come.
    """
    for each in foreseen:
        if isinstance(each.error, NotFoundError):
            yield each.error
        yield from faults(each.then)


def undeclared(arguments: Iterable[str], declared: Collection[str]) -> list[str]:
    """Return a sentence for each launch argument that no file declares."""
    known = ", ".join(sorted(declared)) or "none"
    return [
        f"launch argument '{name}' is not declared by the launch file (declared: {known})"
        + (f". {guess}" if (guess := did_you_mean(name, declared)) else "")
        for name in arguments
        if name not in declared
    ]
