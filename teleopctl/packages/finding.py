"""Finds ROS packages by name.

``teleopctl run``, ``$(find-pkg-share …)`` and ``package://…`` resolve package names. These sources
form one overlay, in which earlier sources have precedence:

1. ordinary ROS 2 source packages, which need no build: folders with a ``package.xml`` on
   ``TELEOPCTL_PACKAGE_PATH``, below the current folder, or around the current folder or a file
   given by path,
2. packages that colcon built into a workspace's ``install/``, by ``AMENT_PREFIX_PATH`` and
   ``COLCON_PREFIX_PATH``,
3. teleopctl's own packages,
4. packages of a sourced ROS distribution, by the same variables,
5. installed Python distributions with entry points in the groups ``teleopctl.packages``, whose
   values are the module whose folder has the package's files, and ``teleopctl.nodes``, whose
   entries are named ``package/executable``.

In a workspace with its own ``teleop_description``, that package is used, while executables that it
does not define are still found in the other sources. There are two exceptions, so that a folder
with the sources of ROS 2's ``controller_manager`` does not prevent a simulation: source packages
that are useless before they are built come after teleopctl's package of the same name, and
teleopctl's own launch files always start teleopctl's own programs.

In a sourced ROS, ``rviz2`` and ``tf2_ros`` are names of packages of both: the programs are those of
teleopctl, which communicate whatever middleware ROS uses, and the files are those of ROS, since
teleopctl's packages have none.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache, partial
from pathlib import Path

from teleopctl.errors import BrokenPluginError, NotFoundError, did_you_mean
from teleopctl.packages.distributions import builtin_package, has_files
from teleopctl.packages.own_packages import own_names
from teleopctl.packages.prefixes import (
    include_prefix_of,
    installed_names,
    installed_packages,
    is_ros,
)
from teleopctl.packages.records import OWN, SOURCES, Package, PackageProgram

PACKAGE_PATH_VARIABLE = "TELEOPCTL_PACKAGE_PATH"
_QT = "python_qt_binding"
_HOOKS_VARIABLE = "TELEOPCTL_HOOKS"


def find_package(name: str) -> Package:
    """Return a package by name, with the programs of those that it overlays; raise if unknown.

    Raises:
        NotFoundError: No source has a package of that name.
    """
    package = lookup_package(name)
    if package is None:
        guess = did_you_mean(name, package_names())
        raise NotFoundError(
            f"Package '{name}' not found",
            hint=" ".join(filter(None, [guess, *faults_of_search()]))
            or f"Packages are searched in ${PACKAGE_PATH_VARIABLE}, below and above the current "
            "folder, in $AMENT_PREFIX_PATH and among the installed distributions.",
        )
    return package


def lookup_package(name: str) -> Package | None:
    """Return a package by name, with the programs of those that it overlays; None if unknown.

    Raises:
        BrokenPluginError: A distribution has the package, but its files do not exist.
    """
    # Entry points are slow to read: they are read only if no other source has the package.
    return _overlay(list(known_layers(name)) or _of_distribution(name))


def package_layers(name: str) -> list[Package]:
    """Return all packages of a name as a list, each before those that it overlays.

    Raises:
        BrokenPluginError: A distribution has the package, but its files do not exist.
    """
    return [*known_layers(name), *_of_distribution(name)]


def package_names() -> list[str]:
    """Return the names of all packages, sorted."""
    from teleopctl.packages.distributions import distribution_names

    names = {*_source_packages(), *installed_names(), *own_names(), *distribution_names()}
    return sorted(names)


def list_packages() -> list[Package]:
    """Return one package per name, with the programs of those that it overlays, sorted by name."""
    listed = []
    for name in package_names():
        layers = list(known_layers(name))
        with suppress(BrokenPluginError):  # reported when the package is used
            layers += _of_distribution(name)
        if (package := _overlay(layers)) is not None:
            listed.append(package)
    return listed


def source_resources(resource_type: str) -> dict[str, Package]:
    """Return the source package of each resource of a type that source packages declare, by name.

    Args:
        resource_type: Type of the resources in the ament index, such as ``rosidl_interfaces``.
    """
    from teleopctl.packages.installed_layout import resources

    found: dict[str, Package] = {}
    for package in source_packages():
        for path in resources(package.name, package.folder):
            declared_type, _, name = path.partition("/")
            if declared_type == resource_type:
                found.setdefault(name, package)
    return found


def apply_source_hooks() -> None:
    """Set the variables that the hooks of source packages set when a workspace is sourced.

    Idempotent. Processes that inherit the environment do not search again.
    """
    from teleopctl.packages.environment_hooks import source_hooks

    if _HOOKS_VARIABLE in os.environ:
        return
    os.environ[_HOOKS_VARIABLE] = "applied"
    for package, *_ in _source_packages().values():
        for operation in source_hooks(package.name, package.folder):
            operation.apply(package.prefix, os.environ)


def source_packages() -> list[Package]:
    """Return all source packages in the searched folders, also several of one name."""
    return [package for layers in _source_packages().values() for package in layers]


def faults_of_search() -> list[str]:
    """Return sentences about invalid ``package.xml`` files and searches that were cut off."""
    from teleopctl.packages.source_folders import find_package_folders

    faults: list[str] = []
    for root, _ in search_places():
        cuts: list[int] = []
        faults += [
            f"{folder / 'package.xml'} has no readable <name>: its folder is not a package."
            for name, folder in find_package_folders(Path(root), cuts.append)
            if name is None
        ]
        faults += [
            f"Below {root} there are more than the {bound} folders that are searched: name the "
            f"folder of the package in {PACKAGE_PATH_VARIABLE}."
            for bound in cuts
        ]
    return list(dict.fromkeys(faults))


def include_package_of(file: Path) -> None:
    """Add a file's package and workspace to the package search path of this process and children.

    The other packages of its workspace are added as well, since a description and its bringup are
    two packages. All of them come after packages on ``TELEOPCTL_PACKAGE_PATH``, and before those
    found below or around the current folder. For a package installed below a prefix that was not
    sourced, all packages of the prefix are added, after those of the sourced prefixes.
    """
    include_prefix_of(file)
    from teleopctl.packages.source_folders import enclosing_package, package_name, workspace_of

    folder = enclosing_package(Path(os.path.abspath(file)).parent)  # noqa: PTH100
    name = None if folder is None else package_name(folder / "package.xml")
    named = os.environ.get(PACKAGE_PATH_VARIABLE, "")
    here = Path.cwd()
    roots = tuple((root, "") for root in _named_roots(named, str(here)))
    if folder is None or not name or name in _packages_below(roots):
        return
    own = builtin_package(name)
    if own is None or own.folder != folder:
        workspace = workspace_of(folder)
        # Packages below the current folder are found anyway; they may be in several workspaces.
        near = workspace is None or here in (workspace, workspace.parent)
        others = None if near else str(workspace)
        folders = filter(None, (named, str(folder), others))
        os.environ[PACKAGE_PATH_VARIABLE] = os.pathsep.join(folders)


def package_share(name: str) -> Path:
    """Return the share folder of a package by name; raise if it does not exist.

    Raises:
        TeleopctlError: The package does not exist.
    """
    return find_package(name).share


def resolve_uri(uri: str) -> Path:
    """Return the path of a ``package://`` or ``file://`` URI, or of a plain path; it may not exist.

    Raises:
        NotFoundError: The package is unknown, the scheme is another one, or the path is invalid.
    """
    scheme, separator, rest = uri.partition("://")
    if separator:
        from urllib.parse import unquote

        rest = unquote(rest)
    if "\0" in uri or "\0" in rest:
        raise NotFoundError(f"Cannot open {uri!r}: a path cannot contain a null character")
    if not separator:
        try:
            return Path(uri).expanduser()
        except RuntimeError as error:  # ~ of an unknown user
            raise NotFoundError(f"Cannot open '{uri}': {error}") from error
    if scheme == "package":
        package, _, relative = rest.partition("/")
        return package_share(package) / relative
    if scheme == "file":
        # file:///C:/x has a slash before the drive letter
        is_drive = len(rest) > 2 and rest[0] == "/" and rest[2] == ":"
        return Path(rest[1:] if is_drive else rest)
    raise NotFoundError(f"Cannot open '{uri}': expected package://, file:// or a path")


def known_layers(name: str) -> Iterator[Package]:
    """Yield the packages of a name, overlays first, but not those of Python distributions."""
    own = builtin_package(name)
    unbuilt: list[Package] = []
    for package in _source_packages().get(name, ()):
        if own is not None and _needs_building(package):
            unbuilt.append(_source_package(name, package.folder, f"{package.found_by}, not built"))
        else:
            yield package
    installed = [(is_ros(package.prefix), package) for package in installed_packages(name)]
    yield from (package for of_ros, package in installed if not of_ros)
    if own is not None:
        yield own
    yield from unbuilt
    yield from (package for of_ros, package in installed if of_ros)


def _needs_building(package: Package) -> bool:
    """Return whether a source package is useless unbuilt: compiled, or with a GUI of ROS's Qt."""
    from teleopctl.packages.source_programs import compiles, depends_on

    return compiles(package.folder) or (
        depends_on(package.folder, _QT) and not any(installed_packages(_QT))
    )


def _of_distribution(name: str) -> list[Package]:
    from teleopctl.packages.distributions import distribution_package

    package = distribution_package(name)
    return [] if package is None else [package]


def _overlay(layers: list[Package]) -> Package | None:
    """Return the first package, with the programs of all layers; None without layers."""
    if len(layers) < 2:
        return layers[0] if layers else None
    first = next((p for p in layers if p.kind != OWN or has_files(p.name)), layers[0])
    return Package(
        first.name,
        first.folder,
        kind=first.kind,
        found_by=first.found_by,
        read_executables=partial(_executables, layers),
    )


def _executables(layers: list[Package]) -> dict[str, PackageProgram]:
    # Two source folders with one name are an error, as for colcon: the second one is not used.
    first = next((package for package in layers if package.kind == SOURCES), None)
    used = [package for package in layers if package.kind != SOURCES or package is first]
    executables: dict[str, PackageProgram] = {}
    for package in reversed(used):
        executables.update(package.executables)
    return executables


def _source_packages() -> dict[str, list[Package]]:
    return _packages_below(search_places())


def search_places() -> tuple[tuple[str, str], ...]:
    """Return the folders to search for ``package.xml`` files, each with its description."""
    # The folders as strings are the key of a cache.
    return _places(os.environ.get(PACKAGE_PATH_VARIABLE, ""), os.getcwd())  # noqa: PTH109


@lru_cache(maxsize=16)
def _places(named: str, here: str) -> tuple[tuple[str, str], ...]:
    from teleopctl.packages.source_folders import enclosing_package

    around = enclosing_package(Path(here).parent)
    return (
        *((root, PACKAGE_PATH_VARIABLE) for root in _named_roots(named, here)),
        (here, "below the current folder"),
        *([(str(around), "around the current folder")] if around else []),
    )


def _named_roots(named: str, here: str) -> tuple[str, ...]:
    return tuple(
        os.path.normpath(os.path.join(here, os.path.expanduser(folder)))  # noqa: PTH111, PTH118
        for folder in named.split(os.pathsep)
        if folder
    )


@lru_cache(maxsize=16)
def _packages_below(roots: tuple[tuple[str, str], ...]) -> dict[str, list[Package]]:
    # Package manifests rarely change while one command runs: each set of roots is read once.
    from teleopctl.packages.source_folders import find_package_folders

    packages: dict[str, list[Package]] = {}
    for root, found_by in roots:
        for name, folder in find_package_folders(Path(root)):
            known = packages.setdefault(name, []) if name else []
            if name and all(package.folder != folder for package in known):
                known.append(_source_package(name, folder, found_by))
    return packages


def _source_package(name: str, folder: Path, found_by: str) -> Package:
    read = partial(_source_executables, name, folder)
    return Package(name, folder, kind=SOURCES, found_by=found_by, read_executables=read)


def _source_executables(name: str, folder: Path) -> dict[str, PackageProgram]:
    from teleopctl.packages.source_programs import executables

    return executables(name, folder)
