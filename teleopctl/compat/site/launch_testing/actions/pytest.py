"""``launch_testing.actions.pytest``."""

from __future__ import annotations

import sys
from typing import Any

from launch import SomeSubstitutionsType

from .test import Test


class PyTest(Test):
    """Starts pytest for a file as a test.

    Args:
        path: The file.
        kwargs: Further arguments of `Test`.
    """

    # Any: arguments of `Test.`
    def __init__(self, *, path: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(cmd=[sys.executable, "-m", "pytest", path], **kwargs)
        self._path = path

    @property
    def path(self) -> SomeSubstitutionsType:
        """Path of the file."""
        return self._path
