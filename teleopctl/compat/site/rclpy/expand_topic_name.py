"""``rclpy.expand_topic_name``. Absolute forms of names."""

from teleopctl.node import (
    NameValidationException,
    expand_unchecked,
    validate_name,
    validate_namespace,
    validate_node_name,
)

__all__ = ["expand_topic_name"]


def expand_topic_name(topic_name: str, node_name: str, node_namespace: str) -> str:
    """Return the absolute name of a topic as a node means it; it may still break a rule.

    Raises:
        ValueError: One of the three breaks a rule, or there is no such substitution.
    """
    try:
        validate_name(topic_name)
        validate_node_name(node_name)
        validate_namespace(node_namespace)
    except NameValidationException as error:
        kind = "node namespace" if error.kind == "namespace" else error.kind
        raise ValueError(f"{kind} '{error.name}' is invalid: {error.error_msg}") from error
    return expand_unchecked(topic_name, node_name, node_namespace)
