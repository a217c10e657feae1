"""``launch.substitutions.this_launch_file_dir``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from ..frontend.expose import expose_substitution
from ..substitution import call
from .path_join_substitution import PathSubstitution
from .substitution_failure import SubstitutionFailure

if TYPE_CHECKING:
    from ..launch_context import LaunchContext


@expose_substitution("dirname")
class ThisLaunchFileDir(PathSubstitution):
    """The folder of the launch file; ``/`` adds a part."""

    def __init__(self) -> None:
        super().__init__(self)

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("dirname", source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return "ThisLaunchFileDir()"

    def perform(self, context: LaunchContext) -> str:
        """Return the path."""
        known = context.get_locals_as_dict()
        if "current_launch_file_directory" not in known:
            raise SubstitutionFailure(
                "ThisLaunchFileDir used outside of a launch file (in a script)"
            )
        return str(known["current_launch_file_directory"])
