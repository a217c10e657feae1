"""Names of nodes, topics and services: the rules and their expansion.

Source: the ROS 2 design article on topic and service names, and rcl's name validation. A name is
relative (``chatter``), absolute (``/chatter``) or private (``~/chatter``) and is expanded against
the namespace and the name of its node.
"""

from __future__ import annotations

import re

from teleopctl.node.values.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NameValidationException,
)

_SUBSTITUTION = re.compile(r"\{([^{}]*)\}")


def validate_node_name(name: str) -> None:
    """Check the name of a node.

    Raises:
        InvalidNodeNameException: The name is empty or has a character that is not allowed.
    """
    if not name:
        raise InvalidNodeNameException(name, "node name must not be empty", 0)
    if bad := re.search(r"[^A-Za-z0-9_]", name):
        reason = "node name must not contain characters other than alphanumerics or '_'"
        raise InvalidNodeNameException(name, reason, bad.start())
    if name[0].isdigit():
        raise InvalidNodeNameException(name, "node name must not start with a number", 0)


def _check_absolute(name: str, error: type[NameValidationException]) -> None:
    """Raise ``error`` when an absolute name breaks a rule."""
    kind = error.kind
    if not name.startswith("/"):
        raise error(name, f"{kind} must be absolute, it must lead with a '/'", 0)
    if name.endswith("/"):
        raise error(name, f"{kind} must not end with a '/'", len(name) - 1)
    if bad := re.search(r"[^A-Za-z0-9_/]", name):
        reason = f"{kind} must not contain characters other than alphanumerics, '_', or '/'"
        raise error(name, reason, bad.start())
    if "//" in name:
        raise error(name, f"{kind} must not contain repeated '/'", name.index("//") + 1)
    if number := re.search(r"/\d", name):
        reason = f"{kind} token must not start with a number"
        raise error(name, reason, number.start() + 1)


def validate_absolute_name(name: str, *, is_service: bool = False) -> None:
    """Check an absolute topic or service name.

    Raises:
        InvalidTopicNameException: A rule is broken (topics).
        InvalidServiceNameException: A rule is broken (services).
    """
    _check_absolute(name, InvalidServiceNameException if is_service else InvalidTopicNameException)


def absolute_namespace(namespace: str | None) -> str:
    """Return a node's namespace with its leading slash; None and ``""`` are the root.

    Raises:
        InvalidNamespaceException: A rule is broken; the message says which and where.
    """
    if namespace in (None, "", "/"):
        return "/"
    assert namespace is not None
    absolute = namespace if namespace.startswith("/") else f"/{namespace}"
    _check_absolute(absolute, InvalidNamespaceException)
    return absolute


def fully_qualified(namespace: str, name: str) -> str:
    """Join a namespace and a node name: ``("/", "talker")`` is ``/talker``."""
    return f"{namespace.rstrip('/')}/{name}"


def expand_name(name: str, node_name: str, namespace: str, *, is_service: bool = False) -> str:
    """Return the absolute form of a topic or service name, before remapping.

    Args:
        name: Relative, absolute or private name; ``{node}``, ``{ns}`` and ``{namespace}`` stand
            for those of the node.
        node_name: Name of the node that uses it.
        namespace: Absolute namespace of that node.
        is_service: Says which of the two exceptions tells of a broken rule.

    Raises:
        InvalidTopicNameException: A rule is broken (topics).
        InvalidServiceNameException: A rule is broken (services).
    """
    error = InvalidServiceNameException if is_service else InvalidTopicNameException
    if not name:
        raise error(name, f"{error.kind} must not be empty", 0)
    substitutions = {"node": node_name, "ns": namespace, "namespace": namespace}

    def replace(match: re.Match[str]) -> str:
        if match[1] not in substitutions:
            raise error(name, f"unknown substitution '{match[1]}'", match.start())
        value = substitutions[match[1]].rstrip("/")
        # A namespace at the beginning makes the name absolute.
        return value if match.start() == 0 else value.lstrip("/")

    expanded = _SUBSTITUTION.sub(replace, name)
    if expanded == "~" or expanded.startswith("~/"):
        expanded = fully_qualified(namespace, node_name) + expanded[1:]
    elif not expanded.startswith("/"):
        expanded = fully_qualified(namespace, expanded)
    _check_absolute(expanded, error)
    return expanded
