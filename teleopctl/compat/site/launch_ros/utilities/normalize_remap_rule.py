"""``launch_ros.utilities.normalize_remap_rule``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from launch.utilities import ensure_argument_type, normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..remap_rule_type import RemapRule, SomeRemapRule, SomeRemapRules


def normalize_remap_rule(remap_rule: SomeRemapRule) -> RemapRule:
    """Return the two names of a remapping as substitutions.

    Raises:
        TypeError: It is no tuple of two.
    """
    ensure_argument_type(remap_rule, tuple, "remap_rule")
    if len(remap_rule) != 2:
        raise TypeError(f"remap_rule must be a tuple of length 2, got length {len(remap_rule)}")
    source, target = remap_rule
    return (
        tuple(normalize_to_list_of_substitutions(source)),
        tuple(normalize_to_list_of_substitutions(target)),
    )


def normalize_remap_rules(remap_rules: SomeRemapRules) -> Iterator[RemapRule]:
    """Yield the remappings as substitutions; see `normalize_remap_rule`."""
    yield from map(normalize_remap_rule, remap_rules)
