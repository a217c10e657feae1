"""``launch_ros.substitutions.find_package``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ament_index_python.packages import get_package_prefix, get_package_share_directory
from launch._texts import template
from launch.substitution import Substitution, call

from teleopctl.launch import Template

if TYPE_CHECKING:
    from launch.launch_context import LaunchContext
    from launch.some_substitutions_type import SomeSubstitutionsType


class FindPackage(Substitution):
    """Base class of substitutions for a folder of a package; a subclass implements `find`.

    Args:
        package: The package.
    """

    def __init__(self, package: SomeSubstitutionsType) -> None:
        super().__init__()
        self._package = template(package)

    @property
    def package(self) -> Template:
        """The package."""
        return self._package

    def describe(self) -> str:
        """Return a readable form of the substitution."""
        return f"{type(self).__name__}(pkg='{self._package.source}')"

    def find(self, package_name: str) -> str:
        """Return the folder of a package."""
        raise NotImplementedError(f"{type(self).__name__} has no find")

    def perform(self, context: LaunchContext) -> str:
        """Return the folder."""
        return self.find(context.text(self._package))


class FindPackagePrefix(FindPackage):
    """Install prefix of a package."""

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("find-pkg-prefix", self._package, source=self.describe())

    def find(self, package_name: str) -> str:
        """Return the install prefix of a package."""
        return get_package_prefix(package_name)

    def perform(self, context: LaunchContext) -> str:
        """Return the folder."""
        return Substitution.perform(self, context)


class FindPackageShare(FindPackage):
    """Share folder of a package."""

    def template(self) -> Template:
        """Return the substitution as a template of `teleopctl.launch`."""
        return call("find-pkg-share", self._package, source=self.describe())

    def find(self, package_name: str) -> str:
        """Return the share folder of a package."""
        return get_package_share_directory(package_name)

    def perform(self, context: LaunchContext) -> str:
        """Return the folder."""
        return Substitution.perform(self, context)
