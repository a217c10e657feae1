"""What an action leaves to those that follow it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from teleopctl.errors import LaunchError
from teleopctl.launch.model.descriptions import ParameterEntry, ParameterFileEntry

# The launch variable in which ROS 2 keeps it, so that a file may set and read it there, too.
_NAMESPACE = "ros_namespace"


@dataclass(slots=True)
class Scope:
    """Settings that a scoped group restores at its end.

    Attributes:
        variables: Launch variables (arguments and ``let``) by name, and the namespace.
        environment: Variables set for the processes; None removes one.
        parameters: Parameters and parameter files of every following node.
        remaps: Remappings of every following node.
        use_sim_time: Whether the launch's own timers follow ``/clock``.
        loop_values: What the loops around give, by name.
        given: Names of the launch arguments that the including file gave.
        remembered: What is to come back, the last one first, but for the environment.
        remembered_environments: Likewise for the environment.
    """

    variables: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str | None] = field(default_factory=dict)
    parameters: tuple[ParameterEntry | ParameterFileEntry, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    use_sim_time: bool = False
    loop_values: Mapping[str, str] = field(default_factory=dict)
    given: frozenset[str] = frozenset()
    remembered: tuple[Scope, ...] = ()
    remembered_environments: tuple[dict[str, str | None], ...] = ()

    @property
    def namespace(self) -> str:
        """Namespace of the following nodes."""
        return join_namespace("/", self.variables.get(_NAMESPACE, ""))

    @namespace.setter
    def namespace(self, namespace: str) -> None:
        self.variables[_NAMESPACE] = namespace

    @property
    def has_namespace(self) -> bool:
        """Return whether a namespace was set."""
        return _NAMESPACE in self.variables

    def copy(self) -> Scope:
        """Return an independent copy."""
        return replace(self, variables=dict(self.variables), environment=dict(self.environment))

    def reset(self) -> None:
        """Remove the launch configurations: all but the environment and loops."""
        self.variables.clear()
        self.parameters = ()
        self.remaps = ()

    def remember(self) -> None:
        """Save the launch configurations."""
        self.remembered += (self.copy(),)

    def bring_back(self) -> None:
        """Restore the last saved launch configurations.

        Raises:
            LaunchError: Nothing was.
        """
        if not self.remembered:
            raise LaunchError("launch_configurations stack unexpectedly empty")
        *others, last = self.remembered
        self.remembered = tuple(others)
        self.variables = dict(last.variables)
        self.parameters, self.remaps = last.parameters, last.remaps

    def remember_environment(self) -> None:
        """Save the environment."""
        self.remembered_environments += (dict(self.environment),)

    def bring_back_environment(self) -> None:
        """Restore the last saved environment.

        Raises:
            LaunchError: None was.
        """
        if not self.remembered_environments:
            raise LaunchError("environment stack unexpectedly empty")
        *others, self.environment = self.remembered_environments
        self.remembered_environments = tuple(others)


def join_namespace(outer: str, inner: str) -> str:
    """Return a namespace below another one; an absolute one is unchanged."""
    if inner.startswith("/"):
        return "/" + inner.strip("/")
    return "/" + f"{outer}/{inner}".strip("/").replace("//", "/")
