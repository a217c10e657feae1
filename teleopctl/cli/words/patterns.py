"""Names with ``*``, such as ``/arm/*``: one part of a name, or with ``**`` any number of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from teleopctl.cli.live import absolute_name
from teleopctl.errors import NotFoundError


def is_pattern(name: str) -> bool:
    """Return whether a name is a pattern with ``*``."""
    return "*" in name


def fitting(pattern: str, names: Iterable[str], *, kind: str) -> list[str]:
    """Return the names that match a pattern, in their order.

    Args:
        pattern: Such as ``/arm/*``.
        names: Full names.
        kind: What they are the names of, for the message.

    Raises:
        NotFoundError: None fits.
    """
    import re

    parts = re.split(r"(\*\*|\*)", absolute_name(pattern))
    meant = {"**": ".*", "*": "[^/]*"}
    expression = re.compile("".join(meant.get(part) or re.escape(part) for part in parts))
    found = [name for name in names if expression.fullmatch(name)]
    if not found:
        raise NotFoundError(f"No {kind} fits '{pattern}'")
    return found


def expanded(names: Sequence[str], known: Iterable[str], *, kind: str) -> list[str]:
    """Return names with each pattern replaced by the names that match it.

    Raises:
        NotFoundError: Nothing fits a pattern.
    """
    live = list(known)
    found: dict[str, None] = {}
    for name in names:
        fits = fitting(name, live, kind=kind) if is_pattern(name) else [absolute_name(name)]
        found.update(dict.fromkeys(fits))
    return list(found)
