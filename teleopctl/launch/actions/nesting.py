"""Actions that hold other actions: ``group``, ``timer``, ``include``, ``for`` and ``for_each``."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

from teleopctl.base.typed import Callable, Iterable, Mapping, Self
from teleopctl.errors import LaunchError
from teleopctl.launch.finding import builtin_file
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch, Step
from teleopctl.launch.model.records import dataclass
from teleopctl.launch.model.template import Template
from teleopctl.packages import resolve_uri


@dataclass(frozen=True, slots=True, kw_only=True)
class Group(Action):
    """``group``: runs actions under one condition; if scoped, their settings end with the group.

    Attributes:
        scoped: Whether settings of the steps end with the group.
        forwarding: Whether a scoped group starts with the settings made before it.
        keep: Launch configurations to set for the steps, as name and value.
        steps: Steps of the group.
    """

    keys = ("children", "scoped", "forwarding", "keep")

    scoped: bool
    steps: tuple[Step, ...]
    forwarding: bool = True
    keep: tuple[tuple[Template, Template], ...] = ()

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``group`` entry describes."""
        scoped, forwarding = entity.element("scoped"), entity.element("forwarding")
        return cls(
            scoped=scoped is None or scoped.flag(),
            forwarding=forwarding is None or forwarding.flag(),
            keep=entity.pairs("keep", "name", "value"),
            steps=entity.steps("children"),
        )

    def evaluate(self, launch: Launch) -> None:
        """Run the group's actions, and restore the settings afterwards if the group is scoped."""
        with launch.scoped() if self.scoped else nullcontext():
            kept = [(launch.text(name), launch.text(value)) for name, value in self.keep]
            if self.scoped and not self.forwarding:
                launch.scope.environment.clear()
                launch.scope.reset()
            launch.scope.variables.update(kept)
            launch.run(self.steps)


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedEntities(Action):
    """``timer``: runs actions after a period of wall time.

    Attributes:
        period: Delay in seconds from the evaluation of the action, or from the launch's start.
        steps: Steps to run when the timer fires.
        is_cancelled: Returns whether the timer was cancelled.
        cancel_on_shutdown: Whether a shutdown cancels the timer; None for true.
    """

    keys = ("period", "children", "cancel_on_shutdown")

    period: Template
    steps: tuple[Step, ...]
    is_cancelled: Callable[[], bool] = bool
    cancel_on_shutdown: Template | None = None

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``timer`` entry describes."""
        return cls(
            period=entity.required("period"),
            steps=entity.steps("children"),
            cancel_on_shutdown=entity.optional("cancel_on_shutdown"),
        )

    def evaluate(self, launch: Launch) -> None:
        """Add a timer to the launch that runs the actions after the period of wall time."""
        self.begin(launch, *self.settings(launch))

    def begin(self, launch: Launch, seconds: float, cancel: bool) -> None:
        """Add a timer of wall time to the launch, with what `settings` returned."""
        launch.after(seconds, self.steps, self.is_cancelled, outlives_shutdown=not cancel)

    def settings(self, launch: Launch) -> tuple[float, bool]:
        """Return the evaluated period in seconds, and whether a shutdown cancels the timer."""
        with values.at_key("period"):
            seconds = values.number(launch.text(self.period))
        cancel = True
        if self.cancel_on_shutdown is not None:
            with values.at_key("cancel_on_shutdown"):
                cancel = values.boolean(launch.text(self.cancel_on_shutdown))
        return seconds, cancel


@dataclass(frozen=True, slots=True, kw_only=True)
class Include(Action):
    """``include``: evaluates another launch file, with launch arguments."""

    keys = ("file", "arg", "let")

    file: Template
    arguments: tuple[tuple[Template, Template], ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that an ``include`` entry describes."""
        return cls(
            file=entity.required("file"),
            arguments=(
                *entity.pairs("arg", "name", "value"),
                *entity.pairs("let", "name", "value"),
            ),
        )

    def evaluate(self, launch: Launch) -> None:
        """Set the launch arguments, and evaluate the included launch file."""
        path = included_path(launch.text(self.file), launch.file)
        set_included_arguments(self.arguments, launch)
        launch.include(path)


@dataclass(frozen=True, slots=True, kw_only=True)
class IncludeSteps(Action):
    """Launch action that includes a launch description built by Python code, without a file."""

    steps: tuple[Step, ...]
    arguments: tuple[tuple[Template, Template], ...]

    def evaluate(self, launch: Launch) -> None:
        """Set the launch arguments, and run the steps of the included launch description."""
        set_included_arguments(self.arguments, launch)
        launch.run(self.steps)


def set_included_arguments(
    arguments: tuple[tuple[Template, Template], ...], launch: Launch
) -> None:
    """Evaluate the arguments for an included file, and set them as launch configurations."""
    values = {launch.text(name): value for name, value in arguments}
    for name, value in values.items():
        launch.scope.variables[name] = launch.text(value)
    launch.scope.given |= values.keys()


def included_path(text: str, including: Path) -> Path:
    """Return the included file's path: beside the including one, in the cwd, or built in.

    A relative path is looked for beside the including file, then in the current folder, then among
    the built-in files. The including file itself is skipped, so that a user's ``sim.yaml`` can
    include the built-in ``sim.yaml`` by its name.
    """
    path = resolve_uri(text)
    if path.is_absolute():
        return path
    candidates = [including.parent / path, path.absolute()]
    others = [file for file in candidates if file.is_file() and file != including]
    return next(iter(others), None) or builtin_file(text) or candidates[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class For(Action):
    """``for``: runs actions a number of times.

    Attributes:
        length: Number of iterations.
        name: Name by which ``$(index NAME)`` reads the index of the iteration, from 0.
        steps: Steps to run in each iteration.
    """

    keys = ("len", "name", "children")

    length: Template
    name: str
    steps: tuple[Step, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``for`` entry describes."""
        return cls(
            length=entity.required("len"),
            name=entity.required_text("name"),
            steps=entity.steps("children"),
        )

    def evaluate(self, launch: Launch) -> None:
        """Run the actions once for each index; ``$(index NAME)`` is the index, from 0."""
        with values.at_key("len"):
            length = values.integer(launch.text(self.length))
        _take(({self.name: str(turn)} for turn in range(length)), self.steps, launch)


@dataclass(frozen=True, slots=True, kw_only=True)
class ForEach(Action):
    """``for_each``: runs actions once for each of several sets of values.

    Attributes:
        sets: YAML mappings separated by semicolons; ``$(for-var NAME)`` reads a value of the
            iteration's mapping.
        steps: Steps to run in each iteration.
    """

    keys = ("values", "children")

    sets: Template
    steps: tuple[Step, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Return the action that a ``for_each`` entry describes."""
        return cls(sets=entity.required("values"), steps=entity.steps("children"))

    def evaluate(self, launch: Launch) -> None:
        """Run the actions once for each set of values, which ``$(for-var NAME)`` reads."""
        with values.at_key("values"):
            sets = [_mapping(text) for text in launch.text(self.sets).split(";") if text.strip()]
        if not sets:
            launch.log("WARNING", "no input values: will not iterate")
        _take(sets, self.steps, launch)


def _take(turns: Iterable[Mapping[str, str]], steps: tuple[Step, ...], launch: Launch) -> None:
    outer = launch.scope.loop_values
    for turn in turns:
        launch.scope.loop_values = {**outer, **turn}
        launch.run(steps)
    launch.scope.loop_values = outer


def _mapping(text: str) -> dict[str, str]:
    import yaml

    from teleopctl.base import ros_yaml

    try:
        value = ros_yaml.load(text)
    except yaml.YAMLError as error:
        raise LaunchError(f"'{text.strip()}' is not YAML: {error}") from error
    if not isinstance(value, dict):
        raise LaunchError(f"expected mappings with ';' between, got '{text.strip()}'")
    return {str(name): str(item) for name, item in value.items()}
