"""``launch_ros.substitutions.executable_in_package``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from launch._texts import template
from launch.substitution import Substitution, call

from teleopctl.launch import Template

if TYPE_CHECKING:
    from launch.some_substitutions_type import SomeSubstitutionsType


class ExecutableInPackage(Substitution):
    """Path of an executable in a package.

    Args:
        executable: The program.
        package: The package.
    """

    def __init__(self, executable: SomeSubstitutionsType, package: SomeSubstitutionsType) -> None:
        super().__init__()
        self._executable = template(executable)
        self._package = template(package)

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("exec-in-pkg", self._executable, self._package, source=self.describe())

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"ExecInPkg(pkg='{self._package.source}', exec='{self._executable.source}')"
