"""``launch_ros.descriptions.composable_node``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from launch._entities import condition_of
from launch._places import here
from launch._texts import optional, template

from teleopctl.launch import ComponentPart, ParameterEntry, Template

from .._parameters import parameters as model_parameters

if TYPE_CHECKING:
    from launch.condition import Condition
    from launch.some_substitutions_type import SomeSubstitutionsType

    from ..parameters_type import SomeParameters
    from ..remap_rule_type import SomeRemapRules


class ComposableNode:
    """Node that is loaded into a container.

    Args:
        package: The package that offers it.
        plugin: Its class.
        name: Its name.
        namespace: Its namespace.
        parameters: Its parameters.
        remappings: Pairs from, to.
        extra_arguments: Further arguments of loading.
        condition: Has to hold for it to be loaded.
    """

    def __init__(
        self,
        *,
        package: SomeSubstitutionsType,
        plugin: SomeSubstitutionsType,
        name: SomeSubstitutionsType | None = None,
        namespace: SomeSubstitutionsType | None = None,
        parameters: SomeParameters | None = None,
        remappings: SomeRemapRules | None = None,
        extra_arguments: SomeParameters | None = None,
        condition: Condition | None = None,
    ) -> None:
        self.package = template(package)
        self.node_plugin = template(plugin)
        self.node_name = optional(name)
        self.node_namespace = optional(namespace)
        self.parameters = parameters
        self.remappings = remappings
        self.extra_arguments = extra_arguments
        self._condition = condition
        self._place = here()

    def condition(self) -> Condition | None:
        """Condition under which the component is loaded, or None."""
        return self._condition

    def component(self, autostart: Template | None = None) -> ComponentPart:
        """Return the component as one of `teleopctl.launch`.

        Raises:
            TypeError: A parameter is none, or an extra argument is a file.
        """
        extra = tuple(model_parameters(self.extra_arguments or []))
        if not all(isinstance(each, ParameterEntry) for each in extra):
            raise TypeError("extra_arguments: a file cannot be read here")
        return ComponentPart(
            place=self._place,
            conditions=() if self._condition is None else (condition_of(self._condition),),
            package=self.package,
            plugin=self.node_plugin,
            name=self.node_name,
            namespace=self.node_namespace,
            parameters=tuple(model_parameters(self.parameters or [])),
            remaps=tuple(
                (template(source), template(target)) for source, target in self.remappings or ()
            ),
            extra_arguments=tuple(each for each in extra if isinstance(each, ParameterEntry)),
            autostart=autostart,
        )
