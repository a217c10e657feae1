"""Where the Python modules of packages lie, for imports from one package by another.

After ``source install/setup.bash`` a node imports from every package of the workspace. Here a
package need not be built, nor its prefix be sourced, so that whoever looks for a module of a
package's name has to ask.
"""

from __future__ import annotations

from pathlib import Path

from teleopctl.packages.finding import known_layers
from teleopctl.packages.prefixes import python_folders
from teleopctl.packages.records import INSTALLED, SOURCES, Package


def source_module_root(name: str) -> Path | None:
    """Return the folder to import a package's module from, of sources; None where it has none.

    Raises:
        SystemFailureError: That needs a folder of links, which cannot be written.
    """
    for package in known_layers(name):
        if package.kind == SOURCES and (root := _root(package)) is not None:
            return root
    return None


def installed_module_roots(name: str) -> tuple[Path, ...]:
    """Return the folders to import an installed package's module from."""
    for package in known_layers(name):
        if package.kind == INSTALLED:
            return python_folders(package.prefix)
    return ()


def _root(package: Package) -> Path | None:
    from teleopctl.packages.cmake_script import installation
    from teleopctl.packages.installed_layout import linked_module
    from teleopctl.packages.source_folders import text_of

    name, folder = package.name, package.folder
    for root in (folder, folder / "src"):
        if (root / name / "__init__.py").is_file() or (root / f"{name}.py").is_file():
            return root
    text = text_of(folder / "CMakeLists.txt")
    if text is None or "ament_python_install_package" not in text:
        return None
    place = installation(text, folder).modules.get(name)
    module = None if place is None else folder / place
    if module is None or not module.is_dir():
        return None
    return module.parent if module.name == name else linked_module(name, folder, module)
