"""Finds ROS packages by name, and programs in them.

A package is a name that ``teleopctl run``, ``$(find-pkg-share …)`` and ``package://…`` resolve.
Three sources form one overlay, the first one that knows a name wins:

1. folders with a ``package.xml`` on ``TELEOPCTL_PACKAGE_PATH``, below the current folder, and the
   one that the current folder or a file given by path lies in: ordinary ROS 2 source packages that
   need no build,
2. the packages that teleopctl brings itself,
3. installed distributions with the entry-point groups ``teleopctl.packages``, whose values are the
   module in whose folder the package's files lie, and ``teleopctl.nodes``, whose entries are named
   ``package/executable``.

As a user's folder comes first, a workspace that holds its own ``teleop_description`` is the one
that is used in it, while executables that it does not define still come from the others. The one
exception: the programs that teleopctl's own launch files name are always teleopctl's own, since the
sources of ROS 2's ``controller_manager`` in some folder are no reason not to simulate there.
"""

import os
from collections.abc import Iterable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from teleopctl import plugins
from teleopctl.errors import (
    AmbiguousNameError,
    BrokenPluginError,
    NotFoundError,
    did_you_mean,
)

PACKAGE_PATH_VARIABLE = "TELEOPCTL_PACKAGE_PATH"

_HERE = Path(__file__).resolve().parents[1]

# Packages that consist of files: name → folder at the root of a source checkout; a wheel has them
# below share/.
_DATA_PACKAGES = {
    "teleop_description": "robot",
    "teleop_controller": "config",
    "teleopctl": "teleopctl/share/teleopctl",
}


class Executable(NamedTuple):
    """A program of a package: a function to call, or a file to run.

    Attributes:
        name: What ``teleopctl run`` calls it.
        package: The package that offers it, or an empty string for a file given by path.
        target: ``module:function``, or an empty string when ``file`` is set.
        file: The program's file, or None when ``target`` is set.
        import_root: Folder to put on the import path first, or None when it is installed.
    """

    name: str
    package: str = ""
    target: str = ""
    file: Path | None = None
    import_root: Path | None = None


class Package(NamedTuple):
    """A ROS package.

    Attributes:
        name: The package's name.
        folder: The folder of its files where it is found: of a source package its sources.
        executables: Its programs by name.
    """

    name: str
    folder: Path
    executables: dict[str, Executable]

    @property
    def share(self) -> Path:
        """The folder of its files as installed; ``launch/``, ``urdf/`` … are looked for in it.

        It is ``folder``, but for a source package whose ``setup.py`` or ``CMakeLists.txt`` installs
        files elsewhere.

        Raises:
            SystemFailureError: That needs a folder of links, which cannot be written.
        """
        if not any((self.folder / script).is_file() for script in ("setup.py", "CMakeLists.txt")):
            return self.folder
        from teleopctl.packages.installed_layout import share_folder

        return share_folder(self.name, self.folder)


def find_package(name: str) -> Package:
    """Find a package by its name.

    Raises:
        NotFoundError: When no source knows the name.
    """
    package = lookup_package(name)
    if package is None:
        guess = did_you_mean(name, (package.name for package in list_packages()))
        raise NotFoundError(
            f"Package '{name}' not found",
            hint=" ".join(filter(None, [guess, *faults_of_search()]))
            or f"Packages are looked for in ${PACKAGE_PATH_VARIABLE}, below and above the current "
            "folder and among the installed distributions.",
        )
    return package


def lookup_package(name: str) -> Package | None:
    """Find a package by its name; None when no source knows it.

    Raises:
        BrokenPluginError: A distribution offers it, but its files are not there.
    """
    # Entry points are dear to read: they are asked only when nothing else knows the package.
    layers = _known(_folder_packages().get(name), builtin_package(name))
    return _overlay(layers) if layers else _installed_package(name)


def package_layers(name: str) -> list[Package]:
    """Return all packages of a name, each before those that it hides; empty when there is none.

    Raises:
        BrokenPluginError: A distribution offers it, but its files are not there.
    """
    return _known(_folder_packages().get(name), builtin_package(name), _installed_package(name))


def list_packages() -> list[Package]:
    """Return every package that can be found, sorted by name."""
    nodes = plugins.available(plugins.NODES)
    names = {*_DATA_PACKAGES, *plugins.available(plugins.PACKAGES), *_folder_packages()}
    names.update(name.rpartition("/")[0] for name in nodes)
    listed = []
    for name in sorted(names - {""}):
        layers = _known(_folder_packages().get(name), builtin_package(name))
        with suppress(BrokenPluginError):  # told where it is used
            layers += _known(_installed_package(name))
        if layers:
            listed.append(_overlay(layers))
    return listed


def faults_of_search() -> list[str]:
    """Say which folders with a ``package.xml`` are no packages, and which searches were cut off."""
    from teleopctl.packages import ament

    faults: list[str] = []
    for root in _roots():
        cuts: list[int] = []
        faults += [
            f"{folder / 'package.xml'} has no readable <name>: its folder is no package."
            for name, folder in ament.find_package_folders(Path(root), cuts.append)
            if name is None
        ]
        faults += [
            f"Below {root} there are more than the {bound} folders that are searched: name the "
            f"folder of the package in {PACKAGE_PATH_VARIABLE}."
            for bound in cuts
        ]
    return list(dict.fromkeys(faults))


def include_package_of(file: Path) -> None:
    """Let the package that a file lies in be found, here and by the processes started from here.

    It comes before one of its name around the current folder, which is only met there, and behind
    one on ``TELEOPCTL_PACKAGE_PATH``.
    """
    from teleopctl.packages import ament

    folder = ament.enclosing_package(Path(os.path.abspath(file)).parent)  # noqa: PTH100
    name = folder and ament.package_name(folder / "package.xml")
    if not name or name in _packages_below(_named_roots()):
        return
    own = builtin_package(name)
    if own is None or own.folder != folder:
        named = filter(None, (os.environ.get(PACKAGE_PATH_VARIABLE), str(folder)))
        os.environ[PACKAGE_PATH_VARIABLE] = os.pathsep.join(named)


def package_share(name: str) -> Path:
    """Return the folder of a package's files.

    Raises:
        TeleopctlError: When there is no such package.
    """
    return find_package(name).share


def find_executable(package: str | None, name: str, *, builtin: bool = False) -> Executable:
    """Find a program by package and name, by its name alone, or by its path.

    Args:
        package: The package, or None when ``name`` is a path or unique among all packages.
        name: The program's name, or the path of a file.
        builtin: Whether only the packages count that teleopctl brings itself.

    Raises:
        TeleopctlError: When the package or the program is not found, or when several packages
            offer different programs of that name.
    """
    if builtin:
        own = builtin_package(package or "")
        if own is None or name not in own.executables:
            raise NotFoundError(f"teleopctl has no program '{name}' in a package '{package}'")
        return own.executables[name]
    if package is not None:
        return _executable_of(package, name)
    if is_path(name):
        return _executable_file(name)
    return _only_executable(name)


def _executable_of(package: str, name: str) -> Executable:
    offered = find_package(package).executables
    if name in offered:
        return offered[name]
    # A package that needs no look at the entry points may have more programs among them.
    installed = _installed_package(package)
    if installed is not None and name in installed.executables:
        return installed.executables[name]
    names = ", ".join(sorted(offered))
    raise NotFoundError(
        "No executable found",
        hint=did_you_mean(name, offered) or f"{package} has {names or 'no executables'}.",
    )


def _executable_file(path: str) -> Executable:
    file = Path(path).expanduser().absolute()
    if not file.is_file():
        raise NotFoundError("No executable found", hint=f"There is no file {file}.")
    include_package_of(file)
    return Executable(name=file.name, file=file, import_root=file.parent)


def _only_executable(name: str) -> Executable:
    """Return the program of that name, which several packages may share."""
    packages = list_packages()
    found = [entry.executables[name] for entry in packages if name in entry.executables]
    if not found:
        every = {executable for entry in packages for executable in entry.executables}
        raise NotFoundError("No executable found", hint=did_you_mean(name, every))
    if len({(entry.target, entry.file, entry.import_root) for entry in found}) > 1:
        owners = ", ".join(entry.package for entry in found)
        raise AmbiguousNameError(
            f"Several packages have an executable '{name}': {owners}",
            hint=f"Name one: teleopctl run {found[0].package} {name}",
        )
    return found[0]


def is_path(text: str) -> bool:
    """Tell whether the name of a program is meant as the path of a file."""
    return "/" in text or os.sep in text or text.endswith(".py")


def resolve_uri(uri: str) -> Path:
    """Turn ``package://PACKAGE/path``, ``file:///path`` or a plain path into a path.

    The file need not exist.

    Raises:
        NotFoundError: When the package is unknown or the scheme is another one.
    """
    scheme, separator, rest = uri.partition("://")
    if not separator:
        return Path(uri).expanduser()
    from urllib.parse import unquote

    rest = unquote(rest)
    if scheme == "package":
        package, _, relative = rest.partition("/")
        return package_share(package) / relative
    if scheme == "file":
        # file:///C:/x has a slash before the drive letter
        is_drive = len(rest) > 2 and rest[0] == "/" and rest[2] == ":"
        return Path(rest[1:] if is_drive else rest)
    raise NotFoundError(f"Cannot open '{uri}': expected package://, file:// or a path")


def _known(*layers: Package | None) -> list[Package]:
    return [package for package in layers if package is not None]


def _overlay(layers: list[Package]) -> Package:
    executables: dict[str, Executable] = {}
    for layer in reversed(layers):
        executables.update(layer.executables)
    return Package(name=layers[0].name, folder=layers[0].folder, executables=executables)


def builtin_package(name: str) -> Package | None:
    """Return the package of that name that teleopctl brings itself, or None."""
    if name in _DATA_PACKAGES:
        installed = _HERE / "share" / name
        folder = installed if installed.is_dir() else _HERE.parent / _DATA_PACKAGES[name]
        return Package(name=name, folder=folder, executables={})
    executables = _executables(name, plugins.NODES.ours.items())
    return Package(name=name, folder=_HERE, executables=executables) if executables else None


def _executables(package: str, nodes: Iterable[tuple[str, str]]) -> dict[str, Executable]:
    """Of pairs of ``package/executable`` and target, those of one package."""
    split = ((name.rpartition("/"), target) for name, target in nodes)
    return {
        name: Executable(name=name, package=package, target=target)
        for (owner, _, name), target in split
        if owner == package
    }


def _folder_packages() -> dict[str, Package]:
    return _packages_below(_roots())


def _roots() -> tuple[str, ...]:
    """Where folders with a ``package.xml`` are looked for."""
    from teleopctl.packages import ament

    here = os.getcwd()  # noqa: PTH109 -- a string is the key of a cache
    around = ament.enclosing_package(Path(here).parent)
    return (*_named_roots(), here, *([str(around)] if around else []))


def _named_roots() -> tuple[str, ...]:
    return tuple(
        os.path.abspath(os.path.expanduser(folder))  # noqa: PTH100, PTH111 -- os.path needs no Path
        for folder in os.environ.get(PACKAGE_PATH_VARIABLE, "").split(os.pathsep)
        if folder
    )


@lru_cache(maxsize=16)
def _packages_below(roots: tuple[str, ...]) -> dict[str, Package]:
    # The files of a package change rarely while one command runs: each set of roots is read once.
    from teleopctl.packages import ament

    packages: dict[str, Package] = {}
    for root in roots:
        for name, folder in ament.find_package_folders(Path(root)):
            if name is not None and name not in packages:
                packages[name] = Package(
                    name=name,
                    folder=folder,
                    executables={
                        script: Executable(
                            name=script,
                            package=name,
                            target=target,
                            import_root=ament.import_root(folder, target),
                        )
                        for script, target in ament.console_scripts(folder).items()
                    },
                )
    return packages


def _installed_package(name: str) -> Package | None:
    nodes = [
        (node, plugin.target)
        for node, plugin in plugins.available(plugins.NODES).items()
        if plugin.distribution
    ]
    executables = _executables(name, nodes)
    plugin = plugins.find(plugins.PACKAGES, name)
    if plugin is not None:
        folder = _module_folder(plugin.target)
        if folder is None:
            raise BrokenPluginError(
                f"package '{name}' of {plugin.distribution}: there is no module {plugin.target}"
            )
    elif executables:
        # Without an entry of its own, its files lie beside the code of its first executable.
        module = next(iter(executables.values())).target.partition(":")[0]
        folder = _module_folder(module.partition(".")[0]) or _HERE
    else:
        return None
    return Package(name=name, folder=folder, executables=executables)


def _module_folder(module: str) -> Path | None:
    """The folder of a package's or a module's file, found without importing anything."""
    from importlib.util import find_spec

    top, *below = module.split(".")
    spec = find_spec(top)
    if spec is None:
        return None
    if spec.submodule_search_locations:
        folder = Path(next(iter(spec.submodule_search_locations)), *below)
    else:
        folder = Path(spec.origin or "").parent
    return folder if folder.is_dir() else None
