"""Launch actions that change the environment of all processes that are started after them."""

from __future__ import annotations

import os
from pathlib import Path

from teleopctl.base import background
from teleopctl.base.typed import Self
from teleopctl.launch.actions.settings import NameAndValue
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template, literal

_LOG_DIRECTORY = "ROS_LOG_DIR"
_FALSE = literal("false")
_PATH_SEPARATOR = literal(os.pathsep)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetEnvironment(NameAndValue):
    """``set_env``: sets an environment variable."""

    def evaluate(self, launch: Launch) -> None:
        """Set the environment variable for the following processes."""
        launch.scope.environment[launch.text(self.name)] = launch.text(self.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class AppendEnvironment(Action):
    """``append_env``: appends or prepends a value to an environment variable, with a separator.

    Attributes:
        name: Name of the variable.
        value: Text to add.
        prepend: Whether to put the text in front of the present value.
        separator: Text between the two; by default the separator of ``PATH``.
    """

    keys = ("name", "value", "prepend", "separator")

    name: Template
    value: Template
    prepend: Template = _FALSE
    separator: Template = _PATH_SEPARATOR

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an ``append_env`` entry describes."""
        return cls(
            name=entity.required("name"),
            value=entity.required("value"),
            prepend=entity.optional("prepend") or _FALSE,
            separator=entity.optional("separator") or _PATH_SEPARATOR,
        )

    def evaluate(self, launch: Launch) -> None:
        """Append or prepend the value to the environment variable, or set it if it is unset."""
        name, value = launch.text(self.name), launch.text(self.value)
        present = launch.environment_value(name)
        with values.at_key("prepend"):
            prepend = values.boolean(launch.text(self.prepend))
        if present is not None:
            both = (value, present) if prepend else (present, value)
            value = launch.text(self.separator).join(both)
        launch.scope.environment[name] = value


@dataclass(frozen=True, slots=True, kw_only=True)
class UnsetEnvironment(Action):
    """``unset_env``: removes an environment variable."""

    keys = ("name",)

    name: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an ``unset_env`` entry describes."""
        return cls(name=entity.required("name"))

    def evaluate(self, launch: Launch) -> None:
        """Remove the environment variable for the following processes."""
        launch.scope.environment[launch.text(self.name)] = None


@dataclass(frozen=True, slots=True)
class ResetEnvironment(Action):
    """``reset_env``: restores the environment in which the launch was started."""

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``reset_env`` entry describes."""
        del entity
        return cls()

    def evaluate(self, launch: Launch) -> None:
        """Drop all changes that launch actions have made to the environment."""
        launch.scope.environment.clear()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplaceEnvironment(Action):
    """``rep_env``: replaces the environment of the following processes by the given variables."""

    keys = ("env",)

    variables: tuple[tuple[Template, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``rep_env`` entry describes."""
        return cls(variables=entity.pairs("env", "name", "value"))

    def evaluate(self, launch: Launch) -> None:
        """Remove all environment variables, and set the given ones, for the following processes."""
        given = [(launch.text(name), launch.text(value)) for name, value in self.variables]
        environment = launch.scope.environment
        environment.update(dict.fromkeys((*os.environ, *environment)))
        environment.update(given)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRosLogDirectory(Action):
    """``set_ros_log_dir``: sets ``ROS_LOG_DIR`` of the following processes."""

    keys = ("new_log_dir",)

    folder: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``set_ros_log_dir`` entry describes."""
        return cls(folder=entity.required("new_log_dir"))

    def evaluate(self, launch: Launch) -> None:
        """Set ``ROS_LOG_DIR`` of later processes; a relative folder is below the present one."""
        present = launch.environment_value(_LOG_DIRECTORY) or background.logs_dir()
        folder = Path(present).absolute() / launch.text(self.folder)
        launch.scope.environment[_LOG_DIRECTORY] = str(folder)


@dataclass(frozen=True, slots=True)
class PushEnvironment(Action):
    """``push_environment``: saves the environment on a stack."""

    def evaluate(self, launch: Launch) -> None:
        """Save the present environment on the stack, for ``pop_environment``."""
        launch.scope.push_environment()


@dataclass(frozen=True, slots=True)
class PopEnvironment(Action):
    """``pop_environment``: restores the environment that was saved last."""

    def evaluate(self, launch: Launch) -> None:
        """Pop the environment from the stack and restore it; raise if the stack is empty."""
        launch.scope.pop_environment()
