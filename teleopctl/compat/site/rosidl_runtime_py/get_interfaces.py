"""``rosidl_runtime_py.get_interfaces``. Which types there are."""

from collections.abc import Iterable

from teleopctl.interfaces import list_types


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


def get_interface_packages() -> list[str]:
    """Return the names of the packages that have types."""
    return sorted(_types((), None))


def _types(package_names: Iterable[str], kind: str | None) -> dict[str, list[str]]:
    known: dict[str, list[str]] = {}
    for full_name in list_types():
        package, _, name = full_name.partition("/")
        known.setdefault(package, []).append(name)
    wanted = list(package_names)
    for package in wanted:
        if package not in known:
            raise LookupError(f"Unknown package '{package}'")
    chosen = {package: known[package] for package in wanted} if wanted else known
    fitting = {
        package: [name for name in names if kind is None or name.startswith(f"{kind}/")]
        for package, names in chosen.items()
    }
    return {package: names for package, names in fitting.items() if names}
