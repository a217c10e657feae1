"""Actions that hold other actions: ``group``, ``timer`` and ``include``."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from teleopctl.launch.finding import builtin_file
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch, Step
from teleopctl.launch.model.template import Template
from teleopctl.packages import resolve_uri


@dataclass(frozen=True, slots=True, kw_only=True)
class Group(Action):
    """``group``: steps under one condition, with launch settings of their own if scoped.

    Attributes:
        scoped: Whether what the steps set ends with them.
        forwarding: Whether they see what was set before, where scoped.
        keep: Launch variables that are set for them, as name and value.
        steps: The steps.
    """

    keys = ("children", "scoped", "forwarding", "keep")

    scoped: bool
    steps: tuple[Step, ...]
    forwarding: bool = True
    keep: tuple[tuple[Template, Template], ...] = ()

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``group``."""
        scoped, forwarding = entity.element("scoped"), entity.element("forwarding")
        return cls(
            scoped=scoped is None or scoped.flag(),
            forwarding=forwarding is None or forwarding.flag(),
            keep=entity.pairs("keep", "name", "value"),
            steps=entity.steps("children"),
        )

    def evaluate(self, launch: Launch) -> None:
        """Run the steps."""
        with launch.scoped() if self.scoped else nullcontext():
            kept = [(launch.text(name), launch.text(value)) for name, value in self.keep]
            if self.scoped and not self.forwarding:
                launch.scope.environment.clear()
                launch.scope.reset()
            launch.scope.variables.update(kept)
            launch.run(self.steps)


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedEntities(Action):
    """``timer``: runs steps after a period.

    Attributes:
        period: Seconds from now, or from the start of the launch.
        steps: The steps.
        is_cancelled: Tells whether they are not to be taken after all.
        cancel_on_shutdown: Whether they are not to be taken when the launch ends.
    """

    keys = ("period", "children", "cancel_on_shutdown")

    period: Template
    steps: tuple[Step, ...]
    is_cancelled: Callable[[], bool] = bool
    cancel_on_shutdown: Template | None = None

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``timer``."""
        return cls(
            period=entity.required("period"),
            steps=entity.steps("children"),
            cancel_on_shutdown=entity.optional("cancel_on_shutdown"),
        )

    def evaluate(self, launch: Launch) -> None:
        """Start the timer."""
        seconds, cancel = self.settings(launch)
        launch.after(seconds, self.steps, self.is_cancelled, outlives_shutdown=not cancel)

    def settings(self, launch: Launch) -> tuple[float, bool]:
        """Return the period in seconds, and whether the end of the launch cancels the timer."""
        with values.at_key("period"):
            seconds = values.number(launch.text(self.period))
        cancel = True
        if self.cancel_on_shutdown is not None:
            with values.at_key("cancel_on_shutdown"):
                cancel = values.boolean(launch.text(self.cancel_on_shutdown))
        return seconds, cancel


@dataclass(frozen=True, slots=True, kw_only=True)
class Include(Action):
    """``include``: includes another launch file, with arguments."""

    keys = ("file", "arg", "let")

    file: Template
    arguments: tuple[tuple[Template, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read an ``include``."""
        return cls(
            file=entity.required("file"),
            arguments=(
                *entity.pairs("arg", "name", "value"),
                *entity.pairs("let", "name", "value"),
            ),
        )

    def evaluate(self, launch: Launch) -> None:
        """Include the launch file."""
        path = included_path(launch.text(self.file), launch.file)
        give(self.arguments, launch)
        launch.include(path)


@dataclass(frozen=True, slots=True, kw_only=True)
class IncludeSteps(Action):
    """Inclusion of steps that a program has made, as if they were a launch file."""

    steps: tuple[Step, ...]
    arguments: tuple[tuple[Template, Template], ...]

    def evaluate(self, launch: Launch) -> None:
        """Include the steps."""
        give(self.arguments, launch)
        launch.run(self.steps)


def give(arguments: tuple[tuple[Template, Template], ...], launch: Launch) -> None:
    """Set the launch arguments of an included file."""
    values = {launch.text(name): value for name, value in arguments}
    for name, value in values.items():
        launch.scope.variables[name] = launch.text(value)
    launch.scope.given |= values.keys()


def included_path(text: str, including: Path) -> Path:
    """Return the file that an ``include`` names.

    That is a path, a file beside the including one or in the current folder, or a built-in one; so
    a ``sim.yaml`` of one's own includes the built-in ``sim.yaml`` by its name.
    """
    path = resolve_uri(text)
    if path.is_absolute():
        return path
    candidates = [including.parent / path, path.absolute()]
    others = [file for file in candidates if file.is_file() and file != including]
    return next(iter(others), None) or builtin_file(text) or candidates[0]
