"""``launch.launch_description_source``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from ._texts import template
from .launch_context import LaunchContext
from .utilities import normalize_to_list_of_substitutions, perform_substitutions

if TYPE_CHECKING:
    from .launch_description import LaunchDescription
    from .some_substitutions_type import SomeSubstitutionsType


class LaunchDescriptionSource:
    """Source of a launch description: the description itself, or a file.

    Args:
        launch_description: The description, or None to read it from the file.
        location: The file.
        method: Kind of the file, in words.
    """

    def __init__(
        self,
        launch_description: LaunchDescription | None = None,
        location: SomeSubstitutionsType = "<string>",
        method: str = "unspecified mechanism from a script",
    ) -> None:
        self._launch_description = launch_description
        self._location = normalize_to_list_of_substitutions(location)
        self._expanded: str | None = None
        self._method = method

    @property
    def file(self) -> Template:
        """The path of the file, with substitutions."""
        return template(self._location)

    @property
    def location(self) -> str:
        """Path of the file; a readable form of it before evaluation."""
        if self._expanded is None:
            return " + ".join(str(part) for part in self._location)
        return self._expanded

    @property
    def method(self) -> str:
        """Kind of the file, in words."""
        return self._method

    @property
    def launch_description(self) -> LaunchDescription | None:
        """The description if it was given or has been read, else None."""
        return self._launch_description

    def get_launch_description(self, context: LaunchContext) -> LaunchDescription:
        """Return the description, read from the file if necessary.

        Raises:
            RuntimeError: There is neither.
        """
        if self._expanded is None:
            self._expanded = perform_substitutions(context, self._location)
        if self._launch_description is None:
            self._launch_description = self._get_launch_description(self._expanded)
        return self._launch_description

    def try_get_launch_description_without_context(self) -> LaunchDescription | None:
        """Return the description if its path needs no launch context, else None."""
        if self._launch_description is not None:
            return self._launch_description
        try:
            location = perform_substitutions(LaunchContext(), self._location)
            return self._get_launch_description(location)
        except Exception:  # noqa: BLE001 -- a launch file that raises has no known content
            return None

    def _get_launch_description(self, location: str) -> LaunchDescription:
        """Read a file; a subclass implements it."""
        raise RuntimeError(
            "LaunchDescriptionSource.get_launch_description(): "
            f"called without launch description being set, for {location}"
        )
