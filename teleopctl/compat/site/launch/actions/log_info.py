"""``launch.actions.log_info``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.launch import Log, literal

from .._texts import template
from ..action import Action
from ..substitution import Substitution
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class LogInfo(Action):
    """A line for the person in front of the terminal.

    Args:
        msg: The line.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._msg = normalize_to_list_of_substitutions(msg)

    @property
    def msg(self) -> list[Substitution]:
        """The line."""
        return self._msg

    def model_action(self) -> Log:
        """Return what the model does for it."""
        return Log(level=literal("INFO"), message=template(self._msg))


class Warn(Action):
    """A warning of the launch's own.

    Args:
        text: The line.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self._text = text

    def model_action(self) -> Log:
        """Return what the model does for it."""
        return Log(level=literal("WARNING"), message=literal(self._text))
