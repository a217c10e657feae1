"""``launch.substitutions.launch_log_dir``."""

from teleopctl.launch import Template

from ..frontend.expose import expose_substitution
from ..substitution import call
from .path_join_substitution import PathSubstitution


@expose_substitution("launch_log_dir")
@expose_substitution("log_dir")
class LaunchLogDir(PathSubstitution):
    """The folder of the launch's logs; ``/`` adds a part."""

    def __init__(self) -> None:
        super().__init__(self)

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("launch_log_dir", source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return "LaunchLogDir()"
