"""What an action leaves to those that follow it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from teleopctl.launch.model.descriptions import Parameter


@dataclass(slots=True)
class Scope:
    """What a scoped group restores when it ends.

    Attributes:
        variables: Launch variables (arguments and ``let``) by name.
        environment: Variables set for the processes; None removes one.
        namespace: Namespace of the following nodes, ``/`` at the top.
        parameters: Parameters of every following node.
        remaps: Remappings of every following node.
    """

    variables: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str | None] = field(default_factory=dict)
    namespace: str = "/"
    parameters: tuple[Parameter, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()

    def copy(self) -> Scope:
        """Return an independent copy."""
        return replace(self, variables=dict(self.variables), environment=dict(self.environment))
