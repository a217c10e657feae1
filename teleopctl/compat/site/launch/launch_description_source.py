"""``launch.launch_description_source``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from ._texts import template

if TYPE_CHECKING:
    from .launch_context import LaunchContext
    from .launch_description import LaunchDescription
    from .some_substitutions_type import SomeSubstitutionsType


class LaunchDescriptionSource:
    """Where a launch description comes from: a description, or a file.

    Args:
        launch_description: The description, or None to read it from the file.
        location: The file.
        method: What the file is, in words.
    """

    def __init__(
        self,
        launch_description: LaunchDescription | None = None,
        location: SomeSubstitutionsType = "",
        method: str = "unspecified mechanism from a script",
    ) -> None:
        self._launch_description = launch_description
        self._file = template(location)
        self._method = method

    @property
    def file(self) -> Template:
        """The path of the file, with substitutions."""
        return self._file

    @property
    def location(self) -> str:
        """The path of the file, in words."""
        return self._file.source

    @property
    def method(self) -> str:
        """What the file is, in words."""
        return self._method

    @property
    def launch_description(self) -> LaunchDescription | None:
        """The description where it was given, else None."""
        return self._launch_description

    def get_launch_description(self, context: LaunchContext) -> LaunchDescription:
        """Return the description, read from the file where it was not given."""
        from .launch_description import LaunchDescription
        from .launch_description_sources._reading import FileContents

        if self._launch_description is not None:
            return self._launch_description
        return LaunchDescription([FileContents(context.text(self._file))])
