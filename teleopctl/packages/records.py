"""Records of ROS packages and their programs."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Final, NamedTuple

SOURCES: Final = "sources"
INSTALLED: Final = "installed"
OWN: Final = "own"
DISTRIBUTION: Final = "distribution"


class PackageProgram(NamedTuple):
    """Program of a package: a function or a file.

    Attributes:
        name: What ``teleopctl run`` calls it.
        package: The package that offers it, or an empty string for a file given by path.
        target: ``module:function``, or an empty string when ``file`` is set.
        file: The program's file, or None when ``target`` is set.
        import_roots: Folders to put on the import path first; empty when it is installed.
    """

    name: str
    package: str = ""
    target: str = ""
    file: Path | None = None
    import_roots: tuple[Path, ...] = ()


class Package:
    """A ROS package: name, folder, kind, and how it was found.

    Args:
        name: Its name.
        folder: The folder of its files where it is found.
        kind: What is found there, see below.
        found_by: By which of the sources of packages, for people.
        read_executables: Reads its programs, when they are first asked for.

    Attributes:
        name: The package's name.
        folder: The folder of its files where it is found: of a source package its sources, of an
            installed one ``share/NAME`` below its prefix.
        kind: ``sources`` that are not built, ``installed`` below a prefix by colcon or ROS,
            teleopctl's ``own``, or of an installed Python ``distribution``.
        found_by: Which of the sources of packages found it, such as ``AMENT_PREFIX_PATH``.
    """

    def __init__(
        self,
        name: str,
        folder: Path,
        *,
        kind: str = OWN,
        found_by: str = "teleopctl",
        read_executables: Callable[[], dict[str, PackageProgram]] = dict,
    ) -> None:
        self.name = name
        self.folder = folder
        self.kind = kind
        self.found_by = found_by
        self._read_executables = read_executables

    @cached_property
    def executables(self) -> dict[str, PackageProgram]:
        """The package's executables by name."""
        return self._read_executables()

    @property
    def share(self) -> Path:
        """Return the package's share folder.

        It is ``folder``, but for a source package whose ``setup.py`` or ``CMakeLists.txt`` installs
        files elsewhere.

        Raises:
            SystemFailureError: That needs a folder of links, which cannot be written.
        """
        if self.kind != SOURCES or not any(
            (self.folder / script).is_file() for script in ("setup.py", "CMakeLists.txt")
        ):
            return self.folder
        from teleopctl.packages.installed_layout import share_folder

        return share_folder(self.name, self.folder)

    @property
    def prefix(self) -> Path:
        """Return the install prefix of the package.

        Of a package that is not installed it is a folder of links and of small programs that run
        the package's.

        Raises:
            SystemFailureError: That folder cannot be written.
        """
        if self.kind == INSTALLED:
            return self.folder.parent.parent
        from teleopctl.packages.installed_layout import prefix_folder

        is_source = self.kind == SOURCES
        programs = tuple(self.executables)
        return prefix_folder(self.name, self.folder, self.share, programs, is_source=is_source)
