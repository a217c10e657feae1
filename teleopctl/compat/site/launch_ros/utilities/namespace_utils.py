"""``launch_ros.utilities.namespace_utils``: namespaces as texts, any of which may be None."""

from __future__ import annotations

from typing import overload


def is_namespace_absolute(ns: str) -> bool:
    """Return whether a namespace is absolute; False for None."""
    return ns.startswith("/")


def is_root_namespace(ns: str) -> bool:
    """Return whether a namespace is the root."""
    return ns == "/"


def prefix_namespace(base_ns: str | None, ns: str | None) -> str | None:
    """Return a namespace below another one; an absolute namespace as it is."""
    if ns is None:
        return base_ns if base_ns is None or is_root_namespace(base_ns) else base_ns.rstrip("/")
    if base_ns and not is_namespace_absolute(ns):
        ns = f"{base_ns.rstrip('/')}/{ns}"
    return ns if is_root_namespace(ns) else ns.rstrip("/")


@overload
def make_namespace_absolute(ns: None) -> None: ...
@overload
def make_namespace_absolute(ns: str) -> str: ...
def make_namespace_absolute(ns: str | None) -> str | None:
    """Return a namespace with a leading slash."""
    return ns if ns is None or is_namespace_absolute(ns) else f"/{ns}"
