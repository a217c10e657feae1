"""Components: nodes that are libraries of C++, which only a container in C++ can load."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from launch.launch_context import LaunchContext

from teleopctl.errors import NotFoundError
from teleopctl.launch import Action, Launch, Template

from .descriptions.composable_node import ComposableNode


@dataclass(frozen=True, slots=True)
class Components(Action):
    """Components for a container.

    Attributes:
        container: Its name.
        descriptions: The components.
        otherwise: What is done where no condition of theirs holds.
    """

    container: Template | None
    descriptions: tuple[ComposableNode, ...]
    otherwise: tuple[Action, ...] = ()

    def evaluate(self, launch: Launch) -> Iterable[Action]:
        """Refuse those that are to be loaded.

        Raises:
            NotFoundError: There is one.
        """
        context = LaunchContext.with_launch(launch)
        wanted = [
            f"{launch.text(each.node_plugin)} (package {launch.text(each.package)})"
            for each in self.descriptions
            if (condition := each.condition()) is None or condition.evaluate(context)
        ]
        if not wanted:
            return self.otherwise
        name = f" '{launch.text(self.container)}'" if self.container is not None else ""
        raise NotFoundError(
            f"container{name}: components are libraries of C++, which teleopctl cannot load: "
            + ", ".join(wanted),
            hint="--skip-missing goes on without them.",
        )
