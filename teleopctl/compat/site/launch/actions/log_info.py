"""``launch.actions.log_info``: lines for the person in front of the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from teleopctl.launch import Log as ModelLog

from .._texts import template
from ..action import Action
from ..substitution import Substitution
from ..utilities import normalize_to_list_of_substitutions

if TYPE_CHECKING:
    from ..some_substitutions_type import SomeSubstitutionsType


class Log(Action):
    """A line for the person in front of the terminal.

    Args:
        msg: The line.
        level: How much it matters: ``DEBUG``, ``INFO``, ``WARNING``, ``ERROR`` or ``CRITICAL``.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self, *, msg: SomeSubstitutionsType, level: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._msg = normalize_to_list_of_substitutions(msg)
        self._level = normalize_to_list_of_substitutions(level)

    @property
    def msg(self) -> list[Substitution]:
        """The line."""
        return self._msg

    @property
    def level(self) -> list[Substitution]:
        """How much it matters."""
        return self._level

    def model_action(self) -> ModelLog:
        """Return what the model does for it."""
        return ModelLog(level=template(self._level), message=template(self._msg))


class LogDebug(Log):
    """A line for who looks for mistakes.

    Args:
        msg: The line.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="DEBUG", **kwargs)


class LogInfo(Log):
    """A line that tells what goes on.

    Args:
        msg: The line.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="INFO", **kwargs)


class LogWarning(Log):
    """A line that warns.

    Args:
        msg: The line.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="WARNING", **kwargs)


class LogError(Log):
    """A line that tells of an error.

    Args:
        msg: The line.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="ERROR", **kwargs)
