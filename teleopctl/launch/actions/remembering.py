"""Actions that bring back what was set before: a group in two halves, as programs write it."""

from __future__ import annotations

from dataclasses import dataclass

from teleopctl.launch.model.action import Action, Launch


@dataclass(frozen=True, slots=True)
class PushConfigurations(Action):
    """Remembers launch variables, namespace, parameters and remappings."""

    def evaluate(self, launch: Launch) -> None:
        """Save the launch configurations, for ``pop_launch_configurations``."""
        launch.scope.remember()


@dataclass(frozen=True, slots=True)
class PopConfigurations(Action):
    """Brings back what `PushConfigurations` remembered last."""

    def evaluate(self, launch: Launch) -> None:
        """Bring it back."""
        launch.scope.bring_back()


@dataclass(frozen=True, slots=True)
class PushEnvironment(Action):
    """Remembers the environment."""

    def evaluate(self, launch: Launch) -> None:
        """Save the environment, for ``pop_environment``."""
        launch.scope.remember_environment()


@dataclass(frozen=True, slots=True)
class PopEnvironment(Action):
    """Brings back the environment that `PushEnvironment` remembered last."""

    def evaluate(self, launch: Launch) -> None:
        """Bring it back."""
        launch.scope.bring_back_environment()
