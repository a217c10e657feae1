"""teleopctl's own packages: names, files, manifests, and the install prefix that has them all.

A program may look for the files of any package that it can import or start: its ``package.xml``,
``msg/String.msg``, its marker in the ament index. So all own packages are laid out below one
install prefix in the user's cache folder, as ``/opt/ros/jazzy`` has those of ROS 2. The prefix is
written when it is first needed, and again after an update.

Versions and descriptions are in ``own_packages.txt``. Packages of interfaces have the version from
which their definitions are (``interfaces/definitions/SOURCES.md``), other packages that of ROS 2
Jazzy's release of August 2026, and those that Jazzy lacks have teleopctl's own.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path

from teleopctl import plugins
from teleopctl.base.folders import cache_dir
from teleopctl.base.typed import Final, NamedTuple
from teleopctl.errors import SystemFailureError
from teleopctl.packages.installed_layout import (
    INDEX,
    PLUGIN_RESOURCE,
    RUN_DEPENDENCIES,
    link,
    starter,
)

HERE: Final = Path(__file__).resolve().parents[1]
DATA_PACKAGES: Final = {
    "teleop_description": "robot",
    "teleop_controller": "config",
    **{
        name: f"teleopctl/share/{name}"
        for name in (
            *("demo_nodes_cpp", "demo_nodes_py", "gazebo_ros", "joy", "lifecycle"),
            *("ros_gz_bridge", "ros_gz_sim", "ros_ign_gazebo", "teleop_twist_joy", "teleopctl"),
            *("turtlesim", "urdf_launch", "urdf_tutorial"),
        )
    },
}
"""Packages with files: folder in a source checkout by name; in a wheel, all are below share/."""

_TABLE: Final = HERE / "packages/own_packages.txt"
_MODULES: Final = HERE / "compat/site"
_DEFINITIONS: Final = HERE / "interfaces/definitions"
# Files and folders that change when a package is added, or a program.
_SOURCES: Final = (
    *(_TABLE, _MODULES, _DEFINITIONS / "SOURCES.md", HERE / "plugins/programs.py"),
    HERE / "packages/own_packages.py",
)
_MARK: Final = ".teleopctl"  # file in the prefix

# The license of the files in the prefix, which are all teleopctl's.
_MANIFEST: Final = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>{version}</version>
  <description>{description}</description>
  <maintainer email="{address}">{maintainer}</maintainer>
  <license>{license}</license>
{dependencies}  <export>
    <build_type>ament_python</build_type>
  </export>
</package>
"""


# A type of another package in a definition, such as ``std_msgs/Header header``.
_NAMED_TYPE: Final = re.compile(r"^\s*([a-z]\w*)/", re.MULTILINE)
_CLASS: Final = '  <class name="{name}" type="{name}" base_class_type="{base}"/>\n'


class Manifest(NamedTuple):
    """Content of a ``package.xml``.

    Attributes:
        name: Name of the package.
        version: Version of the package.
        description: One line about the package.
        license: License of the package's files.
        maintainer: Name of the maintainer.
        address: E-mail address of the maintainer.
        has_interfaces: Whether the package defines messages, services or actions.
    """

    name: str
    version: str
    description: str
    license: str = "Apache-2.0"
    maintainer: str = "The teleopctl authors"
    address: str = "teleopctl@users.noreply.github.com"
    has_interfaces: bool = False

    def xml(self) -> str:
        """Return the text of the ``package.xml``."""
        from html import escape

        group = "  <member_of_group>rosidl_interface_packages</member_of_group>\n"
        texts = {key: escape(text) for key, text in self._asdict().items() if isinstance(text, str)}
        return _MANIFEST.format(**texts, dependencies=group if self.has_interfaces else "")


def own_names() -> set[str]:
    """Return the names of teleopctl's own packages: of files, programs, modules and interfaces."""
    return {
        *_table(),
        *(name.rpartition("/")[0] for name in plugins.NODES.builtin),
        *(e.name.removesuffix(".py") for e in os.scandir(_MODULES) if e.name[0] not in "._"),
        *(e.name for e in os.scandir(_DEFINITIONS) if e.name[0] not in "._" and e.is_dir()),
    }


@lru_cache(maxsize=1024)
def is_own(name: str) -> bool:
    """Return whether teleopctl has a package of this name."""
    return (
        name in _table()
        or any(node.startswith(f"{name}/") for node in plugins.NODES.builtin)
        or (name.isidentifier() and ((_MODULES / name).is_dir() or (_DEFINITIONS / name).is_dir()))
    )


def data_folder(name: str) -> Path | None:
    """Return the folder of an own package that has files; None for the other packages."""
    if name not in DATA_PACKAGES:
        return None
    folder = HERE / "share" / name
    return folder if folder.is_dir() else HERE.parent / DATA_PACKAGES[name]


def share_path(name: str) -> Path:
    """Return the share folder of an own package; without `data_folder` it may not exist yet."""
    folder = data_folder(name)
    if folder is None or (_DEFINITIONS / name).is_dir():
        return own_prefix_path() / "share" / name
    return folder


def own_prefix_path() -> Path:
    """Return the path of the install prefix of teleopctl's packages, which may not exist yet."""
    from binascii import crc32

    # The programs start this Python, and the types are those of the distribution, by default Jazzy.
    made_of = [sys.executable, str(HERE), os.environ.get("ROS_DISTRO") or "jazzy"]
    made_of += [str(source.stat().st_mtime_ns) for source in _SOURCES]
    return Path(cache_dir(), "prefix", f"{crc32(os.fsencode(os.pathsep.join(made_of))):08x}")


def own_prefix() -> Path:
    """Return the install prefix of teleopctl's packages, written if it does not exist.

    Raises:
        SystemFailureError: The prefix cannot be written.
        UsageError: ``ROS_DISTRO`` is a distribution whose types are not known.
    """
    prefix = own_prefix_path()
    if prefix.is_dir():
        return prefix
    import shutil
    import tempfile

    try:
        prefix.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(dir=prefix.parent))
        try:
            _write_prefix(draft)
            draft.rename(prefix)
        finally:
            shutil.rmtree(draft, ignore_errors=True)
    except OSError as error:
        if not prefix.is_dir():  # else another process has just written it
            raise SystemFailureError(f"{prefix} cannot be written: {error}") from error
    return prefix


def is_own_prefix(prefix: str) -> bool:
    """Return whether a folder is an install prefix that a teleopctl has written."""
    return os.path.isfile(os.path.join(prefix, _MARK))  # noqa: PTH113, PTH118 -- for speed


def _write_prefix(prefix: Path) -> None:
    index, share = prefix / INDEX, prefix / "share"
    (index / "packages").mkdir(parents=True)
    (index / "rosidl_interfaces").mkdir()
    interfaces = plugins.import_object(plugins.WRITE_DEFINITIONS)(share)
    for package, files in interfaces.items():
        (index / "rosidl_interfaces" / package).write_text("\n".join(files), encoding="utf-8")
    records = _table()
    for name in own_names():
        (index / "packages" / name).touch()
        folder = data_folder(name)
        if folder is not None:
            if name in interfaces:  # already a folder
                for entry in folder.iterdir():
                    link(share / name / entry.name, entry)
            else:
                link(share / name, folder)
            continue
        version, description = records.get(name) or (_own_version(), f"{name}, by teleopctl")
        manifest = Manifest(name, version, description, has_interfaces=name in interfaces)
        (share / name).mkdir(exist_ok=True)
        (share / name / "package.xml").write_text(manifest.xml(), encoding="utf-8")
    for node in plugins.NODES.builtin:
        package, _, name = node.rpartition("/")
        program = prefix / "lib" / package / name
        program.parent.mkdir(parents=True, exist_ok=True)
        program.write_text(starter(package, name, None), encoding="utf-8")
        program.chmod(0o700)
    _write_dependencies(index, share, interfaces)
    _write_plugins(index, share)
    (prefix / _MARK).touch()


def _write_dependencies(index: Path, share: Path, interfaces: Mapping[str, Iterable[str]]) -> None:
    """Write the resources with run dependencies; those of interfaces are the types they name."""
    (index / RUN_DEPENDENCIES).mkdir()
    for name in own_names():
        needed = {
            package
            for file in interfaces.get(name, ())
            if (definition := share / name / file).suffix != ".idl" and definition.is_file()
            for package in _NAMED_TYPE.findall(definition.read_text(encoding="utf-8"))
        }
        text = ";".join(sorted(needed - {name}))
        (index / RUN_DEPENDENCIES / name).write_text(text, encoding="utf-8")


def _write_plugins(index: Path, share: Path) -> None:
    """Write the descriptions of controllers and hardware components, and their resources."""
    for category, base, plugin_names in (
        ("controller_interface", "ControllerInterface", plugins.CONTROLLERS.builtin),
        ("hardware_interface", "SystemInterface", plugins.HARDWARE.builtin),
    ):
        folder = index / f"{category}{PLUGIN_RESOURCE}"
        folder.mkdir()
        classes: dict[str, list[str]] = {}
        for name in plugin_names:
            package, slash, _ = name.partition("/")
            if slash:
                classes.setdefault(package, []).append(
                    _CLASS.format(name=name, base=f"{category}::{base}")
                )
        for package, lines in classes.items():
            if data_folder(package) is not None:
                continue
            (share / package).mkdir(exist_ok=True)
            file = f"{category}_plugins.xml"
            text = f'<library path="{package}">\n{"".join(lines)}</library>\n'
            (share / package / file).write_text(text, encoding="utf-8")
            (folder / package).write_text(f"share/{package}/{file}\n", encoding="utf-8")


def _own_version() -> str:
    """Return teleopctl's version."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("teleopctl")
    except PackageNotFoundError:  # a checkout that is not installed
        return "0.0.0"


@lru_cache(maxsize=1)
def _table() -> dict[str, tuple[str, str]]:
    """Return version and description by package name."""
    rows = (line.split(" ", 2) for line in _TABLE.read_text(encoding="utf-8").splitlines())
    return {name: (version, description) for name, version, description in rows}
