"""``launch.actions.for_loop``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ..action import Action
from ..utilities import normalize_to_list_of_substitutions, perform_substitutions

if TYPE_CHECKING:
    from ..launch_context import LaunchContext
    from ..launch_description_entity import LaunchDescriptionEntity
    from ..some_substitutions_type import SomeSubstitutionsType
    from ..substitution import Substitution

    # ...: the function takes the values of a turn by their names.
    MakeEntities = Callable[..., list[LaunchDescriptionEntity] | None]


class ForEach(Action):
    """Entities that a function makes for each of some sets of values.

    Args:
        input_values: YAML mappings with semicolons between.
        function: Called with the values of each by their names.
        kwargs: What `Action` takes.
    """

    SEPARATOR = ";"

    # Any: the words of Action.
    def __init__(
        self, input_values: SomeSubstitutionsType, *, function: MakeEntities, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._input_values = normalize_to_list_of_substitutions(input_values)
        self._function = function

    @property
    def input_values(self) -> list[Substitution]:
        """YAML mappings with semicolons between."""
        return self._input_values

    @property
    def function(self) -> MakeEntities:
        """Makes the entities."""
        return self._function

    def describe(self) -> str:
        """Return the action in words."""
        return (
            f"{type(self).__name__}(input_values='{self._input_values}', function={self._function})"
        )

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Make the entities."""
        from teleopctl.base import ros_yaml

        text = perform_substitutions(context, self._input_values)
        sets = [ros_yaml.safe_load(each) for each in text.split(self.SEPARATOR) if each.strip()]
        if not sets:
            context.launch.log("WARNING", "no input values: will not iterate", "launch")
        return [
            entity
            for values in sets
            if values is not None
            for entity in self._function(**values) or ()
        ]


class ForLoop(Action):
    """Entities that a function makes a number of times.

    Args:
        length: How often.
        function: Called with ``i``, the number of the turn, counted from 0.
        name: What `ForLoopIndex` calls that.
        kwargs: What `Action` takes.
    """

    # Any: the words of Action.
    def __init__(
        self,
        length: SomeSubstitutionsType,
        *,
        function: MakeEntities,
        name: str | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._length = normalize_to_list_of_substitutions(length)
        self._function = function
        self._name = name

    @property
    def length(self) -> list[Substitution]:
        """How often."""
        return self._length

    @property
    def function(self) -> MakeEntities:
        """Makes the entities."""
        return self._function

    @property
    def name(self) -> str | None:
        """What `ForLoopIndex` calls the number of the turn."""
        return self._name

    def describe(self) -> str:
        """Return the action in words."""
        return (
            f"{type(self).__name__}(length='{self._length}', name='{self._name}', "
            f"function={self._function})"
        )

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Make the entities."""
        length = int(perform_substitutions(context, self._length))
        return [entity for turn in range(length) for entity in self._function(i=turn) or ()]
