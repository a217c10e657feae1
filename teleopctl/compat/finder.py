"""Import names of ROS 2 for programs that run under teleopctl.

``install`` lets Python find

- ``<package>.msg``, ``<package>.srv`` and ``<package>.action`` of every package whose interface
  definitions are known, with classes made when they are first used, and
- ``rclpy``, ``tf2_ros``, ``ament_index_python`` and the like, which are modules of teleopctl.

What is really installed always wins. Nothing is written anywhere, and no other process sees it.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from types import ModuleType

from teleopctl.compat.interface_modules import (
    KINDS,
    InterfaceModule,
    PackageModule,
    class_names,
    has_package,
    unknown_name,
)

# Import name → the module that serves it. Submodules follow unless they have an entry.
_ALIASES = {
    "rclpy": "teleopctl.compat.rclpy",
    "cv_bridge": "teleopctl.compat.cv_bridge",
    "sensor_msgs_py": "teleopctl.compat.sensor_msgs_py",
    "tf_transformations": "teleopctl.compat.tf_transformations",
    "tf2_geometry_msgs": "teleopctl.compat.tf2_geometry_msgs",
    "tf2_geometry_msgs.tf2_geometry_msgs": "teleopctl.compat.tf2_geometry_msgs",
    "tf2_py": "teleopctl.compat.tf2_py",
    "tf2_ros": "teleopctl.compat.tf2_ros",
    "tf2_ros.buffer": "teleopctl.tf.buffer",
    "tf2_ros.buffer_interface": "teleopctl.tf.conversions",
    "tf2_ros.static_transform_broadcaster": "teleopctl.tf.broadcaster",
    "tf2_ros.transform_broadcaster": "teleopctl.tf.broadcaster",
    "tf2_ros.transform_listener": "teleopctl.tf.listener",
    "ament_index_python": "teleopctl.compat.ament_index_python",
    "ament_index_python.packages": "teleopctl.compat.ament_index_python",
}

_searching = threading.local()


class _AliasLoader(Loader):
    """Puts an existing module under a second name."""

    def __init__(self, target: str) -> None:
        self._target = target

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave the making to Python: the module is replaced when it is executed."""

    def exec_module(self, module: ModuleType) -> None:
        """Put the module that serves the name in the place of the empty one."""
        served = import_module(self._target)
        if module.__name__ in _ALIASES and not hasattr(served, "__path__"):
            served.__path__ = []
        sys.modules[module.__name__] = served


class _InterfaceLoader(Loader):
    """Makes the modules of a package that has interface definitions."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Make the module of a package, of one of its kinds, or of a single definition."""
        return InterfaceModule(spec.name) if "." in spec.name else PackageModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: the classes come when they are asked for."""


class _FirstFinder(MetaPathFinder):
    """Serves what Python's own finders would look for in the wrong place.

    The submodules of an alias must not be loaded a second time from the alias' folder, and a
    source package without ``__init__.py`` must not hide its own interfaces.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find the module of an alias, or the ``msg``, ``srv`` or ``action`` of a package.

        Raises:
            ImportError: A package that is served here has no class of that name.
        """
        top, _, rest = fullname.partition(".")
        if top in _ALIASES:
            return _alias_spec(fullname)
        if rest.split(".", 1)[0] not in KINDS or rest.count(".") > 1:
            return None
        if isinstance(sys.modules.get(top), PackageModule) or not _is_installed(fullname, path):
            return _interface_spec(fullname)
        return None


class _LastFinder(MetaPathFinder):
    """Serves the package itself when nothing else does."""

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a package with interface definitions."""
        return None if "." in fullname else _interface_spec(fullname)


def install() -> None:
    """Let this process import the Python packages of ROS 2; once is enough, more does no harm."""
    if not any(isinstance(finder, _FirstFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _FirstFinder())
        sys.meta_path.append(_LastFinder())


def _alias_spec(fullname: str) -> ModuleSpec | None:
    top, _, rest = fullname.partition(".")
    if rest:
        served = sys.modules.get(top)
        if served is None or served.__name__ != _ALIASES[top]:
            return None
    elif _is_installed(top, None):
        return None
    target = _ALIASES.get(fullname) or f"{_ALIASES[top]}.{rest}"
    if find_spec(target) is None:
        return None
    return ModuleSpec(fullname, _AliasLoader(target), is_package=True)


def _interface_spec(fullname: str) -> ModuleSpec | None:
    # Looking for definitions imports modules, some of which try optional imports of their own.
    if getattr(_searching, "active", False):
        return None
    _searching.active = True
    try:
        known = _is_interface_module(fullname)
    finally:
        _searching.active = False
    if not known:
        return None
    return ModuleSpec(fullname, _InterfaceLoader(), is_package=True)


def _is_interface_module(fullname: str) -> bool:
    package, _, rest = fullname.partition(".")
    kind, _, single = rest.partition(".")
    if not has_package(package, kind or None):
        return False
    if single[:1].isupper():
        # Python asks for a module of that name when ``from package.msg import Name`` found no
        # class: the one chance to say which name was meant.
        module = fullname.rpartition(".")[0]
        raise ImportError(unknown_name(single, module), name=module)
    return not single or bool(class_names(fullname))


def _is_installed(fullname: str, path: Sequence[str] | None) -> bool:
    """Tell whether there is a real module; a mere folder of definitions is none."""
    spec = PathFinder.find_spec(fullname, path)
    return spec is not None and spec.loader is not None
