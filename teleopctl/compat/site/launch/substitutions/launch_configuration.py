"""``launch.substitutions.launch_configuration``."""

from teleopctl.launch import Template

from .._texts import optional, template
from ..some_substitutions_type import SomeSubstitutionsType
from ..substitution import Substitution, call


class LaunchConfiguration(Substitution):
    """The value of a launch variable.

    Args:
        variable_name: Its name.
        default: What stands for it where nobody has set it; None makes that an error.
    """

    # object: texts, numbers and truth values are all in use.
    def __init__(
        self, variable_name: SomeSubstitutionsType, *, default: object | None = None
    ) -> None:
        super().__init__()
        self._name = template(variable_name)
        self._default = optional(default)

    def template(self) -> Template:
        """Return it as the model has it."""
        default = () if self._default is None else (self._default,)
        return call("var", self._name, *default, source=self.describe())

    def describe(self) -> str:
        """Return it in words."""
        return f"LaunchConfig('{self._name.source}')"
