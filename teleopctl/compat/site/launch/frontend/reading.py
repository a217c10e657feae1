"""Registered actions and substitutions in XML and YAML launch files."""

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
    """Return the step of a registered action for an element of a launch file."""
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
    """Return the template of a registered substitution for a call in a launch file."""
    arguments = [substitutions_of(argument.template) for argument in call.arguments]
    return template(instantiate_substitution(call.name, arguments))
