"""``launch_testing.actions.gtest``."""

from __future__ import annotations

from typing import Any

from launch import SomeSubstitutionsType

from .test import Test


class GTest(Test):
    """Starts a GoogleTest executable as a test.

    Args:
        path: The program.
        kwargs: Further arguments of `Test`.
    """

    # Any: arguments of `Test.`
    def __init__(self, *, path: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(cmd=[path], **kwargs)
        self._path = path

    @property
    def path(self) -> SomeSubstitutionsType:
        """Path of the executable."""
        return self._path
