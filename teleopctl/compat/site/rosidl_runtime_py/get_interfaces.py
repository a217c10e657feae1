"""``rosidl_runtime_py.get_interfaces``. Lists of types and their files."""

from collections.abc import Iterable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import rosidl_runtime_py
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import definition_file, list_types
from teleopctl.packages import lookup_package


def get_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Return the types of packages, such as ``msg/String``; of all packages if none is named.

    Raises:
        LookupError: A package is not known.
    """
    return _types(package_names, None)


def get_message_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Return the messages of packages; see `get_interfaces`."""
    return _types(package_names, "msg")


def get_service_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Return the services of packages; see `get_interfaces`."""
    return _types(package_names, "srv")


def get_action_interfaces(package_names: Iterable[str] = ()) -> dict[str, list[str]]:
    """Return the actions of packages; see `get_interfaces`."""
    return _types(package_names, "action")


def get_interface_packages() -> dict[str, str]:
    """Return the packages that have types, each with the folder below which it is found."""
    return {package: _prefix(package) for package in sorted(_types((), None))}


def get_interface_path(interface_name: str) -> str:
    """Return the path of the file that defines a type.

    Args:
        interface_name: ``package/kind/Name``, with or without the ending of the file.

    Raises:
        ValueError: That is no such name.
        LookupError: There is no such package, or it has no such type.
    """
    parts = interface_name.split("/")
    if len(parts) < 2:
        raise ValueError(
            f"Invalid name '{interface_name}'. Expected at least two parts separated by '/'"
        )
    if not all(parts):
        raise ValueError(f"Invalid name '{interface_name}'. Must not contain empty parts")
    if ".." in parts:
        raise ValueError(f"Invalid name '{interface_name}'. Must not contain '..'")
    _types(parts[:1], None)
    name, _, ending = interface_name.partition(".")
    if len(parts) == 3:
        with suppress(TeleopctlError):
            file = definition_file(name)
            if ending in ("", parts[1], file.suffix[1:]):
                return str(file)
    # ROS 2 searches for the file that a build generates.
    missing = interface_name if ending else f"{interface_name}.idl"
    raise LookupError(f"Could not find the interface '{missing}'")


def _prefix(package: str) -> str:
    found = lookup_package(package)
    return str(Path(rosidl_runtime_py.__file__).parents[1] if found is None else found.share)


def _is_module(package: str) -> bool:
    """Return whether a package is a Python module only, as rclpy is here."""
    return package.isidentifier() and find_spec(package) is not None


def _types(package_names: Iterable[str], kind: str | None) -> dict[str, list[str]]:
    known: dict[str, list[str]] = {}
    for full_name in list_types():
        package, _, name = full_name.partition("/")
        known.setdefault(package, []).append(name)
    wanted = list(package_names)
    for package in wanted:
        if not (package in known or lookup_package(package) or _is_module(package)):
            raise LookupError(f"Unknown package '{package}'")
    fitting = {
        package: [name for name in known.get(package, ()) if kind in (None, name.split("/")[0])]
        for package in wanted or known
    }
    return {package: names for package, names in fitting.items() if names}
