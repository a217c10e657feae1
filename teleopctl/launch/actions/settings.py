"""Actions that change what follows: variables, environment, namespace, parameters, remappings."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Self

from teleopctl.errors import UsageError
from teleopctl.launch.actions.parameters import parameter
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.descriptions import Parameter
from teleopctl.launch.model.template import Template


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclareArgument(Action):
    """``arg``: an argument of the file."""

    keys = ("name", "default", "description", "choice")

    name: str
    default: Template | None
    description: str | None
    choices: tuple[str, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read an ``arg``."""
        choices = entity.element("choice")
        description = entity.element("description")
        return cls(
            name=entity.required_text("name"),
            default=entity.optional("default"),
            description=None if description is None else description.text(),
            choices=tuple(
                Entity(item, ("value",)).required_text("value")
                for item in (choices.items("a list of 'value: …'") if choices else ())
            ),
        )

    def evaluate(self, launch: Launch) -> None:
        """Set the variable to the default where nobody gave it a value."""
        launch.declare(self.name)
        variables = launch.scope.variables
        if self.name not in variables:
            if self.default is None:
                description = self.description or "no description given"
                raise UsageError(
                    f"Required launch argument '{self.name}' (description: '{description}') "
                    "was not provided",
                    hint=f"Give it behind the file: {self.name}:=VALUE",
                )
            variables[self.name] = launch.text(self.default)
        value = variables[self.name]
        if self.choices and value not in self.choices:
            raise UsageError(
                f'Argument "{self.name}" provided value "{value}" is not valid. '
                f"Valid options are: {list(self.choices)}",
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class _SetNamed(Action):
    """Gives something with a name a value."""

    keys = ("name", "value")

    name: Template
    value: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read name and value."""
        return cls(name=entity.required("name"), value=entity.required("value"))


class Let(_SetNamed):
    """``let``: sets a launch variable."""

    __slots__ = ()

    def evaluate(self, launch: Launch) -> None:
        """Set the variable."""
        launch.scope.variables[launch.text(self.name)] = launch.text(self.value)


class SetEnvironment(_SetNamed):
    """``set_env``: sets an environment variable."""

    __slots__ = ()

    def evaluate(self, launch: Launch) -> None:
        """Set the variable."""
        launch.scope.environment[launch.text(self.name)] = launch.text(self.value)


class AppendEnvironment(_SetNamed):
    """``append_env``: puts a value behind that of a variable, with a separator between."""

    __slots__ = ()

    def evaluate(self, launch: Launch) -> None:
        """Set the variable to both values."""
        name, value = launch.text(self.name), launch.text(self.value)
        present = launch.environment_value(name)
        launch.scope.environment[name] = f"{present}{os.pathsep}{value}" if present else value


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


@dataclass(frozen=True, slots=True, kw_only=True)
class PushNamespace(Action):
    """``push_ros_namespace``: puts the following nodes into a namespace."""

    keys = ("namespace",)

    namespace: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``push_ros_namespace``."""
        return cls(namespace=entity.required("namespace"))

    def evaluate(self, launch: Launch) -> None:
        """Go into the namespace."""
        scope = launch.scope
        scope.namespace = join_namespace(scope.namespace, launch.text(self.namespace))


@dataclass(frozen=True, slots=True, kw_only=True)
class SetParameter(Action):
    """``set_parameter``: a parameter of every following node."""

    keys = ("name", "value", "type")

    parameter: Parameter

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_parameter``."""
        return cls(parameter=parameter(entity))

    def evaluate(self, launch: Launch) -> None:
        """Add the parameter to those of the following nodes."""
        launch.scope.parameters += (self.parameter,)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRemap(Action):
    """``set_remap``: a remapping of every following node."""

    keys = ("from", "to")

    source: Template
    target: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_remap``."""
        return cls(source=entity.required("from"), target=entity.required("to"))

    def evaluate(self, launch: Launch) -> None:
        """Add the remapping to those of the following nodes."""
        launch.scope.remaps += ((launch.text(self.source), launch.text(self.target)),)


def join_namespace(outer: str, inner: str) -> str:
    """Return a namespace below another one; an absolute one stands for itself."""
    if inner.startswith("/"):
        return "/" + inner.strip("/")
    return "/" + f"{outer}/{inner}".strip("/").replace("//", "/")
