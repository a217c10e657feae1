"""``launch.actions.log_info``: actions that log a message."""

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
    """Logs a message at a severity.

    Args:
        msg: The line.
        level: Severity: ``DEBUG``, ``INFO``, ``WARNING``, ``ERROR`` or ``CRITICAL``.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(
        self, *, msg: SomeSubstitutionsType, level: SomeSubstitutionsType, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._msg = normalize_to_list_of_substitutions(msg)
        self._level = normalize_to_list_of_substitutions(level)

    @property
    def msg(self) -> list[Substitution]:
        """Message, as substitutions."""
        return self._msg

    @property
    def level(self) -> list[Substitution]:
        """Severity."""
        return self._level

    def model_action(self) -> ModelLog:
        """Return the corresponding action of `teleopctl.launch`."""
        return ModelLog(level=template(self._level), message=template(self._msg))


class LogDebug(Log):
    """Logs a message at severity DEBUG.

    Args:
        msg: The line.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="DEBUG", **kwargs)


class LogInfo(Log):
    """Logs a message at severity INFO.

    Args:
        msg: The line.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="INFO", **kwargs)


class LogWarning(Log):
    """Logs a message at severity WARNING.

    Args:
        msg: The line.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="WARNING", **kwargs)


class LogError(Log):
    """Logs a message at severity ERROR.

    Args:
        msg: The line.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
    def __init__(self, *, msg: SomeSubstitutionsType, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="ERROR", **kwargs)
