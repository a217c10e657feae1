"""Definitions of types as this program knows them, for topics that bring none."""

from __future__ import annotations

from teleopctl.bag.records import ROS2MSG, TypeText
from teleopctl.errors import TeleopctlError
from teleopctl.interfaces import complete_definition_text, known_types, type_hash


def known_definition(type_name: str, version: str = "") -> TypeText | None:
    """Return the definition of a type; None where it is not known, or in another version.

    Args:
        type_name: ``package/msg/Name``.
        version: The hash that it has to have; any if empty.
    """
    try:
        if known_types().find(type_name) is None or version not in ("", type_hash(type_name)):
            return None
        return TypeText(ROS2MSG, complete_definition_text(type_name))
    except TeleopctlError:
        return None
