"""Libraries that come with an extra of the distribution: a missing one is named with its line.

In a module of its own, so that nothing else is loaded by the verbs that look for one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from teleopctl.errors import MissingExtraError


@contextmanager
def extra(name: str, *modules: str) -> Iterator[None]:
    """Say how to install an extra where the import inside fails for want of it.

    Args:
        name: The extra, as `pyproject.toml` has it.
        modules: The modules that it brings; any other one that is missing is a defect.

    Raises:
        MissingExtraError: One of them is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in modules:
            raise
        raise MissingExtraError(
            f"This needs {error.name.partition('.')[0]}, which is not installed",
            hint=f"Install it with: pip install 'teleopctl[{name}]'",
        ) from error
