"""What Tab offers for types and their packages."""

from __future__ import annotations


def interface_types(incomplete: str) -> list[str]:
    """Return the full names of messages, services and actions."""
    from teleopctl.interfaces import list_types

    return [name for name in list_types() if name.startswith(incomplete)]


def interface_packages(incomplete: str) -> list[str]:
    """Return the packages with interfaces."""
    return sorted({name.split("/", 1)[0] for name in interface_types(incomplete)})
