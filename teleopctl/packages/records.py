"""Records of ROS packages and their programs."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from teleopctl.base.typed import Final, NamedTuple

SOURCES: Final = "sources"
INSTALLED: Final = "installed"
OWN: Final = "own"
DISTRIBUTION: Final = "distribution"
_MANIFEST: Final = "package.xml"


class PackageProgram(NamedTuple):
    """Program of a package: a Python function or a file.

    Attributes:
        name: Name of the program for ``teleopctl run``.
        package: Package that has the program, or an empty string for a file given by path.
        target: Import path ``module:function``, or an empty string when ``file`` is set.
        file: Path of the program's file, or None when ``target`` is set.
        import_roots: Folders to put on the import path first; empty for an importable module.
    """

    name: str
    package: str = ""
    target: str = ""
    file: Path | None = None
    import_roots: tuple[Path, ...] = ()


class Package:
    """A ROS package: name, folder, kind, and how it was found.

    Args:
        name: Name of the package.
        folder: Folder of the package's files.
        kind: Kind of the package, see below.
        found_by: Description of where the package was found.
        read_executables: Returns the package's programs; called when they are first read.
        make_manifest: Returns the text of a ``package.xml`` for a package without one.

    Attributes:
        name: Name of the package.
        folder: Folder of the package's files: the source folder of a source package, ``share/NAME``
            below the prefix for an installed one.
        kind: ``sources`` that are not built, ``installed`` below a prefix by colcon or ROS,
            teleopctl's ``own``, or of an installed Python ``distribution``.
        found_by: Description of where the package was found, such as ``AMENT_PREFIX_PATH``.
    """

    def __init__(
        self,
        name: str,
        folder: Path,
        *,
        kind: str = OWN,
        found_by: str = "teleopctl",
        read_executables: Callable[[], dict[str, PackageProgram]] = dict,
        make_manifest: Callable[[], str] = str,
    ) -> None:
        self.name = name
        self.folder = folder
        self.kind = kind
        self.found_by = found_by
        self._read_executables = read_executables
        self._make_manifest = make_manifest

    @cached_property
    def executables(self) -> dict[str, PackageProgram]:
        """Programs of the package by name, read when first used."""
        return self._read_executables()

    @property
    def share(self) -> Path:
        """Share folder of the package; for a source package perhaps a folder of links.

        This is ``folder``, except for a source package whose ``setup.py`` or ``CMakeLists.txt``
        installs files at other paths: then it is a folder of links.

        Raises:
            SystemFailureError: The folder of links cannot be written.
        """
        if self.kind == OWN:
            # Other own packages than those of files have a folder below the prefix.
            self.prefix  # noqa: B018 -- write it
            return self.folder
        if self.kind != SOURCES or not any(
            (self.folder / script).is_file() for script in ("setup.py", "CMakeLists.txt")
        ):
            return self.folder
        from teleopctl.packages.installed_layout import share_folder

        return share_folder(self.name, self.folder)

    @property
    def manifest(self) -> Path:
        """Path of the package's ``package.xml``, which may not exist for an installed package.

        Raises:
            SystemFailureError: The folder of links cannot be written.
        """
        file = self.share / _MANIFEST
        if self.kind == DISTRIBUTION and not file.is_file():
            return self.prefix / "share" / self.name / _MANIFEST
        return file

    @property
    def prefix(self) -> Path:
        """Install prefix of the package; a folder of links if it is not installed.

        For a package that is not installed, this is a folder of links, and of scripts that run the
        package's programs.

        Raises:
            SystemFailureError: The folder of links cannot be written.
        """
        if self.kind == INSTALLED:
            return self.folder.parent.parent
        if self.kind == OWN:
            from teleopctl.packages.own_packages import own_prefix

            return own_prefix()
        from teleopctl.packages.installed_layout import prefix_folder

        manifest = ""
        if self.kind == DISTRIBUTION and not (self.folder / _MANIFEST).is_file():
            manifest = self._make_manifest()
        is_source, programs = self.kind == SOURCES, tuple(self.executables)
        return prefix_folder(
            self.name, self.folder, self.share, programs, is_source=is_source, manifest=manifest
        )
