"""``launch.launch_description_sources.frontend_launch_description_source``."""

from __future__ import annotations

from typing import Any

from ..launch_description import LaunchDescription
from ..launch_description_source import LaunchDescriptionSource
from ..some_substitutions_type import SomeSubstitutionsType
from .frontend_launch_file_utilities import get_launch_description_from_frontend_launch_file


class FrontendLaunchDescriptionSource(LaunchDescriptionSource):
    """XML or YAML launch file.

    Args:
        launch_file_path: The file.
        method: Kind of the file, in words.
        parser: Not used: the parser is chosen by the file's extension.
    """

    # Any: the original's parser class, of which nothing is used.
    def __init__(
        self,
        launch_file_path: SomeSubstitutionsType,
        *,
        method: str = "interpreted frontend launch file",
        parser: Any = None,  # noqa: ARG002 -- the original's signature
    ) -> None:
        super().__init__(location=launch_file_path, method=method)

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_frontend_launch_file(location)
