"""``launch.conditions.launch_configuration_equals``."""

from __future__ import annotations

import warnings

from ..condition import Condition
from ..launch_context import LaunchContext
from ..some_substitutions_type import SomeSubstitutionsType
from ..utilities import normalize_to_list_of_substitutions, perform_substitutions


class LaunchConfigurationEquals(Condition):
    """Holds if a launch configuration has a value; `EqualsSubstitution` replaces it.

    Args:
        launch_configuration_name: The variable.
        expected_value: The value; None where it is not to be set at all.
    """

    def __init__(
        self, launch_configuration_name: str, expected_value: SomeSubstitutionsType | None
    ) -> None:
        warnings.warn(
            "The 'LaunchConfigurationEquals' and 'LaunchConfigurationNotEquals' Conditions are "
            " deprecated. Use the 'EqualsSubstitution' and 'NotEqualsSubstitution' substitutions "
            "instead! E.g.:\n  IfCondition(\n  \tEqualsSubstitution("
            "LaunchConfiguration('some_launch_arg'), \"some_equality_check\")\n  )",
            UserWarning,
            stacklevel=2,
        )
        super().__init__(predicate=self._holds)
        self._name = launch_configuration_name
        self._expected = (
            None if expected_value is None else normalize_to_list_of_substitutions(expected_value)
        )

    def describe(self) -> str:
        """Return a readable form of the condition."""
        return repr(self)

    def _holds(self, context: LaunchContext) -> bool:
        is_set = self._name in context.launch_configurations
        if self._expected is None:
            return not is_set
        expected = perform_substitutions(context, self._expected)
        return is_set and context.launch_configurations[self._name] == expected
