"""Conversion of steps of `teleopctl.launch` to the actions of Python launch files."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from typing import Any, TypeVar

from teleopctl import launch as model
from teleopctl.errors import TeleopctlError
from teleopctl.launch import Element, Template, boolean, read_step

from ..action import Action
from ..conditions import IfCondition, UnlessCondition
from ..substitution import Substitution
from ..substitutions.text_substitution import TextSubstitution
from .parse_substitution import substitutions_of

# Any: constructor arguments differ from class to class.
Words = Callable[[Any], "dict[str, Any] | Action"]
_Maker = TypeVar("_Maker", bound=Words)

_known: dict[type[model.Action], tuple[type[Action], Words]] = {}
_read_as: dict[type[Action], tuple[str, type[model.Action]]] = {}
# Modules that register the classes of ROS 2, imported when first needed.
_TABLES = ("launch.frontend.known_actions", "launch_ros.known_actions")


def is_known_as(
    name: str, kind: type[model.Action], made: type[Action]
) -> Callable[[_Maker], _Maker]:
    """Return a decorator that registers a function returning constructor arguments of an action.

    Args:
        name: Name of the action in a launch file.
        kind: Class of the action in `teleopctl.launch`.
        made: Class of the action in Python launch files.
    """

    def decorate(words: _Maker) -> _Maker:
        _known[kind] = made, words
        _read_as[made] = name, kind
        return words

    return decorate


class ReadStep(Action):
    """Step of a launch file that has no action class in Python.

    Args:
        step: The entry.
    """

    def __init__(self, step: model.Step) -> None:
        super().__init__()
        self._step = step

    def model_action(self) -> model.Action:
        """Return the step as an action of `teleopctl.launch`."""
        return model.IncludeSteps(steps=(self._step,), arguments=())


def action_of(step: model.Step) -> Action:
    """Return the action of a Python launch file for a step."""
    _look_up()
    known = next((_known[kind] for kind in type(step.action).__mro__ if kind in _known), None)
    if known is None or len(step.conditions) > 1:
        return ReadStep(step)
    kind, words = known
    found = words(step.action)
    made = found if isinstance(found, Action) else kind(**found)
    for condition in step.conditions:
        of = IfCondition if condition.expected else UnlessCondition
        made._condition = of(text(condition.text))  # noqa: SLF001 -- of the class above
    made.defined_at = step.place
    return made


# Any: arguments of `the` class.
def words_of(
    made: type[Action], element: Element, ignore: Collection[str] = ()
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the constructor arguments of an action class, and the attributes that they come from.

    Args:
        made: The class, or one that derives from it.
        element: Element of the launch file; other attributes are ignored.
        ignore: Keys to leave alone as well.

    Raises:
        TeleopctlError: The element is invalid.
    """
    _look_up()
    known = next((_read_as[base] for base in made.__mro__ if base in _read_as), None)
    if known is None:
        return {}, ()
    name, kind = known
    keys = tuple(key for key in kind.keys if key not in ignore)
    given = {
        key: value
        for key, value in element.fields(keys).items()
        if key.replace("-", "_") in {known_key.replace("-", "_") for known_key in keys}
    }
    # Attributes that the caller reads itself are optional here.
    given |= {key: Element(key, element.place, key) for key in ignore}
    step = read_step(name, Element(given, element.place, element.path))
    words = _known[kind][1](step.action)
    assert isinstance(words, dict)
    return {word: value for word, value in words.items() if word not in ignore}, keys


def _look_up() -> None:
    for name in _TABLES:
        importlib.import_module(name)


def text(template: Template) -> list[Substitution]:
    """Return a template as a list of at least one substitution."""
    return substitutions_of(template) or [TextSubstitution(text="")]


def pairs(
    given: Iterable[tuple[Template, Template]],
) -> dict[tuple[Substitution, ...], list[Substitution]]:
    """Return names and values, as substitutions."""
    return {tuple(text(name)): text(value) for name, value in given}


def flag_or_text(template: Template) -> bool | list[Substitution]:
    """Return a truth value if the template is one, else substitutions."""
    if template.is_literal:
        with suppress(TeleopctlError):
            return boolean(template.source)
    return text(template)


def number_or_text(template: Template) -> float | list[Substitution]:
    """Return a number if the template is one, else substitutions."""
    if template.is_literal:
        with suppress(ValueError):
            return float(template.source)
    return text(template)
