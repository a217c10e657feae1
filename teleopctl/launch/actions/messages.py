"""Launch actions that log a message (``log`` and ``log_info`` and so on), and ``shutdown``."""

from __future__ import annotations

from teleopctl.base.typed import ClassVar, Self
from teleopctl.errors import LaunchError
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.events import ProcessExited
from teleopctl.launch.model.plan import REQUIRED
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template, literal

_INFO = literal("INFO")
_LOG_LEVELS = {"DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Log(Action):
    """``log``: logs a message at a level, DEBUG to CRITICAL."""

    keys: ClassVar[tuple[str, ...]] = ("level", "message")

    message: Template
    level: Template = _INFO

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``log`` entry describes."""
        level = entity.optional("level") or _INFO
        return cls(level=level, message=entity.required("message"))

    def evaluate(self, launch: Launch) -> None:
        """Log the evaluated message at the evaluated level; raise for an unknown level."""
        level = launch.text(self.level).upper()
        if level == "WARN":
            level = "WARNING"
        if level not in _LOG_LEVELS:
            raise LaunchError(
                f"'level': expected one of {', '.join(sorted(_LOG_LEVELS))}, got '{level}'"
            )
        launch.log(level, launch.text(self.message))


class _LogAt(Log):
    """Base of the actions that log a message at a fixed level."""

    __slots__ = ()
    keys = ("message",)
    fixed: ClassVar[Template]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an entry such as ``log_debug`` or ``log_info`` describes."""
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
    """``shutdown``: shuts the launch down."""

    keys = ("reason",)

    reason: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``shutdown`` entry describes."""
        return cls(reason=entity.optional("reason") or literal("reason not given"))

    def evaluate(self, launch: Launch) -> None:
        """Request the launch's shutdown; if nothing was started yet, the launch fails instead."""
        if isinstance(launch.event, ProcessExited):
            name = launch.event.plan.name
            launch.log("INFO", REQUIRED.format(name=name), "launch")
        launch.shut_down(launch.text(self.reason))
