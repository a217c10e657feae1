"""``log`` and ``shutdown``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from teleopctl.errors import LaunchError
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.events import ProcessExited
from teleopctl.launch.model.plan import REQUIRED
from teleopctl.launch.model.template import Template, literal

_INFO = literal("INFO")
_LOG_LEVELS = {"DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Log(Action):
    """``log``: logs a message at a level."""

    keys: ClassVar[tuple[str, ...]] = ("level", "message")

    message: Template
    level: Template = _INFO

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``log``."""
        level = entity.optional("level") or _INFO
        return cls(level=level, message=entity.required("message"))

    def evaluate(self, launch: Launch) -> None:
        """Log the message."""
        level = launch.text(self.level).upper()
        if level == "WARN":
            level = "WARNING"
        if level not in _LOG_LEVELS:
            raise LaunchError(
                f"'level': expected one of {', '.join(sorted(_LOG_LEVELS))}, got '{level}'"
            )
        launch.say(level, launch.text(self.message))


class _LogAt(Log):
    """A line of the level that its name says."""

    __slots__ = ()
    keys = ("message",)
    fixed: ClassVar[Template]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``log_…``."""
        return cls(message=entity.required("message"), level=cls.fixed)


class LogDebug(_LogAt):
    """``log_debug``: logs a message at level DEBUG."""

    __slots__ = ()
    fixed = literal("DEBUG")


class LogInfo(_LogAt):
    """``log_info``: logs a message at level INFO."""

    __slots__ = ()
    fixed = _INFO


class LogWarning(_LogAt):
    """``log_warning``: logs a message at level WARN."""

    __slots__ = ()
    fixed = literal("WARNING")


class LogError(_LogAt):
    """``log_error``: logs a message at level ERROR."""

    __slots__ = ()
    fixed = literal("ERROR")


@dataclass(frozen=True, slots=True, kw_only=True)
class Shutdown(Action):
    """``shutdown``: ends the launch; in the first walk, before anything is started."""

    keys = ("reason",)

    reason: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``shutdown``."""
        return cls(reason=entity.optional("reason") or literal("reason not given"))

    def evaluate(self, launch: Launch) -> None:
        """End the launch; in the first walk raise an error with the reason."""
        if isinstance(launch.event, ProcessExited):
            name = launch.event.plan.name
            launch.say("INFO", REQUIRED.format(name=name), "launch")
        launch.shut_down(launch.text(self.reason))
