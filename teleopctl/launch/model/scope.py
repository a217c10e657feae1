"""What an action leaves to those that follow it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from teleopctl.errors import LaunchError
from teleopctl.launch.model.descriptions import Parameter, ParameterFile


@dataclass(slots=True)
class Scope:
    """What a scoped group restores when it ends.

    Attributes:
        variables: Launch variables (arguments and ``let``) by name.
        environment: Variables set for the processes; None removes one.
        namespace: Namespace of the following nodes, ``/`` at the top.
        parameters: Parameters and parameter files of every following node.
        remaps: Remappings of every following node.
        use_sim_time: Whether the launch's own timers follow ``/clock``.
        loop_values: What the loops around give, by name.
        remembered: What is to come back, the last one first, but for the environment.
        remembered_environments: Likewise for the environment.
    """

    variables: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str | None] = field(default_factory=dict)
    namespace: str = "/"
    parameters: tuple[Parameter | ParameterFile, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    use_sim_time: bool = False
    loop_values: Mapping[str, str] = field(default_factory=dict)
    remembered: tuple[Scope, ...] = ()
    remembered_environments: tuple[dict[str, str | None], ...] = ()

    def copy(self) -> Scope:
        """Return an independent copy."""
        return replace(self, variables=dict(self.variables), environment=dict(self.environment))

    def reset(self) -> None:
        """Forget what ROS 2 keeps as launch configurations: all but the environment and loops."""
        self.variables.clear()
        self.namespace = "/"
        self.parameters = ()
        self.remaps = ()

    def remember(self) -> None:
        """Remember what ROS 2 keeps as launch configurations."""
        self.remembered += (self.copy(),)

    def bring_back(self) -> None:
        """Bring back what was remembered last.

        Raises:
            LaunchError: Nothing was.
        """
        if not self.remembered:
            raise LaunchError("launch_configurations stack unexpectedly empty")
        *others, last = self.remembered
        self.remembered = tuple(others)
        self.variables, self.namespace = dict(last.variables), last.namespace
        self.parameters, self.remaps = last.parameters, last.remaps

    def remember_environment(self) -> None:
        """Remember the environment."""
        self.remembered_environments += (dict(self.environment),)

    def bring_back_environment(self) -> None:
        """Bring back the environment that was remembered last.

        Raises:
            LaunchError: None was.
        """
        if not self.remembered_environments:
            raise LaunchError("environment stack unexpectedly empty")
        *others, self.environment = self.remembered_environments
        self.remembered_environments = tuple(others)
