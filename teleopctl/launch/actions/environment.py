"""Actions that change the environment of what follows."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from teleopctl.base import background
from teleopctl.launch.actions.settings import NameAndValue
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.template import Template, literal

_LOG_DIRECTORY = "ROS_LOG_DIR"
_FALSE = literal("false")
_PATH_SEPARATOR = literal(os.pathsep)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetEnvironment(NameAndValue):
    """``set_env``: sets an environment variable."""

    def evaluate(self, launch: Launch) -> None:
        """Set the variable."""
        launch.scope.environment[launch.text(self.name)] = launch.text(self.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class AppendEnvironment(Action):
    """``append_env``: appends a value to a variable, with a separator.

    Attributes:
        name: The variable.
        value: What is added.
        prepend: Whether it comes first.
        separator: What stands between; by default what stands between the folders of a path.
    """

    keys = ("name", "value", "prepend", "separator")

    name: Template
    value: Template
    prepend: Template = _FALSE
    separator: Template = _PATH_SEPARATOR

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read an ``append_env``."""
        return cls(
            name=entity.required("name"),
            value=entity.required("value"),
            prepend=entity.optional("prepend") or _FALSE,
            separator=entity.optional("separator") or _PATH_SEPARATOR,
        )

    def evaluate(self, launch: Launch) -> None:
        """Set the variable to both values."""
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
        """Read an ``unset_env``."""
        return cls(name=entity.required("name"))

    def evaluate(self, launch: Launch) -> None:
        """Remove the variable."""
        launch.scope.environment[launch.text(self.name)] = None


@dataclass(frozen=True, slots=True)
class ResetEnvironment(Action):
    """``reset_env``: restores the environment with which the launch was started."""

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``reset_env``."""
        del entity
        return cls()

    def evaluate(self, launch: Launch) -> None:
        """Restore the environment of the launch's start."""
        launch.scope.environment.clear()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplaceEnvironment(Action):
    """``rep_env``: replaces the whole environment by the given variables."""

    keys = ("env",)

    variables: tuple[tuple[Template, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``rep_env``."""
        return cls(variables=entity.pairs("env", "name", "value"))

    def evaluate(self, launch: Launch) -> None:
        """Remove all environment variables and set the given ones."""
        given = [(launch.text(name), launch.text(value)) for name, value in self.variables]
        environment = launch.scope.environment
        environment.update(dict.fromkeys((*os.environ, *environment)))
        environment.update(given)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRosLogDirectory(Action):
    """``set_ros_log_dir``: sets the log directory of the following nodes."""

    keys = ("new_log_dir",)

    folder: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_ros_log_dir``."""
        return cls(folder=entity.required("new_log_dir"))

    def evaluate(self, launch: Launch) -> None:
        """Set the log directory, relative to the present one."""
        present = launch.environment_value(_LOG_DIRECTORY) or background.logs_dir()
        folder = Path(present).absolute() / launch.text(self.folder)
        launch.scope.environment[_LOG_DIRECTORY] = str(folder)


@dataclass(frozen=True, slots=True)
class PushEnvironment(Action):
    """``push_environment``: saves the environment."""

    def evaluate(self, launch: Launch) -> None:
        """Save the environment, for ``pop_environment``."""
        launch.scope.remember_environment()


@dataclass(frozen=True, slots=True)
class PopEnvironment(Action):
    """``pop_environment``: restores the last saved environment."""

    def evaluate(self, launch: Launch) -> None:
        """Restore the environment."""
        launch.scope.bring_back_environment()
