"""``for`` and ``for_each``: steps that are taken several times."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Self

import yaml

from teleopctl.base import ros_yaml
from teleopctl.errors import LaunchError
from teleopctl.launch.model import values
from teleopctl.launch.model.action import Action, Entity, Launch, Step
from teleopctl.launch.model.template import Template


@dataclass(frozen=True, slots=True, kw_only=True)
class For(Action):
    """``for``: repeats steps a number of times.

    Attributes:
        length: How often.
        name: What ``$(index NAME)`` calls the number of the turn, counted from 0.
        steps: The steps.
    """

    keys = ("len", "name", "children")

    length: Template
    name: str
    steps: tuple[Step, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``for``."""
        return cls(
            length=entity.required("len"),
            name=entity.required_text("name"),
            steps=entity.steps("children"),
        )

    def evaluate(self, launch: Launch) -> None:
        """Run the steps."""
        with values.at_key("len"):
            length = values.integer(launch.text(self.length))
        _take(({self.name: str(turn)} for turn in range(length)), self.steps, launch)


@dataclass(frozen=True, slots=True, kw_only=True)
class ForEach(Action):
    """``for_each``: repeats steps for each of some sets of values.

    Attributes:
        sets: YAML mappings with semicolons between; ``$(for-var NAME)`` is a value of the turn's.
        steps: The steps.
    """

    keys = ("values", "children")

    sets: Template
    steps: tuple[Step, ...]

    @classmethod
    def parse(cls, entity: Entity) -> Self:
        """Read a ``for_each``."""
        return cls(sets=entity.required("values"), steps=entity.steps("children"))

    def evaluate(self, launch: Launch) -> None:
        """Run the steps."""
        with values.at_key("values"):
            sets = [_mapping(text) for text in launch.text(self.sets).split(";") if text.strip()]
        if not sets:
            launch.say("WARNING", "no input values: will not iterate")
        _take(sets, self.steps, launch)


def _take(turns: Iterable[Mapping[str, str]], steps: tuple[Step, ...], launch: Launch) -> None:
    outer = launch.scope.loop_values
    for turn in turns:
        launch.scope.loop_values = {**outer, **turn}
        launch.run(steps)
    launch.scope.loop_values = outer


def _mapping(text: str) -> dict[str, str]:
    try:
        value = ros_yaml.load(text)
    except yaml.YAMLError as error:
        raise LaunchError(f"'{text.strip()}' is not YAML: {error}") from error
    if not isinstance(value, dict):
        raise LaunchError(f"expected mappings with ';' between, got '{text.strip()}'")
    return {str(name): str(item) for name, item in value.items()}
