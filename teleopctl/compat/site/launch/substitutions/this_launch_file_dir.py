"""``launch.substitutions.this_launch_file_dir``."""

from teleopctl.launch import Template

from ..substitution import Substitution, call


class ThisLaunchFileDir(Substitution):
    """The folder of the launch file."""

    def template(self) -> Template:
        """Return it as the model has it."""
        return call("dirname", source=self.describe())

    def describe(self) -> str:
        """Return it in words."""
        return "ThisLaunchFileDir()"
