"""``launch.frontend.parser``: what actions and substitutions of one's own are read with."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._methods import action_parse_methods, instantiate_action
from .entity import Entity
from .parse_substitution import (
    parse_if_substitutions,
    parse_substitution,
    replace_escaped_characters,
)

if TYPE_CHECKING:
    from ..action import Action
    from ..substitution import Substitution


class Parser:
    """Reads what stands in a launch file that is a text; `launch_xml` and such need none."""

    def parse_action(self, entity: Entity) -> Action:
        """Return an action, of one's own or of ROS 2."""
        if entity.type_name in action_parse_methods:
            return instantiate_action(entity, self)
        return entity.known_action()

    def parse_substitution(self, value: str) -> list[Substitution]:
        """Return the substitutions that a text consists of."""
        return parse_substitution(value)

    # Any: a value of whatever type stands in a launch file.
    def parse_if_substitutions(self, value: Any) -> Any:
        """Return a value with its texts as substitutions, where there are some in them."""
        return parse_if_substitutions(value)

    def escape_characters(self, value: str) -> str:
        """Return a text without backslashes that take the meaning from what follows them."""
        return replace_escaped_characters(value)
