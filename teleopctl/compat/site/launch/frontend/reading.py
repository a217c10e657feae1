"""Actions and substitutions of one's own that stand in a launch file that is a text."""

from __future__ import annotations

from teleopctl.errors import TeleopctlError
from teleopctl.launch import Call, Element, Step, Template

from .._entities import steps
from .._places import blamed
from .._texts import template
from ._methods import instantiate_action, instantiate_substitution
from .entity import Entity
from .parse_substitution import substitutions_of
from .parser import Parser


def read_action(name: str, content: Element) -> Step:
    """Return the action that stands in a text, where it stands there."""
    entity = Entity(name, content)
    try:
        action = instantiate_action(entity, Parser())
        entity.assert_entity_completely_parsed()
        action.defined_at = content.place
        (step,) = steps(action)
    except TeleopctlError:
        raise
    except Exception as error:
        raise content.error(blamed(error, name).message) from error
    return step


def read_substitution(call: Call) -> Template:
    """Return the substitution that stands in a text, as the model has it."""
    arguments = [substitutions_of(argument.template) for argument in call.arguments]
    return template(instantiate_substitution(call.name, arguments))
