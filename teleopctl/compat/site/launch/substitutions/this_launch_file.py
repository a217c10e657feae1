"""``launch.substitutions.this_launch_file``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from teleopctl.launch import Template

from ..frontend.expose import expose_substitution
from ..substitution import KnownSubstitution, call
from .substitution_failure import SubstitutionFailure

if TYPE_CHECKING:
    from ..launch_context import LaunchContext


@expose_substitution("filename")
class ThisLaunchFile(KnownSubstitution):
    """The path of the launch file."""

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("filename", source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return "ThisLaunchFile()"

    def perform(self, context: LaunchContext) -> str:
        """Return the path."""
        known = context.get_locals_as_dict()
        if "current_launch_file_path" not in known:
            raise SubstitutionFailure("ThisLaunchFile used outside of a launch file (in a script)")
        return str(known["current_launch_file_path"])
