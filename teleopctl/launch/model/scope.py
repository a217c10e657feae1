"""Scope of a launch: settings that an action leaves to the actions after it."""

from __future__ import annotations

from teleopctl.base.typed import Mapping
from teleopctl.errors import LaunchError
from teleopctl.launch.model.descriptions import ParameterEntry, ParameterFileEntry
from teleopctl.launch.model.records import dataclass, field, replace

# Launch configuration with the namespace, as in ROS 2, so that a file may also set and read it.
_NAMESPACE = "ros_namespace"


@dataclass(slots=True)
class Scope:
    """Settings that launch actions change for the actions after them; a scoped group restores them.

    Attributes:
        variables: Launch configurations (arguments and ``let``) by name, and the namespace.
        environment: Environment variables set for the processes; None removes a variable.
        parameters: Parameters and parameter files of every following node.
        remaps: Remappings of every following node.
        loop_values: Values of the enclosing loops, by name.
        given: Names of the launch arguments that the including file passed.
        configuration_stack: Scopes saved by `push_configurations`, the last one at the end.
        environment_stack: Environments saved by `push_environment`, the last one at the end.
    """

    variables: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str | None] = field(default_factory=dict)
    parameters: tuple[ParameterEntry | ParameterFileEntry, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    loop_values: Mapping[str, str] = field(default_factory=dict)
    given: frozenset[str] = frozenset()
    configuration_stack: tuple[Scope, ...] = ()
    environment_stack: tuple[dict[str, str | None], ...] = ()

    @property
    def namespace(self) -> str:
        """Namespace of the following nodes, absolute."""
        return join_namespace("/", self.variables.get(_NAMESPACE, ""))

    @namespace.setter
    def namespace(self, namespace: str) -> None:
        self.variables[_NAMESPACE] = namespace

    @property
    def has_namespace(self) -> bool:
        """Whether a namespace was pushed or set."""
        return _NAMESPACE in self.variables

    def copy(self) -> Scope:
        """Return a copy whose configurations and environment change independently."""
        return replace(self, variables=dict(self.variables), environment=dict(self.environment))

    def reset(self) -> None:
        """Remove launch configurations, namespace, parameters and remappings."""
        self.variables.clear()
        self.parameters = ()
        self.remaps = ()

    def push_configurations(self) -> None:
        """Save the launch configurations, parameters and remappings on the stack."""
        self.configuration_stack += (self.copy(),)

    def pop_configurations(self) -> None:
        """Restore what `push_configurations` saved last, and remove it from the stack.

        Raises:
            LaunchError: The stack is empty.
        """
        if not self.configuration_stack:
            raise LaunchError("launch_configurations stack unexpectedly empty")
        *others, last = self.configuration_stack
        self.configuration_stack = tuple(others)
        self.variables = dict(last.variables)
        self.parameters, self.remaps = last.parameters, last.remaps

    def push_environment(self) -> None:
        """Save the environment on the stack."""
        self.environment_stack += (dict(self.environment),)

    def pop_environment(self) -> None:
        """Restore the environment that was saved last, and remove it from the stack.

        Raises:
            LaunchError: The stack is empty.
        """
        if not self.environment_stack:
            raise LaunchError("environment stack unexpectedly empty")
        *others, self.environment = self.environment_stack
        self.environment_stack = tuple(others)


def join_namespace(outer: str, inner: str) -> str:
    """Return an inner namespace below an outer one; an absolute inner namespace stays as it is."""
    if inner.startswith("/"):
        return "/" + inner.strip("/")
    return "/" + f"{outer}/{inner}".strip("/").replace("//", "/")
