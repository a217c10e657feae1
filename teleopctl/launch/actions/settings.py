"""Launch actions that declare arguments or set configurations, namespace, parameters, remaps."""

from __future__ import annotations

from teleopctl.base.typed import ClassVar, Self
from teleopctl.errors import UsageError
from teleopctl.launch.actions.parameters import parameter
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch
from teleopctl.launch.model.descriptions import ParameterEntry, ParameterFileEntry, ParameterTree
from teleopctl.launch.model.records import dataclass, replace
from teleopctl.launch.model.scope import join_namespace
from teleopctl.launch.model.template import Template, literal


@dataclass(frozen=True, slots=True, kw_only=True)
class NameAndValue(Action):
    """Base of launch actions with the keys ``name`` and ``value``."""

    keys = ("name", "value")

    name: Template
    value: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action with the ``name`` and ``value`` of an entry."""
        return cls(name=entity.required("name"), value=entity.required("value"))


@dataclass(frozen=True, slots=True, kw_only=True)
class DeclareArgument(Action):
    """``arg``: declares a launch argument, with a default, a description and valid choices."""

    keys: ClassVar[tuple[str, ...]] = ("name", "default", "description", "choice")

    name: str
    default: Template | None
    description: str | None
    choices: tuple[str, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an ``arg`` entry describes."""
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
        """Text of the description and the choices, as ``ros2 launch --show-args`` prints them."""
        if not self.choices:
            return self.description or "no description given"
        choices = str(list(self.choices))
        if not self.description:
            return f"One of: {choices}"
        return f"{self.description.removesuffix('.')}. Valid choices are: {choices}"

    def evaluate(self, launch: Launch) -> None:
        """Set an argument not given to its default; raise if it has none or is no valid choice."""
        launch.declare(self.name)
        variables = launch.scope.variables
        if self.name not in variables:
            if self.default is None:
                raise UsageError(
                    f"Required launch argument '{self.name}' (description: '{self.in_words}') "
                    "was not provided",
                    hint=f"Give it after the file: {self.name}:=VALUE",
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
        """Return the action that a ``bool_arg`` entry describes."""
        return replace(super().parse(entity), choices=cls.words)


@dataclass(frozen=True, slots=True, kw_only=True)
class Let(NameAndValue):
    """``let``: sets a launch configuration."""

    def evaluate(self, launch: Launch) -> None:
        """Set the launch configuration for the following actions."""
        launch.scope.variables[launch.text(self.name)] = launch.text(self.value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Unset(Action):
    """``unset``: removes a launch configuration."""

    name: Template

    def evaluate(self, launch: Launch) -> None:
        """Remove the launch configuration for the following actions."""
        launch.scope.variables.pop(launch.text(self.name), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reset(Action):
    """``reset``: removes all launch configurations, namespace, parameters and remappings.

    Attributes:
        keep: Launch configurations to set afterwards, as name and value.
    """

    keys = ("keep",)

    keep: tuple[tuple[Template, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``reset`` entry describes."""
        return cls(keep=entity.pairs("keep", "name", "value"))

    def evaluate(self, launch: Launch) -> None:
        """Remove configurations (except those to keep), namespace, parameters and remappings."""
        kept = [(launch.text(name), launch.text(value)) for name, value in self.keep]
        launch.scope.reset()
        launch.scope.variables.update(kept)


@dataclass(frozen=True, slots=True, kw_only=True)
class PushNamespace(Action):
    """``push_ros_namespace``: appends to the namespace of the following nodes."""

    keys = ("namespace",)

    namespace: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``push_ros_namespace`` entry describes."""
        return cls(namespace=entity.required("namespace"))

    def evaluate(self, launch: Launch) -> None:
        """Append a namespace to that of the following nodes; an absolute one replaces the old."""
        scope = launch.scope
        scope.namespace = join_namespace(scope.namespace, launch.text(self.namespace))


@dataclass(frozen=True, slots=True, kw_only=True)
class SetParameter(Action):
    """``set_parameter``: sets one parameter of all following nodes."""

    keys = ("name", "value", "type")

    parameter: ParameterEntry

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``set_parameter`` entry describes."""
        return cls(parameter=parameter(entity))

    def evaluate(self, launch: Launch) -> None:
        """Evaluate the parameter, and add it to the parameters of all following nodes."""
        name = literal(launch.text(self.parameter.name))
        value = _evaluated(self.parameter.value, launch)
        launch.scope.parameters += (replace(self.parameter, name=name, value=value),)


def _evaluated(value: ParameterTree, launch: Launch) -> ParameterTree:
    """Return a value with its substitutions evaluated to texts, which are typed later."""
    if isinstance(value, list):
        return [_evaluated(item, launch) for item in value]
    return literal(launch.text(value)) if isinstance(value, Template) else value


@dataclass(frozen=True, slots=True, kw_only=True)
class SetParametersFromFile(Action):
    """``set_parameters_from_file``: gives a parameter file to all following nodes."""

    keys = ("filename",)

    file: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``set_parameters_from_file`` entry describes."""
        return cls(file=entity.required("filename"))

    def evaluate(self, launch: Launch) -> None:
        """Add the parameter file to the parameters of all following nodes."""
        launch.scope.parameters += (ParameterFileEntry(literal(launch.text(self.file))),)


@dataclass(frozen=True, slots=True, kw_only=True)
class SetUseSimTime(Action):
    """``set_use_sim_time``: sets whether the launch's ``ros_timer`` actions use ``/clock``."""

    keys = ("value",)

    value: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``set_use_sim_time`` entry describes."""
        return cls(value=entity.required("value"))

    def evaluate(self, launch: Launch) -> None:
        """Set whether the launch's ``ros_timer`` actions use ``/clock`` or wall time."""
        with values.at_key("value"):
            launch.uses_sim_time = values.flag(launch.text(self.value))


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRemap(Action):
    """``set_remap``: remaps a name in all following nodes."""

    keys = ("from", "to")

    source: Template
    target: Template

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``set_remap`` entry describes."""
        return cls(source=entity.required("from"), target=entity.required("to"))

    def evaluate(self, launch: Launch) -> None:
        """Add the remapping to those of all following nodes."""
        launch.scope.remaps += ((launch.text(self.source), launch.text(self.target)),)


@dataclass(frozen=True, slots=True)
class PushConfigurations(Action):
    """``push_launch_configurations``: saves the launch configurations on a stack."""

    def evaluate(self, launch: Launch) -> None:
        """Save launch configurations, parameters and remappings on the stack."""
        launch.scope.push_configurations()


@dataclass(frozen=True, slots=True)
class PopConfigurations(Action):
    """``pop_launch_configurations``: restores the launch configurations that were saved last."""

    def evaluate(self, launch: Launch) -> None:
        """Restore configurations, parameters and remappings from the stack, and drop that entry."""
        launch.scope.pop_configurations()
