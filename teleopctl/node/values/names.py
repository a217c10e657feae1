"""Rules and expansion of node, topic and service names.

Source: the ROS 2 design article on topic and service names, and the name validation of rcl (names
that are not expanded yet) and rmw (absolute names, namespaces, nodes), with their order of checks
and their messages, which contain "topic name" for services too. A name is relative (``chatter``),
absolute (``/chatter``) or private (``~/chatter``) and is expanded against the namespace and the
name of its node.
"""

from __future__ import annotations

from itertools import pairwise

from teleopctl.base.typed import Final
from teleopctl.node.values.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NameValidationException,
    UnknownSubstitutionError,
)

# Limits of rmw (rmw/validate_*.h), in characters.
_LONGEST_TOPIC: Final = 247
_LONGEST_NAMESPACE: Final = 245
_LONGEST_NODE: Final = 255

# Without re, whose import takes longer than the validation of all names of a node.
_DIGITS: Final = frozenset("0123456789")
_LETTERS: Final = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
_NAME_CHARACTERS: Final = _LETTERS | _DIGITS | {"_"}


def validate_node_name(name: str) -> None:
    """Raise InvalidNodeNameException if a node name breaks a rule.

    Raises:
        InvalidNodeNameException: A rule is broken; the message has rule and position.
    """
    if not name:
        raise InvalidNodeNameException(name, "node name must not be empty", 0)
    if (bad := _first_outside(_NAME_CHARACTERS, name)) is not None:
        reason = "node name must not contain characters other than alphanumerics or '_'"
        raise InvalidNodeNameException(name, reason, bad)
    if name[0].isdigit():
        raise InvalidNodeNameException(name, "node name must not start with a number", 0)
    if len(name) > _LONGEST_NODE:
        reason = f"node name length should not exceed '{_LONGEST_NODE}'"
        raise InvalidNodeNameException(name, reason, _LONGEST_NODE - 1)


def _first_outside(allowed: frozenset[str], text: str) -> int | None:
    """Return the index of the first character that is not allowed; None if all are."""
    return next((at for at, letter in enumerate(text) if letter not in allowed), None)


def _first_after_slash(forbidden: frozenset[str], text: str) -> int | None:
    """Return the index of the first forbidden character after a slash, None without one."""
    pairs = enumerate(pairwise(text), start=1)
    return next((at for at, (one, next_) in pairs if one == "/" and next_ in forbidden), None)


def validate_name(name: str, *, is_service: bool = False) -> None:
    """Raise an exception if a topic or service name, not yet expanded, breaks a rule.

    Raises:
        InvalidTopicNameException: A topic name breaks a rule; the message has rule and position.
        InvalidServiceNameException: A service name breaks a rule.
    """
    if (broken := _first_problem(name)) is not None:
        raise _exception_of(is_service)(name, *broken)


def _first_problem(name: str) -> tuple[str, int] | None:
    """Return the first of rcl's rules that a name breaks and the position, or None."""
    if not name:
        return "topic name must not be empty string", 0
    if name[0] in _DIGITS:
        return "topic name token must not start with a number", 0
    if name.endswith("/"):
        return "topic name must not end with a forward slash", len(name) - 1
    opened: int | None = None  # index of the unclosed brace
    for index, character in enumerate(name):
        if opened is not None and character == "}":
            opened = None
        elif opened is not None:
            if index == opened + 1 and character in _DIGITS:
                return "substitution name must not start with a number", index
            if character == "~":
                return "topic name must not have tilde '~' unless it is the first character", index
            if character not in _NAME_CHARACTERS:
                reason = "substitution name must not contain characters other than alphanumerics"
                return f"{reason} or '_'", index
        elif character == "{":
            opened = index
        elif character == "}":
            return "topic name must not have unmatched (unbalanced) curly braces '{}'", index
        elif character == "~" and index:
            return "topic name must not have tilde '~' unless it is the first character", index
        elif character not in _NAME_CHARACTERS and character not in "/~":
            allowed = "alphanumerics, '_', '~', '{', or '}'"
            return f"topic name must not contain characters other than {allowed}", index
    if opened is not None:
        return "topic name must not have unmatched (unbalanced) curly braces '{}'", opened
    # rcl accepts a name that ends there, such as "~a".
    if name[0] == "~" and name[1:2] not in ("", "/"):
        reason = "topic name must not have a tilde '~' that is not followed by a forward slash '/'"
        return reason, 1
    if (number := _first_after_slash(_DIGITS, name)) is not None:
        return "topic name token must not start with a number", number
    return None


def validate_absolute_name(name: str, *, is_service: bool = False) -> None:
    """Raise an exception if an absolute topic or service name breaks a rule.

    Raises:
        InvalidTopicNameException: A topic name breaks a rule; the message has rule and position.
        InvalidServiceNameException: A service name breaks a rule.
    """
    error = _exception_of(is_service)
    _check_absolute(name, error, "topic name", "")
    if len(name) > _LONGEST_TOPIC:
        reason = f"topic length should not exceed '{_LONGEST_TOPIC}'"
        raise error(name, reason, _LONGEST_TOPIC - 1)


def validate_namespace(namespace: str) -> None:
    """Raise InvalidNamespaceException if an absolute namespace breaks a rule.

    Raises:
        InvalidNamespaceException: A rule is broken; the message has rule and position.
    """
    if namespace == "/":
        return
    _check_absolute(namespace, InvalidNamespaceException, "namespace", ", unless only a '/'")
    if len(namespace) > _LONGEST_NAMESPACE:
        reason = f"namespace should not exceed '{_LONGEST_NAMESPACE}'"
        raise InvalidNamespaceException(namespace, reason, _LONGEST_NAMESPACE - 1)


def _check_absolute(
    name: str, error: type[NameValidationException], what: str, exception: str
) -> None:
    """Raise ``error`` when an absolute name breaks a rule that topics and namespaces share."""
    if not name:
        raise error(name, f"{what} must not be empty", 0)
    if not name.startswith("/"):
        raise error(name, f"{what} must be absolute, it must lead with a '/'", 0)
    if name.endswith("/"):
        raise error(name, f"{what} must not end with a '/'{exception}", len(name) - 1)
    if (bad := _first_outside(_NAME_CHARACTERS | {"/"}, name)) is not None:
        reason = f"{what} must not contain characters other than alphanumerics, '_', or '/'"
        raise error(name, reason, bad)
    if (bad := _first_after_slash(_DIGITS | {"/"}, name)) is not None:
        if name[bad] == "/":
            raise error(name, f"{what} must not contain repeated '/'", bad)
        raise error(name, f"{what} must not have a token that starts with a number", bad)


def _exception_of(is_service: bool) -> type[NameValidationException]:
    return InvalidServiceNameException if is_service else InvalidTopicNameException


def absolute_namespace(namespace: str | None) -> str:
    """Return a namespace with its leading slash, checked; None and ``""`` give ``/``.

    Raises:
        InvalidNamespaceException: A rule is broken; the message has rule and position.
    """
    absolute = namespace if namespace and namespace.startswith("/") else f"/{namespace or ''}"
    validate_namespace(absolute)
    return absolute


def fully_qualified(namespace: str, name: str) -> str:
    """Return namespace and node name joined: ``("/", "talker")`` gives ``/talker``."""
    return f"{namespace.rstrip('/')}/{name}"


def expand_name(name: str, node_name: str, namespace: str, *, is_service: bool = False) -> str:
    """Return the absolute form of a topic or service name, checked and not yet remapped.

    Args:
        name: Relative, absolute or private name. ``{node}`` is replaced by the node's name,
            ``{ns}`` and ``{namespace}`` by the namespace with its leading slash.
        node_name: Name of the node that uses the name.
        namespace: Absolute namespace of that node.
        is_service: Whether the name is that of a service, which determines the exception.

    Raises:
        InvalidTopicNameException: A topic name breaks a rule.
        InvalidServiceNameException: A service name breaks a rule.
        UnknownSubstitutionError: Braces contain another word.
    """
    validate_name(name, is_service=is_service)
    expanded = expand_unchecked(name, node_name, namespace)
    validate_absolute_name(expanded, is_service=is_service)
    return expanded


def expand_unchecked(name: str, node_name: str, namespace: str) -> str:
    """Return the absolute form of a topic or service name, without checking its rules.

    Raises:
        UnknownSubstitutionError: Braces contain neither ``node`` nor ``ns`` nor ``namespace``.
    """
    substitutions = {"node": node_name, "ns": namespace, "namespace": namespace}
    if name.startswith("~"):
        name = fully_qualified(namespace, node_name) + name[1:]
    expanded, *others = name.split("{")
    for each in others:
        word, _, rest = each.partition("}")
        if word not in substitutions:
            raise UnknownSubstitutionError(name, f"{{{word}}}")
        expanded += substitutions[word] + rest
    return expanded if expanded.startswith("/") else fully_qualified(namespace, expanded)
