"""Actions that bring back what was set before: a group in two halves, as programs write it."""

from __future__ import annotations

from dataclasses import dataclass

from teleopctl.launch.model.action import Action, Launch


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
