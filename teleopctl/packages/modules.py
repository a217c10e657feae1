"""Folders of the Python modules of packages, for imports across packages and of plug-ins.

After ``source install/setup.bash``, a node can import from every package of the workspace. In
teleopctl, a package need not be built, nor its prefix be sourced; so an import hook searches for
modules with these functions.
"""

from __future__ import annotations

from pathlib import Path

from teleopctl.packages.finding import known_layers, source_packages
from teleopctl.packages.prefixes import python_folders
from teleopctl.packages.records import INSTALLED, SOURCES, Package


def source_module_root(name: str) -> Path | None:
    """Return the folder of a source package from which a module can be imported; or None.

    Most modules have the name of their package, but ``ament_python_install_package`` and
    ``setup.py`` can install modules of any name.

    Raises:
        SystemFailureError: The module needs a folder of links, which cannot be written.
    """
    named = [package for package in known_layers(name) if package.kind == SOURCES]
    for package in named:
        if (root := _root(name, package)) is not None:
            return root
    for package in source_packages():
        if package not in named and (root := _declared_root(name, package)) is not None:
            return root
    return None


def installed_module_roots(name: str) -> tuple[Path, ...]:
    """Return the Python folders of the first installed package of a name; empty without one."""
    for package in known_layers(name):
        if package.kind == INSTALLED:
            return python_folders(package.prefix)
    return ()


def find_source_plugin(group: str, name: str) -> tuple[str, str] | None:
    """Return import path and import folder of a plug-in that a package's sources declare.

    Args:
        group: Entry-point group, such as ``teleopctl.controllers``.
        name: Name of the plug-in, ``package/Class``.

    Returns:
        Import path ``module:Class`` and the folder to import it from; None if there is none.
    """
    from teleopctl.packages.source_programs import entry_points, import_root

    for package in known_layers(name.partition("/")[0]):
        if package.kind == SOURCES:
            target = entry_points(package.folder, group).get(name)
            if target is not None:
                return target, str(import_root(package.folder, target))
    return None


def _root(name: str, package: Package) -> Path | None:
    for root in (package.folder, package.folder / "src"):
        if (root / name / "__init__.py").is_file() or (root / f"{name}.py").is_file():
            return root
    return _root_by_cmake(name, package.folder)


def _declared_root(name: str, package: Package) -> Path | None:
    """Return the root of an installed module with another name than its package; or None."""
    folder = package.folder
    if (folder / "setup.py").is_file():
        for root in (folder, folder / "src"):
            if (root / name / "__init__.py").is_file():
                return root
    return _root_by_cmake(name, folder)


def _root_by_cmake(name: str, folder: Path) -> Path | None:
    from teleopctl.packages.cmake_script import installation
    from teleopctl.packages.installed_layout import linked_module
    from teleopctl.packages.source_folders import text_of

    text = text_of(folder / "CMakeLists.txt")
    if text is None or "ament_python_install_package" not in text:
        return None
    place = installation(text, folder).modules.get(name)
    module = None if place is None else folder / place
    if module is None or not module.is_dir():
        return None
    return module.parent if module.name == name else linked_module(name, folder, module)
