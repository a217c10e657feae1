"""``launch.actions.declare_launch_argument``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from teleopctl.launch import DeclareArgument

from .._texts import optional
from ..action import Action
from ..substitution import Substitution
from ..utilities import normalize_to_list_of_substitutions


class DeclareLaunchArgument(Action):
    """An argument of the launch file.

    Args:
        name: Its name.
        default_value: Default value; None makes the argument required.
        description: Description for ``--show-args``.
        choices: Permitted values; None for any.
        kwargs: Further arguments of `Action`.

    Raises:
        RuntimeError: The choices are empty, or the default is none of them.
    """

    # Any: arguments of `Action.` object: texts with substitutions, numbers and truth values.
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
            raise RuntimeError("Provided choices arg is empty. Use None to ignore the choice list.")
        is_open = default_value is None or isinstance(default_value, Substitution | list)
        if choices is not None and not is_open and default_value not in choices:
            raise RuntimeError(
                f'Provided default_value "{default_value}" is not in provided choices "{choices}".'
            )
        default = optional(default_value)
        given: Any = default_value
        self._argument = DeclareArgument(
            name=name,
            default=default,
            description=description,
            choices=tuple(map(str, choices or ())),
        )
        self._default: list[Substitution] | None = None
        if default is not None:
            self._default = normalize_to_list_of_substitutions(
                default.source if default.is_literal else given
            )
        self._choices = choices
        self._conditionally_included = False

    @property
    def name(self) -> str:
        """Its name."""
        return self._argument.name

    @property
    def default_value(self) -> list[Substitution] | None:
        """Default value, or None."""
        return self._default

    @property
    def description(self) -> str:
        """Description, with the choices."""
        return self._argument.in_words

    @property
    def is_required(self) -> bool:
        """Whether the argument has no default value, as far as that is known before evaluation."""
        return self._default is None and not self._conditionally_included

    @property
    def choices(self) -> Sequence[str] | None:
        """Permitted values, or None for any."""
        return self._choices

    def model_action(self) -> DeclareArgument:
        """Return the corresponding action of `teleopctl.launch`."""
        return self._argument
