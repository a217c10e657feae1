"""``launch.actions.declare_launch_argument``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from teleopctl.launch import DeclareArgument, Template

from .._texts import optional
from ..action import Action


class DeclareLaunchArgument(Action):
    """An argument of the launch file.

    Args:
        name: Its name.
        default_value: What it is where nobody gives it; None makes it required.
        description: What it is for.
        choices: What it may be; None for anything.
        kwargs: What `Action` takes.

    Raises:
        ValueError: The choices are empty, or the default is none of them.
    """

    # Any: the words of Action. object: texts, numbers and truth values are all in use.
    def __init__(
        self,
        name: str,
        *,
        default_value: object | None = None,
        description: str | None = None,
        choices: Sequence[str] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        if choices is not None and not choices:
            raise ValueError(
                "Supplied choices were empty: did you mean None? Argument name: '" + name + "'"
            )
        self.name = name
        self.default_value: Template | None = optional(default_value)
        self.description = description or "no description given"
        self.choices = choices

    def model_action(self) -> DeclareArgument:
        """Return what the model does for it."""
        return DeclareArgument(
            name=self.name,
            default=self.default_value,
            description=self.description,
            choices=tuple(map(str, self.choices or ())),
        )
