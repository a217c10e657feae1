"""Actions that change launch configurations, namespace, parameters and remappings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

from teleopctl.errors import UsageError
from teleopctl.launch.actions.parameters import parameter
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.descriptions import ParameterEntry, ParameterFileEntry, ParameterTree
from teleopctl.launch.model.scope import join_namespace
from teleopctl.launch.model.template import Template, literal


@dataclass(frozen=True, slots=True, kw_only=True)
class NameAndValue(Action):
    """Base of actions with a name and a value."""

    keys = ("name", "value")

    name: Template
    value: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read the name and the value."""
        return cls(name=entity.required("name"), value=entity.required("value"))


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclareArgument(Action):
    """``arg``: declares a launch argument."""

    keys: ClassVar[tuple[str, ...]] = ("name", "default", "description", "choice")

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

    @property
    def in_words(self) -> str:
        """Return the argument's description and choices, as ``--show-args`` prints them."""
        if not self.choices:
            return self.description or "no description given"
        choices = str(list(self.choices))
        if not self.description:
            return f"One of: {choices}"
        return f"{self.description.removesuffix('.')}. Valid choices are: {choices}"

    def evaluate(self, launch: Launch) -> None:
        """Set the argument's default if no value was given."""
        launch.declare(self.name)
        variables = launch.scope.variables
        if self.name not in variables:
            if self.default is None:
                raise UsageError(
                    f"Required launch argument '{self.name}' (description: '{self.in_words}') "
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


class DeclareBoolean(DeclareArgument):
    """``bool_arg``: declares a launch argument that is true or false."""

    __slots__ = ()
    keys = ("name", "default", "description")
    words: ClassVar[tuple[str, ...]] = ("true", "false", "True", "False", "TRUE", "FALSE")

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``bool_arg``."""
        return replace(super().parse(entity), choices=cls.words)


@dataclass(frozen=True, slots=True, kw_only=True)
class Let(NameAndValue):
    """``let``: sets a launch configuration."""

    def evaluate(self, launch: Launch) -> None:
        """Set the launch configuration."""
        launch.scope.variables[launch.text(self.name)] = launch.text(self.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Unset(Action):
    """``unset``: removes a launch configuration."""

    name: Template

    def evaluate(self, launch: Launch) -> None:
        """Remove the launch configuration."""
        launch.scope.variables.pop(launch.text(self.name), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reset(Action):
    """``reset``: removes launch configurations, namespace, parameters and remappings.

    Attributes:
        keep: Variables to set afterwards, as name and value.
    """

    keys = ("keep",)

    keep: tuple[tuple[Template, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``reset``."""
        return cls(keep=entity.pairs("keep", "name", "value"))

    def evaluate(self, launch: Launch) -> None:
        """Remove everything that is not to be kept."""
        kept = [(launch.text(name), launch.text(value)) for name, value in self.keep]
        launch.scope.reset()
        launch.scope.variables.update(kept)


@dataclass(frozen=True, slots=True, kw_only=True)
class PushNamespace(Action):
    """``push_ros_namespace``: sets the namespace of the following nodes."""

    keys = ("namespace",)

    namespace: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``push_ros_namespace``."""
        return cls(namespace=entity.required("namespace"))

    def evaluate(self, launch: Launch) -> None:
        """Set the namespace, below the present one."""
        scope = launch.scope
        scope.namespace = join_namespace(scope.namespace, launch.text(self.namespace))


@dataclass(frozen=True, slots=True, kw_only=True)
class SetParameter(Action):
    """``set_parameter``: sets a parameter of all following nodes."""

    keys = ("name", "value", "type")

    parameter: ParameterEntry

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_parameter``."""
        return cls(parameter=parameter(entity))

    def evaluate(self, launch: Launch) -> None:
        """Add the parameter, evaluated now, to the following nodes."""
        name = literal(launch.text(self.parameter.name))
        value = _evaluated(self.parameter.value, launch)
        launch.scope.parameters += (replace(self.parameter, name=name, value=value),)


def _evaluated(value: ParameterTree, launch: Launch) -> ParameterTree:
    """What a value is now: its substitutions give texts, whose type is still open."""
    if isinstance(value, list):
        return [_evaluated(item, launch) for item in value]
    return literal(launch.text(value)) if isinstance(value, Template) else value


@dataclass(frozen=True, slots=True, kw_only=True)
class SetParametersFromFile(Action):
    """``set_parameters_from_file``: sets a parameter file of all following nodes."""

    keys = ("filename",)

    file: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_parameters_from_file``."""
        return cls(file=entity.required("filename"))

    def evaluate(self, launch: Launch) -> None:
        """Add the parameter file to the following nodes."""
        launch.scope.parameters += (ParameterFileEntry(literal(launch.text(self.file))),)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetUseSimTime(Action):
    """``set_use_sim_time``: sets whether ``ros_timer`` follows ``/clock``."""

    keys = ("value",)

    value: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_use_sim_time``."""
        return cls(value=entity.required("value"))

    def evaluate(self, launch: Launch) -> None:
        """Set whether the following timers use ``/clock``."""
        with values.at_key("value"):
            launch.scope.use_sim_time = values.flag(launch.text(self.value))


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRemap(Action):
    """``set_remap``: sets a remapping of all following nodes."""

    keys = ("from", "to")

    source: Template
    target: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``set_remap``."""
        return cls(source=entity.required("from"), target=entity.required("to"))

    def evaluate(self, launch: Launch) -> None:
        """Add the remapping to the following nodes."""
        launch.scope.remaps += ((launch.text(self.source), launch.text(self.target)),)


@dataclass(frozen=True, slots=True)
class PushConfigurations(Action):
    """``push_launch_configurations``: saves the launch configurations."""

    def evaluate(self, launch: Launch) -> None:
        """Save the launch configurations, for ``pop_launch_configurations``."""
        launch.scope.remember()


@dataclass(frozen=True, slots=True)
class PopConfigurations(Action):
    """``pop_launch_configurations``: restores the last saved launch configurations."""

    def evaluate(self, launch: Launch) -> None:
        """Restore the launch configurations."""
        launch.scope.bring_back()
