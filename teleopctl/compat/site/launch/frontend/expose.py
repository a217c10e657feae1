"""``launch.frontend.expose``: decorators that register actions and substitutions by name."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import FunctionType, MethodType
from typing import Any, TypeVar

from teleopctl.launch import (
    Call,
    Element,
    Step,
    Template,
    exposed_actions,
    exposed_substitutions,
)

from ._methods import (
    Methods,
    action_parse_methods,
    instantiate_action,
    instantiate_substitution,
    substitution_parse_methods,
)

__all__ = [
    "action_parse_methods",
    "expose_action",
    "expose_substitution",
    "instantiate_action",
    "instantiate_substitution",
    "substitution_parse_methods",
]

_Exposed = TypeVar("_Exposed")


def __expose_impl(  # the original's name, which its tests import
    name: str, parse_methods_map: Methods, exposed_type: str
) -> Callable[[_Exposed], _Exposed]:
    def decorate(exposed: _Exposed) -> _Exposed:
        method: Callable[..., Any] | None = None
        if isinstance(exposed, type):
            method = getattr(exposed, "parse", None)
            if not isinstance(method, MethodType):
                raise RuntimeError(
                    "Did not find a class method called 'parse' in the class being decorated."
                )
        elif isinstance(exposed, FunctionType):
            method = exposed
        if method is None:
            raise RuntimeError(
                f"Exposed {exposed_type} parser for {name} is not a callable or a class"
                " containing a parse method"
            )
        if parse_methods_map.get(name, method) != method:
            raise RuntimeError(
                f"Two {exposed_type} parsing methods exposed with the same name: [{name}]."
            )
        parse_methods_map[name] = method
        if parse_methods_map is action_parse_methods:
            exposed_actions[name] = _read_action
        elif parse_methods_map is substitution_parse_methods:
            exposed_substitutions[name] = _read_substitution
        return exposed

    return decorate


def _read_action(name: str, content: Element) -> Step:
    step: Step = _reading().read_action(name, content)
    return step


def _read_substitution(call: Call) -> Template:
    text: Template = _reading().read_substitution(call)
    return text


# Any: a module. It needs the actions and substitutions that are exposed by this one.
def _reading() -> Any:
    return importlib.import_module(".reading", __package__)


def expose_substitution(name: str) -> Callable[[_Exposed], _Exposed]:
    """Return a decorator that registers a substitution for launch files.

    Args:
        name: Name of the substitution, as after ``$(``.

    Raises:
        RuntimeError: There is one of that name, or what is decorated is no function and has no
            ``parse``.
    """
    return __expose_impl(name, substitution_parse_methods, "substitution")


def expose_action(name: str) -> Callable[[_Exposed], _Exposed]:
    """Return a decorator that registers an action for launch files.

    Args:
        name: Name of the action in launch files.

    Raises:
        RuntimeError: There is one of that name, or what is decorated is no function and has no
            ``parse``.
    """
    return __expose_impl(name, action_parse_methods, "action")
