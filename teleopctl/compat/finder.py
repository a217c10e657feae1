"""Finds the message packages of ROS 2 that are not installed.

After ``install``, Python can import ``<package>.msg``, ``<package>.srv`` and ``<package>.action``
of each package whose interface definitions are found, the Python modules of ROS packages, and those
that generate_parameter_library makes.
Message classes are created when they are first used. Really installed packages always have
precedence.

Every Python process with ``rclpy`` imports this module. So it does not import ``typing``,
``collections`` and ``importlib.abc``, which would take most of its import time.
"""

from __future__ import annotations

import sys
from _thread import get_ident
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

from teleopctl.compat.interface_modules import (
    KINDS,
    InterfaceModule,
    PackageModule,
    class_names,
    has_package,
    unknown_name,
)
from teleopctl.compat.parameter_modules import ParameterModuleFinder

TYPE_CHECKING = False  # type checkers treat this name like typing's constant
if TYPE_CHECKING:
    from collections.abc import Sequence

_LOOKED_FOR_AT_START = ("sitecustomize", "usercustomize")
"""Modules that each Python imports at start-up, for which a search would be useless."""

_JYTHON = "org"
"""Package of Jython that Python's module ``copy``, loaded by almost every program, looks for."""

_USUAL_ENDINGS = ("_msgs", "_srvs", "_interfaces")

_searching: set[int] = set()
"""Identifiers of the threads that search for definitions or packages."""


class _Loader:
    """Loader of the modules of a package that has interface definitions."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return a new module for an interface package, its ``msg`` and so on, or a definition."""
        return InterfaceModule(spec.name) if "." in spec.name else PackageModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: classes of the module are created when they are first used."""


class _PackageFinder:
    """Finder of ``<package>``, after Python's own finders.

    The Python module of a source package has precedence; `_KindFinder` still finds its interfaces.
    For an installed package, interfaces have precedence: its module has the classes that ROS's
    generator made for ROS's own libraries.
    """

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the import spec of a ROS package, by its Python module or interfaces; or None.

        Raises:
            ModuleNotFoundError: The search for definitions fails, and the name is that of a message
                package.
        """
        if "." in fullname or fullname in _LOOKED_FOR_AT_START or _is_asked_by_python(fullname):
            return None
        from teleopctl.errors import TeleopctlError

        try:
            return (
                _module_spec(fullname, installed=False)
                or _interface_spec(fullname)
                or _module_spec(fullname, installed=True)
            )
        except TeleopctlError as error:
            # The error must not affect imports of other modules.
            if not fullname.endswith(_USUAL_ENDINGS):
                return None
            raise ModuleNotFoundError(
                f"No module named {fullname!r}: {error.message}", name=fullname
            ) from error


class _KindFinder:
    """Finder of ``<package>.msg`` and its submodules.

    This finder precedes Python's own path finder, and calls that itself: for the path finder, the
    folder ``msg/`` with the definitions of a source package is an empty namespace package.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the import spec of a package's ``msg``, ``srv`` or ``action`` or below; or None.

        Raises:
            ImportError: A package of this finder has no class of that name.
        """
        top, _, rest = fullname.partition(".")
        if rest.split(".", 1)[0] not in KINDS or rest.count(".") > 1:
            return None
        if isinstance(sys.modules.get(top), PackageModule) or not _is_installed(fullname, path):
            return _interface_spec(fullname)
        return None


class _RegularFinder:
    """Finder of the Python module of a source package that a folder of its name would hide.

    In a workspace's ``src``, from which tests are run, the folder ``my_package`` around the module
    ``my_package`` is a namespace package for Python. In ROS 2 the installed module has precedence.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of Python's path finder, or of a source package instead of a folder."""
        if "." in fullname:
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is None or spec.loader is not None:
            return spec
        from teleopctl.errors import TeleopctlError

        try:
            return _module_spec(fullname, installed=False)
        except TeleopctlError:
            # The error must not affect imports of other modules.
            return None


def install() -> None:
    """Make message packages importable in this process. Idempotent."""
    if not any(isinstance(finder, _KindFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _KindFinder())
        if PathFinder in sys.meta_path:
            sys.meta_path.insert(sys.meta_path.index(PathFinder), _RegularFinder())
        sys.meta_path += [_PackageFinder(), ParameterModuleFinder()]


def _is_asked_by_python(fullname: str) -> bool:
    """Return whether Python's library tries a module of another system: Windows', or Jython's."""
    if fullname in sys.stdlib_module_names:
        return True
    copying = sys.modules.get("copy")
    return fullname == _JYTHON and copying is not None and not hasattr(copying, "PyStringMap")


def _interface_spec(fullname: str) -> ModuleSpec | None:
    # The search for definitions imports modules, some of which try optional imports.
    thread = get_ident()
    if thread in _searching:
        return None
    _searching.add(thread)
    try:
        known = _is_interface_module(fullname)
    finally:
        _searching.remove(thread)
    if not known:
        return None
    return ModuleSpec(fullname, _Loader(), is_package=True)  # type: ignore[arg-type]  # by methods


def _module_spec(fullname: str, *, installed: bool) -> ModuleSpec | None:
    thread = get_ident()
    if thread in _searching or fullname.startswith("_") or not fullname.isascii():
        return None
    from teleopctl.packages import installed_module_roots, source_module_root

    _searching.add(thread)
    try:
        if installed:
            roots = installed_module_roots(fullname)
        else:
            root = source_module_root(fullname)
            roots = () if root is None else (root,)
    finally:
        _searching.remove(thread)
    if not roots:
        return None
    spec = PathFinder.find_spec(fullname, [str(root) for root in roots])
    return spec if spec is not None and spec.loader is not None else None


def _is_interface_module(fullname: str) -> bool:
    package, _, rest = fullname.partition(".")
    kind, _, single = rest.partition(".")
    if not has_package(package, kind or None):
        return False
    if single[:1].isupper():
        # Python searches for a module of that name when ``from package.msg import Name`` finds no
        # class: the only chance to suggest similar names.
        module = fullname.rpartition(".")[0]
        raise ImportError(unknown_name(single, module), name=module)
    return not single or bool(class_names(fullname))


def _is_installed(fullname: str, path: Sequence[str] | None) -> bool:
    """Return whether a real module exists; a folder with only definitions does not count."""
    spec = PathFinder.find_spec(fullname, path)
    return spec is not None and spec.loader is not None
