"""Registered parse methods of actions and substitutions, and their use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ..action import Action
from ..substitution import Substitution

# Any: what a method returns is a class and its constructor arguments.
Methods = dict[str, Callable[..., Any]]

action_parse_methods: Methods = {}
substitution_parse_methods: Methods = {}


# Any: the entity and the parser of a text front end.
def instantiate_action(entity: Any, parser: Any) -> Action:
    """Return the action for an entity of a launch file.

    Raises:
        RuntimeError: No parse method of that name is registered.
    """
    if entity.type_name not in action_parse_methods:
        raise RuntimeError(f"Unrecognized entity of the type: {entity.type_name}")
    kind, kwargs = action_parse_methods[entity.type_name](entity, parser)
    made: Action = kind(**kwargs)
    return made


# Any: texts with substitutions.
def instantiate_substitution(type_name: str, args: Iterable[Any] | None = None) -> Substitution:
    """Return the substitution for a name and its arguments.

    Raises:
        RuntimeError: No parse method of that name is registered.
    """
    if type_name not in substitution_parse_methods:
        raise RuntimeError(f"Unknown substitution: {type_name}")
    kind, kwargs = substitution_parse_methods[type_name](list(args or ()))
    made: Substitution = kind(**kwargs)
    return made
