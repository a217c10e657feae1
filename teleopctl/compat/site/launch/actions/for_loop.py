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
    """Visits the entities that a function returns for each of several mappings of values.

    Args:
        input_values: YAML mappings with semicolons between.
        function: Called with the values of each by their names.
        kwargs: Further arguments of `Action`.
    """

    SEPARATOR = ";"

    # Any: arguments of `Action.`
    def __init__(
        self, input_values: SomeSubstitutionsType, *, function: MakeEntities, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self._input_values = normalize_to_list_of_substitutions(input_values)
        self._function = function

    @property
    def input_values(self) -> list[Substitution]:
        """YAML mappings, separated by semicolons."""
        return self._input_values

    @property
    def function(self) -> MakeEntities:
        """Function that returns the entities."""
        return self._function

    def describe(self) -> str:
        """Return a readable form of the action."""
        return (
            f"{type(self).__name__}(input_values='{self._input_values}', function={self._function})"
        )

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Call the function for each mapping; return the entities."""
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
    """Visits the entities that a function returns for each index from 0.

    Args:
        length: Number of iterations.
        function: Called with ``i``, the number of the turn, counted from 0.
        name: Name of the index for `ForLoopIndex`.
        kwargs: Further arguments of `Action`.
    """

    # Any: arguments of `Action.`
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
        """Number of iterations."""
        return self._length

    @property
    def function(self) -> MakeEntities:
        """Function that returns the entities."""
        return self._function

    @property
    def name(self) -> str | None:
        """Name of the index for `ForLoopIndex`."""
        return self._name

    def describe(self) -> str:
        """Return a readable form of the action."""
        return (
            f"{type(self).__name__}(length='{self._length}', name='{self._name}', "
            f"function={self._function})"
        )

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Call the function for each index; return the entities."""
        length = int(perform_substitutions(context, self._length))
        return [entity for turn in range(length) for entity in self._function(i=turn) or ()]
